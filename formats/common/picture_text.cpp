#include "formats/common/picture_text.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>

namespace penumbra {

std::optional<PictureSize> parseSize(const std::string& text) {
    long sides[2] = {};
    const char* at = text.c_str();
    for (int i = 0; i < 2; ++i) {
        if (i > 0 && *at++ != 'x') return std::nullopt;
        char* end = nullptr;
        sides[i] = std::strtol(at, &end, 10);  // a number that no long holds comes as the largest
        constexpr std::numeric_limits<int> kInt;
        if (end == at || sides[i] < kInt.min() || sides[i] > kInt.max()) return std::nullopt;
        at = end;
    }
    if (at != text.data() + text.size()) return std::nullopt;
    return PictureSize{int(sides[0]), int(sides[1])};
}

std::optional<Vec3> parseColor(const std::string& text) {
    Vec3 color;
    int used = 0;
    const int read = std::sscanf(text.c_str(), "%f/%f/%f%n", &color.x, &color.y, &color.z, &used);
    if (read != 3 || std::size_t(used) != text.size()) return std::nullopt;
    for (int i = 0; i < 3; ++i)
        if (!std::isfinite(color[i]) || color[i] < 0) return std::nullopt;
    return color;
}

}  // namespace penumbra
