#pragma once
#include <algorithm>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace penumbra {

// Returns "a, b, c" for any range of strings, or of things that have one: joined(clips, ", ", &Clip::name).
template <class Words, class TextOf = std::identity>
std::string joined(const Words& words, std::string_view separator = ", ", TextOf text_of = {}) {
    std::string text;
    for (const auto& word : words) {
        if (!text.empty()) text += separator;
        text += std::invoke(text_of, word);
    }
    return text;
}

// Lists names that an option takes with commas between (formats/common/name_list_option.h). Where some have commas
// themselves, all are quoted, and the list ends with how such a comma is written.
inline std::string listedNames(const std::vector<std::string>& names) {
    if (names.empty()) return "none";
    if (std::ranges::none_of(names, [](const std::string& name) { return name.find(',') != name.npos; }))
        return joined(names);
    return joined(names, ", ", [](const std::string& name) { return "'" + name + "'"; }) +
           " (a comma in a name is written \\,)";
}

}  // namespace penumbra
