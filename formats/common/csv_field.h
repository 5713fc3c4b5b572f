#pragma once
#include <string>
#include <string_view>

namespace penumbra {

// Returns the text as one field of a CSV file (RFC 4180).
inline std::string csvField(std::string_view text) {
    if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
    std::string out = "\"";
    for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
    return out + "\"";
}

}  // namespace penumbra
