// Colours of other primaries become linear Rec.709.
//
// Problem: a file gives light as amounts of its own red, green and blue, whose sum at (1, 1, 1) is its own white. Ours
// are those of Rec.709 with the white of D65.
//
// Naive: go through XYZ. Then the white of ACEScg (about 6000 K) becomes a yellowish Rec.709, and a grey room looks
// tinted.
//
// Here: M = N709^-1 A N. N takes RGB to XYZ (SMPTE RP 177-1993). A is Bradford's adaptation of the white points (Lam
// 1985; the form of ICC.1:2010, annex E): A = B^-1 diag(B w709 / B w) B.
#include "formats/image/color_space.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "formats/common/joined.h"

namespace penumbra {

namespace {

struct NamedPrimaries {
    std::string_view name;
    Primaries primaries;
};

constexpr std::array<NamedPrimaries, 5> kSpaces = {{
    {"acescg", {{0.713, 0.293}, {0.165, 0.830}, {0.128, 0.044}, {0.32168, 0.33767}}},
    {"aces2065-1", {{0.7347, 0.2653}, {0.0, 1.0}, {0.0001, -0.0770}, {0.32168, 0.33767}}},
    {"rec2020", {{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, {0.3127, 0.3290}}},
    {"p3-d65", {{0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, {0.3127, 0.3290}}},
    {"srgb-linear", kRec709Primaries},
}};

std::string plainName(std::string_view text) {
    std::string plain;
    for (char c : text)
        if (c != '.') plain += char(std::tolower(static_cast<unsigned char>(c)));
    return plain;
}

Mat3d inverse(const Mat3d& a) {
    Mat3d out = transposed(cofactor(a));
    for (double& m : out.m) m /= determinant(a);
    return out;
}

// Returns XYZ of luminance 1.
Vec3d xyzOf(Chromaticity c) { return {c.x / c.y, 1, (1 - c.x - c.y) / c.y}; }

// Returns RGB -> XYZ. The columns are the primaries, scaled so that (1, 1, 1) is white. Primaries may have y = 0 or
// less, so they are not divided by it.
Mat3d toXyz(const Primaries& p) {
    const auto column = [](Chromaticity c) { return Vec3d{c.x, c.y, 1 - c.x - c.y}; };
    const Mat3d directions = transposed(fromRows(column(p.red), column(p.green), column(p.blue)));
    const Vec3d amounts = inverse(directions) * xyzOf(p.white);
    return transposed(fromRows(amounts.x * column(p.red), amounts.y * column(p.green), amounts.z * column(p.blue)));
}

constexpr Mat3d kBradford{{0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296}};

Mat3d adaptation(Chromaticity from, Chromaticity to) {
    const Vec3d a = kBradford * xyzOf(from), b = kBradford * xyzOf(to);
    const Mat3d scale{{b.x / a.x, 0, 0, 0, b.y / a.y, 0, 0, 0, b.z / a.z}};
    return inverse(kBradford) * (scale * kBradford);
}

void checkPrimaries(const Primaries& p) {
    for (Chromaticity c : {p.red, p.green, p.blue, p.white})
        if (!(std::abs(c.x) <= 10) || !(std::abs(c.y) <= 10))
            throw std::invalid_argument("a chromaticity is not a number from -10 to 10");
    const double area = (p.green.x - p.red.x) * (p.blue.y - p.red.y) - (p.green.y - p.red.y) * (p.blue.x - p.red.x);
    if (std::abs(area) < 1e-4) throw std::invalid_argument("the three primaries lie on a line");
    if (p.white.y < 1e-3) throw std::invalid_argument("the white point has no luminance");
    const Vec3d cones = kBradford * xyzOf(p.white);
    if (!(std::min({cones.x, cones.y, cones.z}) > 1e-3))
        throw std::invalid_argument("an eye cannot adapt to the colour of the white point");
}

}  // namespace

Primaries primariesOf(std::string_view name) {
    for (const NamedPrimaries& space : kSpaces)
        if (space.name == plainName(name)) return space.primaries;
    throw std::invalid_argument("must be one of " + joined(kSpaces, ", ", &NamedPrimaries::name) + ", not '" +
                                std::string(name) + "'");
}

bool samePrimaries(const Primaries& a, const Primaries& b) {
    const auto same = [](Chromaticity p, Chromaticity q) { return std::hypot(p.x - q.x, p.y - q.y) <= 1e-3; };
    return same(a.red, b.red) && same(a.green, b.green) && same(a.blue, b.blue) && same(a.white, b.white);
}

std::string describePrimaries(const Primaries& p) {
    for (const NamedPrimaries& space : kSpaces)
        if (samePrimaries(space.primaries, p)) return std::string(space.name);
    char text[160];
    std::snprintf(text, sizeof text, "red %.4g %.4g, green %.4g %.4g, blue %.4g %.4g, white %.4g %.4g", p.red.x,
                  p.red.y, p.green.x, p.green.y, p.blue.x, p.blue.y, p.white.x, p.white.y);
    return text;
}

std::optional<Mat3d> toRec709(const Primaries& primaries) {
    checkPrimaries(primaries);
    if (samePrimaries(primaries, kRec709Primaries)) return std::nullopt;
    return inverse(toXyz(kRec709Primaries)) * (adaptation(primaries.white, kRec709Primaries.white) * toXyz(primaries));
}

Mat3d xyzToRec709() { return inverse(toXyz(kRec709Primaries)); }

}  // namespace penumbra
