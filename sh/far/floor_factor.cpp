// The visibility past a floor, mirrored at a tilted horizon.
//
// Problem: out_i = 2 integral of y_i over the directions that are above the receiver's horizon and above the floor.
//
// Naive: mirror the SH of the half space of the floor at the horizon. Six bands of a step ring, and half of that comes
// back in.
//
// Here: the directions are a lune between two planes. Where up lies in the xz plane, the numbers depend on the tilt of
// the normal alone, and those of sin(m phi) are 0. A table has the integrals of the others; turning up to its azimuth
// is a turn about z.
#include "sh/far/floor_factor.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <vector>

#include "sh/far/far_tables.h"
#include "sh/quadrature.h"
#include "sh/reflectance.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

constexpr std::size_t kTilts = 513;  // from 0 to pi
using FloorRow = std::array<float, kFarCoefficients>;

std::size_t evenPlaceOf(int l, int m) { return std::size_t(l * (l + 1) / 2 + (m + l) / 2); }

// With s = (sin t cos p, cos t, sin t sin p) the lune between the planes z = 0 and s . up = 0 is p in [0, pi - tilt].
FloorRow integrateLune(double tilt) {
    static const std::vector<WeightedNumber> nodes = gaussInterval(24);
    std::array<double, kFarCoefficients> sum{};
    std::vector<double> y(kFieldCoefficients);
    const std::vector<int> even = evenIndices(kFieldOrder);
    const double lune = std::numbers::pi - tilt;
    for (const WeightedNumber& along : nodes)
        for (const WeightedNumber& across : nodes) {
            const double t = std::numbers::pi * along.x, p = lune * across.x;
            evalBasis(kFieldOrder, Vec3d{std::sin(t) * std::cos(p), std::cos(t), std::sin(t) * std::sin(p)}, y);
            const double weight = 2 * std::numbers::pi * lune * along.weight * across.weight * std::sin(t);
            for (std::size_t e = 0; e < kFarCoefficients; ++e) sum[e] += weight * y[std::size_t(even[e])];
        }
    FloorRow row;
    std::copy(sum.begin(), sum.end(), row.begin());
    return row;
}

const std::vector<FloorRow>& floorTable() {
    static const std::vector<FloorRow> table = [] {
        std::vector<FloorRow> rows;
        for (std::size_t t = 0; t < kTilts; ++t)
            rows.push_back(integrateLune(std::numbers::pi * double(t) / double(kTilts - 1)));
        return rows;
    }();
    return table;
}

}  // namespace

void floorVisibility(std::span<const Vec3> normals, std::span<const Vec3> tangents, std::span<float> out) {
    assert(out.size() == normals.size() * kFarCoefficients && tangents.size() == normals.size());
    const std::vector<FloorRow>& table = floorTable();
    for (std::size_t r = 0; r < normals.size(); ++r) {
        const Vec3 up{tangents[r].y, cross(normals[r], tangents[r]).y, normals[r].y};
        const float across = std::hypot(up.x, up.y);
        const float at = std::clamp(std::atan2(across, up.z), 0.0f, std::numbers::pi_v<float>) *
                         (float(kTilts - 1) / std::numbers::pi_v<float>);
        const std::size_t low = std::min(std::size_t(at), kTilts - 2);
        const float part = at - float(low);
        std::array<float, kFieldOrder> cosine{1}, sine{0};
        const float c = across > 0 ? up.x / across : 1, s = across > 0 ? up.y / across : 0;
        for (std::size_t m = 1; m < kFieldOrder; ++m) {
            cosine[m] = cosine[m - 1] * c - sine[m - 1] * s;
            sine[m] = sine[m - 1] * c + cosine[m - 1] * s;
        }
        float* const row = out.data() + r * kFarCoefficients;
        for (int l = 0; l < kFieldOrder; ++l)
            for (int m = l % 2; m <= l; m += 2) {
                const std::size_t e = evenPlaceOf(l, m);
                const float value = table[low][e] + part * (table[low + 1][e] - table[low][e]);
                row[evenPlaceOf(l, -m)] = value * sine[std::size_t(m)];
                row[e] = value * cosine[std::size_t(m)];
            }
    }
}

void multiplyByFloor(const FarPath& path, std::span<const Vec3> normals, std::span<const Vec3> tangents,
                     std::span<float> far) {
    std::array<float, kMaxReceivers * kFarCoefficients> floor;
    for (std::size_t first = 0; first < normals.size(); first += kMaxReceivers) {
        const std::size_t n = std::min(kMaxReceivers, normals.size() - first);
        floorVisibility(normals.subspan(first, n), tangents.subspan(first, n),
                        std::span(floor).first(n * kFarCoefficients));
        path.compose(productConstants(kFieldOrder), floor.data(), nullptr, n, kFarCoefficients,
                     far.data() + first * kFarCoefficients);
    }
}

}  // namespace penumbra
