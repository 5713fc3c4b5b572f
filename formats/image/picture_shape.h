#pragma once
// Which shapes pictures of a whole sphere have. Programs that resize by a factor leave lat-long pictures a pixel or two
// off 2:1; those are read as if they were exact.
#include <cstdlib>
#include <string_view>

namespace penumbra {

struct PictureSides {
    int width = 0, height = 0;
};

// Tells whether the sides are `columns` : `rows`.
constexpr bool hasShape(PictureSides sides, int columns, int rows) {
    return sides.width % columns == 0 && sides.height % rows == 0 && sides.width / columns == sides.height / rows;
}
// 2:1, and from 16 rows on also a width or height that is one pixel off.
constexpr bool isLatLongShape(PictureSides sides) {
    const int off = sides.width - 2 * sides.height, most = sides.height >= 16 ? 2 : 0;
    return off >= -most && off <= most;
}
constexpr bool isCrossShape(PictureSides sides) { return hasShape(sides, 3, 4) || hasShape(sides, 4, 3); }
// Six faces, one below the other.
constexpr bool isStripShape(PictureSides sides) { return hasShape(sides, 1, 6); }

// Tells whether a picture of these sides may have this layout; of "", any that needs no name.
constexpr bool hasLayoutShape(PictureSides sides, std::string_view layout) {
    if (layout == "latlong") return isLatLongShape(sides);
    if (layout == "angular" || layout == "ball") return sides.width == sides.height;
    if (layout == "cube") return isCrossShape(sides) || isStripShape(sides);
    return isLatLongShape(sides) || isCrossShape(sides) || isStripShape(sides);
}

}  // namespace penumbra
