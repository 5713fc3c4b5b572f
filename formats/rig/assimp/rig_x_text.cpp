// Repairs what assimp does not read of DirectX .x text files.
#include <cctype>

#include "formats/rig/rig_import.h"

namespace penumbra {

namespace {

std::size_t skipBlanks(const std::string& text, std::size_t at) {
    while (at < text.size() && std::isspace(static_cast<unsigned char>(text[at]))) ++at;
    return at;
}

// Returns the place behind `c`, which stands at `at` behind blanks, or npos where something else does.
std::size_t behind(const std::string& text, std::size_t at, char c) {
    at = skipBlanks(text, at);
    return at < text.size() && text[at] == c ? at + 1 : std::string::npos;
}

// Returns the end of SkinWeights { "NAME"; 0; ... }, whose name ends at `at`, or npos where it is something else.
std::size_t endOfEmptyWeights(const std::string& text, std::size_t at) {
    at = text.find_first_of("{}\"", at);  // a data object may have a name of its own
    if (at == std::string::npos || text[at] != '{') return std::string::npos;
    at = behind(text, at + 1, '"');
    if (at == std::string::npos) return at;
    at = text.find('"', at);
    if (at == std::string::npos) return at;
    at = behind(text, at + 1, ';');
    if (at == std::string::npos) return at;
    at = behind(text, at, '0');
    if (at == std::string::npos) return at;
    at = behind(text, at, ';');
    return at == std::string::npos ? at : text.find('}', at);
}

}  // namespace

std::string withoutEmptyWeights(const std::string& text) {
    const std::string word = "SkinWeights";
    std::string out;
    std::size_t from = 0;  // text before this place is in `out` or left out
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + word.size())) {
        const std::size_t end = at < from ? std::string::npos : endOfEmptyWeights(text, at + word.size());
        if (end == std::string::npos) continue;
        out.append(text, from, at - from);
        from = end + 1;
    }
    return out.append(text, from);
}

}  // namespace penumbra
