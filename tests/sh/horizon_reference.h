#pragma once
// The plain form of horizons and of what lies above them, one point at a time. It is the reference for
// sh/height/height_lanes.cpp.
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <span>

#include "sh/height/horizon.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace horizon_reference {

// The two points around a place of one axis of a level, and how far it is from the first.
struct Between {
    int low, high;
    float share;
};

// `at` is in texels of level 0; a tap beyond the border has been wrapped.
inline Between between(float at, int level, int count, bool wraps) {
    const float scale = std::ldexp(1.0f, -level);
    float x = (at + 0.5f) * scale - 0.5f;
    if (!wraps) x = std::clamp(x, 0.0f, float(count - 1));
    const float low = std::floor(x);
    Between out{int(low), int(low) + 1, x - low};
    if (out.low < 0) out.low += count;
    if (out.high >= count) out.high = wraps ? 0 : count - 1;
    return out;
}

inline float sample(const HeightField& field, int level, float row, float column) {
    const HeightLevel& at = field.levels()[std::size_t(level)];
    const bool wraps = field.grid().border == HeightBorder::kPeriodic;
    const Between r = between(row, level, at.rows, wraps), c = between(column, level, at.columns, wraps);
    const float* const heights = field.allHeights() + at.first;
    const auto h = [&](int i, int j) { return heights[std::size_t(i) * std::size_t(at.columns) + std::size_t(j)]; };
    const float upper = h(r.low, c.low) + c.share * (h(r.low, c.high) - h(r.low, c.low)),
                lower = h(r.high, c.low) + c.share * (h(r.high, c.high) - h(r.high, c.low));
    return upper + r.share * (lower - upper);
}

inline bool isInside(const HeightGrid& grid, float row, float column) {
    return row >= -0.5f && row <= float(grid.rows) - 0.5f && column >= -0.5f && column <= float(grid.columns) - 0.5f;
}

}  // namespace horizon_reference

// Writes the tangents of the horizons at a place of the grid and a height: the largest slope to any tap. A point below
// the field sees what the point above it sees.
inline void horizonTangents(const HeightField& field, const HorizonTaps& taps, float row, float column, float height,
                            std::span<float> tangents) {
    const HeightGrid& grid = field.grid();
    height = std::max(height, field.at(row, column));
    for (std::size_t a = 0; a < tangents.size(); ++a) {
        float most = leastHorizon(grid.border);
        for (std::size_t k = 0; k < taps.count; ++k) {
            const HorizonTap& tap = taps.taps[a * taps.count + k];
            float r = row + tap.row, c = column + tap.column;
            if (grid.border == HeightBorder::kOpen && !horizon_reference::isInside(grid, r, c)) continue;
            if (grid.border == HeightBorder::kPeriodic) {
                r -= float(grid.rows) * std::floor(r / float(grid.rows));
                c -= float(grid.columns) * std::floor(c / float(grid.columns));
            }
            most = std::max(most, (horizon_reference::sample(field, tap.level, r, c) - height) * tap.per_metre);
        }
        tangents[a] = most;
    }
}

// Writes the same for the true, bilinear field by steps of `step` texels.
inline void traceHorizon(const HeightField& field, float row, float column, float step, std::span<double> tangents) {
    const HeightGrid& grid = field.grid();
    const double height = double(field.at(row, column));
    const double farthest = 1.42 * std::max(grid.rows, grid.columns);
    for (std::size_t a = 0; a < tangents.size(); ++a) {
        const double phi = horizonAzimuth(int(a), int(tangents.size())), x = std::cos(phi) / double(grid.cell_x),
                     y = std::sin(phi) / double(grid.cell_y), metres = 1 / std::hypot(x, y);
        double most = double(leastHorizon(grid.border));
        for (double t = double(step); t < farthest; t += double(step)) {
            const double r = double(row) + t * metres * x, c = double(column) + t * metres * y;
            const bool inside = r >= 0 && r <= grid.rows - 1 && c >= 0 && c <= grid.columns - 1;
            if (!inside && grid.border == HeightBorder::kOpen) break;
            most = std::max(most, (double(field.at(float(r), float(c))) - height) / (t * metres));
        }
        tangents[a] = most;
    }
}

// Theta_lm, the radial part, for 0 <= m <= l < order <= kMaxHeightOrder, at l (l + 1) / 2 + m. `tangent` is that of
// the horizon.
inline void horizonThetas(int order, double tangent, std::span<double> out) {
    assert(order >= 1 && order <= kMaxHeightOrder && out.size() == std::size_t(order * (order + 1) / 2));
    const double c = 1 / std::sqrt(1 + tangent * tangent), s = tangent * c, b = std::atan2(c, s), s2 = s * s,
                 c2 = c * c, c3 = c2 * c, c5 = c3 * c2;
    const double j0 = (b - s * c) / 2, j2 = (b + s * c * (1 - 2 * s2)) / 8;
    const std::array<double, 15> integrals = {
        1 - s,
        c2 / 2,
        -j0,
        s * c2 / 2,
        -c3,
        2 - 3 * s + s2 * s,
        c2 * (5 * s2 - 1) / 8,
        -1.5 * (5 * j2 - j0),
        15 * c2 * c2 / 4,
        -15 * (3 * b - s * c * (5 - 2 * s2)) / 8,
        s * c2 * (7 * s2 - 3) / 8,
        -10 * c3 / 3 + 3.5 * c5,
        2 + s * (7.5 + s2 * (-20 + 10.5 * s2)),
        -21 * c5,
        56 + s * (-105 + s2 * (70 - 21 * s2)),
    };
    for (int l = 0, i = 0; l < order; ++l)
        for (int m = 0; m <= l; ++m, ++i) {
            double factorials = 1;  // (l - m)! / (l + m)!
            for (int k = l - m + 1; k <= l + m; ++k) factorials /= k;
            const double norm = std::sqrt((2 * l + 1) / (4 * std::numbers::pi) * factorials);
            out[std::size_t(i)] = (m > 0 ? std::numbers::sqrt2 : 1) * norm * integrals[std::size_t(i)];
        }
}

// Writes the SH [order^2] of what lies above horizons at uniform azimuths.
inline void horizonVisibility(int order, std::span<const double> tangents, std::span<double> out) {
    assert(out.size() == std::size_t(coefficientCount(order)));
    std::ranges::fill(out, 0.0);
    std::array<double, 15> thetas;
    const std::span<double> used = std::span(thetas).first(std::size_t(order * (order + 1) / 2));
    const int azimuths = int(tangents.size());
    for (int a = 0; a < azimuths; ++a) {
        horizonThetas(order, tangents[std::size_t(a)], used);
        const double phi = horizonAzimuth(a, azimuths), share = 2 * std::numbers::pi / azimuths;
        for (int l = 0, i = 0; l < order; ++l)
            for (int m = 0; m <= l; ++m, ++i) {
                out[std::size_t(shIndex(l, m))] += share * thetas[std::size_t(i)] * std::cos(m * phi);
                if (m > 0) out[std::size_t(shIndex(l, -m))] += share * thetas[std::size_t(i)] * std::sin(m * phi);
            }
    }
}

}  // namespace penumbra
