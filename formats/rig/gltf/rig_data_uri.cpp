// Decodes data URIs (RFC 2397): data:[TYPE][;PARAMETER=VALUE...][;base64],DATA. tinygltf's own decoder knows a few
// types by heart and refuses the others.
#include <array>
#include <cctype>

#include "formats/rig/gltf/rig_gltf.h"

namespace penumbra {

namespace {

// Returns the value of a digit of base 64, in either alphabet of RFC 4648, or -1.
int base64Digit(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    if (c == '+' || c == '-') return 62;
    return c == '/' || c == '_' ? 63 : -1;
}

std::optional<std::vector<unsigned char>> fromBase64(const std::string& text) {
    std::vector<unsigned char> bytes;
    std::uint32_t bits = 0;
    int held = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (std::isspace(static_cast<unsigned char>(text[i]))) continue;
        if (text[i] == '=') {
            if (text.find_first_not_of("= \t\r\n", i) != std::string::npos) return std::nullopt;
            break;
        }
        const int digit = base64Digit(text[i]);
        if (digit < 0) return std::nullopt;
        bits = bits << 6 | std::uint32_t(digit);
        held += 6;
        if (held >= 8) bytes.push_back(static_cast<unsigned char>(bits >> (held -= 8)));
    }
    return bytes;
}

}  // namespace

std::optional<std::vector<unsigned char>> decodeDataUri(const std::string& uri) {
    const std::size_t comma = uri.find(',');
    if (uri.rfind("data:", 0) != 0 || comma == std::string::npos) return std::nullopt;
    std::string head = uri.substr(0, comma);
    for (char& c : head) c = char(std::tolower(static_cast<unsigned char>(c)));
    const std::string data = percentDecoded(uri.substr(comma + 1));
    // Some writers leave out the semicolon with the type: "data:base64,".
    const bool is_base64 = head.ends_with(";base64") || head == "data:base64";
    if (is_base64) return fromBase64(data);
    return std::vector<unsigned char>(data.begin(), data.end());
}

}  // namespace penumbra
