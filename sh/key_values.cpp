#include "sh/key_values.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace penumbra {

namespace {

// Returns the parts before and after the first `separator`. The second is empty when there is none.
std::pair<std::string_view, std::string_view> cut(std::string_view text, char separator) {
    const std::size_t at = text.find(separator);
    if (at == std::string_view::npos) return {text, {}};
    return {text.substr(0, at), text.substr(at + 1)};
}

// Returns whether all of `text` is a number.
bool readNumber(std::string_view text, double& value) {
#ifdef __cpp_lib_to_chars
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size();
#else  // before libc++ 20; WebAssembly has one locale
    const std::string whole(text);
    char* end = nullptr;
    value = std::strtod(whole.c_str(), &end);
    return !whole.empty() && end == whole.c_str() + whole.size();
#endif
}

template <class T>
std::string shortestText(T value) {
#ifdef __wasm__  // to_chars would bring tables of 125 KB into the module
    char text[32];
    for (int digits = 1; digits <= std::numeric_limits<T>::max_digits10; ++digits) {
        std::snprintf(text, sizeof text, "%.*g", digits, double(value));
        if (T(std::strtod(text, nullptr)) == value) break;
    }
    // to_chars writes a whole number without an exponent where that is no longer: 20, not 2e+01.
    char plain[32] = "";
    if (std::abs(double(value)) < 1e15 && value == std::trunc(value))
        std::snprintf(plain, sizeof plain, "%.0f", double(value));
    return *plain && std::strlen(plain) <= std::strlen(text) ? plain : text;
#else
    char buffer[32];
    return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
#endif
}

}  // namespace

std::vector<KeyValue> splitKeyValues(std::string_view text) {
    std::vector<KeyValue> items;
    if (text.empty()) return items;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        const std::string_view item = text.substr(begin, end - begin);
        const auto [key, value] = cut(item, '=');
        if (key.empty() || value.empty())
            throw std::invalid_argument("expected key=value, not '" + std::string(item) + "'");
        for (const KeyValue& before : items)
            if (before.key == key) throw std::invalid_argument("'" + std::string(key) + "' is given twice");
        items.push_back({key, value});
        begin = end + 1;
    }
    return items;
}

std::string shortest(double value) { return shortestText(value); }
std::string shortest(float value) { return shortestText(value); }

double parseNumber(std::string_view what, std::string_view text, double least, double most) {
    double value = 0;
    if (!readNumber(text, value) || !(value >= least && value <= most))
        throw std::invalid_argument(std::string(what) + " must be a number from " + shortest(least) + " to " +
                                    shortest(most) + ", not '" + std::string(text) + "'");
    return value;
}

Vec3d parseTriple(std::string_view what, std::string_view text, double least, double most) {
    const auto count = std::count(text.begin(), text.end(), '/');
    if (count == 0) {
        const double value = parseNumber(what, text, least, most);
        return {value, value, value};
    }
    if (count != 2)
        throw std::invalid_argument(std::string(what) + " must be three numbers like 1/0.5/0, not '" +
                                    std::string(text) + "'");
    const auto [x, rest] = cut(text, '/');
    const auto [y, z] = cut(rest, '/');
    return {parseNumber(what, x, least, most), parseNumber(what, y, least, most), parseNumber(what, z, least, most)};
}

}  // namespace penumbra
