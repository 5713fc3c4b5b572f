#include "bake/common/print_json.h"

#include <algorithm>
#include <cstdio>
#include <string>

namespace penumbra {

namespace {

using Json = nlohmann::ordered_json;

// Writes a value as it stands on a line.
std::string shortText(const Json& value) {
    if (value.is_string()) return value.get<std::string>();
    if (value.is_number_float()) {
        char text[32];
        std::snprintf(text, sizeof text, "%.6g", value.get<double>());
        return text;
    }
    if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
    return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// Prints one line. Control characters in a name of a file must not reach the terminal.
void printLine(const std::string& indent, const std::string& key, std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < ' ' || c == 127) c = ' ';
    std::printf("%s%-*s %s\n", indent.c_str(), int(22 - std::min<std::size_t>(indent.size(), 20)), key.c_str(),
                text.c_str());
}

// Tells whether a value has no arrays or objects inside, so that it fits on one line.
bool isFlat(const Json& value) {
    return std::none_of(value.begin(), value.end(), [](const Json& item) { return item.is_structured(); });
}

void print(const std::string& indent, const Json& object) {
    for (const auto& [name_or_index, value] : object.items()) {
        const std::string key = object.is_array() ? "-" : name_or_index;
        if (!value.is_structured()) {
            printLine(indent, key, shortText(value));
        } else if (isFlat(value)) {
            std::string text;
            for (const auto& [name, item] : value.items())
                text += (text.empty() ? "" : ", ") + (value.is_object() ? name + " " : "") + shortText(item);
            printLine(indent, key, text);
        } else {
            printLine(indent, key, "");
            print(indent + "  ", value);
        }
    }
}

}  // namespace

void printJson(const nlohmann::ordered_json& object) { print("", object); }

}  // namespace penumbra
