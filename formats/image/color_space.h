#pragma once
// Colour spaces of light: the chromaticities (CIE 1931 x, y) of red, green, blue and white, and the matrix that takes
// linear colours to linear Rec.709. The white points are adapted by Bradford, so white stays (1, 1, 1). Colours outside
// of the gamut of Rec.709 get negative components: they are kept, because projections are linear.
#include <optional>
#include <string>
#include <string_view>

#include "sh/vec3.h"

namespace penumbra {

struct Chromaticity {
    double x = 0, y = 0;
};

struct Primaries {
    Chromaticity red, green, blue, white;
};

constexpr Primaries kRec709Primaries{{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}};

// Returns the primaries of acescg, aces2065-1, rec2020, p3-d65 or srgb-linear. Capitals and dots do not count, so
// "Rec.2020" is one of them. Throws std::invalid_argument, which lists the names, for any other text.
Primaries primariesOf(std::string_view name);
// Returns the name of these primaries where they have one (within 0.001), else their numbers.
std::string describePrimaries(const Primaries& primaries);
// Tells whether both are the same within 0.001, a rounding of published numbers.
bool samePrimaries(const Primaries& a, const Primaries& b);

// Returns the matrix from linear colours of these primaries to linear Rec.709, or none where they are those of Rec.709
// (within 0.001). Throws std::invalid_argument where they span no space: a coordinate that is no finite number, a white
// without luminance, or three primaries on a line.
std::optional<Mat3d> toRec709(const Primaries& primaries);
// Returns the matrix from CIE XYZ to linear Rec.709. Nothing is adapted: the white of D65 becomes (1, 1, 1).
Mat3d xyzToRec709();

}  // namespace penumbra
