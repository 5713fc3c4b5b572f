#include "formats/warning.h"

#include <algorithm>
#include <cstdio>

namespace penumbra {

void reportWarning(const char* program, const std::string& message) {
    std::fprintf(stderr, "%s: warning: %s\n", program, oneLine(message).c_str());
}

std::string oneLine(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 127; }, ' ');
    return text;
}

}  // namespace penumbra
