#include "formats/rig/rig_build.h"

namespace penumbra {

std::string cleanText(std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < ' ' || c == 127) c = '_';
    return text;
}

}  // namespace penumbra
