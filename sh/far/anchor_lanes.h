#pragma once
// Takes what anchors know to 8 receivers around them. Part of far_lanes.cpp and of sh/cast/cast_lanes.cpp.
#include "sh/far/far_kernel.h"
#include "sh/lanes.h"

namespace penumbra {

namespace {

// Tells how near a sphere is for anchors so far apart (kNearSpacings): 1 near, 0 far. `way` leads to its center.
inline void nearness(const Lanes* way, float radius, float spacing, Lanes& near) {
    Lanes distance = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
    root(distance);
    near = (kNearSpacings[1] - (distance - radius) * (1 / spacing)) * (1 / (kNearSpacings[1] - kNearSpacings[0]));
    clamp(near, kZeros, kZeros + 1);
}

// Takes the sums [kAnchorSums] of the block that begins with receiver `first`, and how near each part is: near[p *
// step]. There are whole vectors of parts.
inline void interpolate(const FarAnchors& anchors, std::size_t count, std::size_t first, Lanes* sums, Lanes* near,
                        std::size_t step) {
    constexpr std::size_t kMaxColumns = anchorStride(kMaxNearParts) / 8;
    const std::size_t columns = anchors.stride / 8;
    Lanes rows[kLanes][kMaxColumns];
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const std::size_t r = first + lane < count ? first + lane : count - 1;
        const std::uint16_t* anchor = anchors.anchor + r * kAnchorsOfReceiver;
        const float* weight = anchors.weight + r * kAnchorsOfReceiver;
        const float* from[kAnchorsOfReceiver];
        for (std::size_t a = 0; a < kAnchorsOfReceiver; ++a) from[a] = anchors.values + anchor[a] * anchors.stride;
        for (std::size_t i = 0; i < columns; ++i) {
            Lanes value;
            loadFloats(from[0] + 8 * i, value);
            Lanes sum = weight[0] * value;
            for (std::size_t a = 1; a < kAnchorsOfReceiver; ++a) {
                loadFloats(from[a] + 8 * i, value);
                sum += weight[a] * value;
            }
            rows[lane][i] = sum;
        }
    }
    const float* coefficients = (const float*)rows;
    for (std::size_t i = 0; i < kAnchorSums / 8; ++i) transpose(coefficients + 8 * i, 8 * kMaxColumns, sums + 8 * i);
    for (std::size_t i = kAnchorSums / 8; i < columns; ++i) {
        Lanes parts[8];
        transpose(coefficients + 8 * i, 8 * kMaxColumns, parts);
        for (std::size_t p = 0; p < 8; ++p) {
            clamp(parts[p], kZeros, kZeros + 1);
            near[(8 * i - kAnchorSums + p) * step] = parts[p];
        }
    }
}

}  // namespace

}  // namespace penumbra
