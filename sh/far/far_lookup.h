#pragma once
// Looks up what a part blocks at 8 receivers. Part of far_lanes.cpp.
#include "sh/far/far_turns.h"

namespace penumbra {

namespace {

// Eight points of a level around each receiver.
struct Level {
    Lanes share, part[3];
    Ints first;
    std::int32_t stride[3];
};

inline void boxLevel(const FarBox& box, const Lanes* p, Level& out) {
    out.first = Ints{} + box.first;
    Lanes depth = (kZeros + 1e30f);
    for (int axis = 0; axis < 3; ++axis) {
        const Lanes above = p[axis] - box.low[axis], below = box.high[axis] - p[axis];
        least(above, depth, depth);
        least(below, depth, depth);
        Lanes t = above * box.per_cell[axis], cell;
        clamp(t, kZeros, (kZeros + box.cells[axis]));
        least(t, (kZeros + box.cells[axis] - 1), cell);
        Ints whole;
        toInts(cell, whole);
        toFloats(whole, cell);
        out.part[axis] = t - cell;
        out.first += whole * box.stride[axis];
        out.stride[axis] = box.stride[axis];
    }
    out.share = depth * box.per_width;
    clamp(out.share, kZeros, (kZeros + 1));
}

inline void sphereLevel(const FarConstants& constants, const FarTable& table, const Lanes* offset, const Lanes& square,
                        Level& out) {
    constexpr std::int32_t kSide = 13;
    Lanes distance = square, u;
    root(distance);
    choose(distance > 0, table.radius / distance, (kZeros + 1), u);
    clamp(u, (kZeros + constants.sphere_scales[0]), (kZeros + constants.sphere_scales[kMaxSpheres - 1]));
    Lanes low = (kZeros + constants.sphere_scales[0]), high = (kZeros + constants.sphere_scales[1]);
    Ints sphere = {};
    for (int s = 1; s < kMaxSpheres - 1; ++s) {
        const Ints beyond = u > constants.sphere_scales[s];
        sphere -= beyond;
        choose(beyond, (kZeros + constants.sphere_scales[s]), low, low);
        choose(beyond, (kZeros + constants.sphere_scales[s + 1]), high, high);
    }
    // The octahedral map.
    Lanes magnitude[3];
    for (int axis = 0; axis < 3; ++axis) choose(offset[axis] < 0, -offset[axis], offset[axis], magnitude[axis]);
    const Lanes sum = magnitude[0] + magnitude[1] + magnitude[2];
    Lanes map[2];
    for (int axis = 0; axis < 2; ++axis) {
        Lanes there, sign;
        choose(offset[axis] >= 0, (kZeros + 1), (kZeros + -1), sign);
        choose(offset[2] >= 0, offset[axis] / sum, (1 - magnitude[1 - axis] / sum) * sign, there);
        choose(sum > 0, there, kZeros, map[axis]);
    }
    out.first = table.first_sphere + sphere * (kSide * kSide);
    const std::int32_t stride[3] = {kSide, 1, kSide * kSide};
    for (int axis = 0; axis < 3; ++axis) out.stride[axis] = stride[axis];
    for (int axis = 0; axis < 2; ++axis) {
        Lanes t = (map[axis] + 1) * (0.5f * (kSide - 1)), cell;
        clamp(t, kZeros, (kZeros + kSide - 1));
        least(t, (kZeros + kSide - 2), cell);
        Ints whole;
        toInts(cell, whole);
        toFloats(whole, cell);
        out.part[axis] = t - cell;
        out.first += whole * stride[axis];
    }
    out.part[2] = (u - low) / (high - low);
}

#ifdef __wasm_simd128__
// Sums eight corners of 40 bytes by weights of 15 bits, as whole numbers: two corners side by side, as combinePairs()
// has two components. A frame of a composed character takes 0.7 of the time that it takes where each byte is first made
// a float. A weight is rounded by 2^-16 at most, which moves E by 6e-5.
inline void sumCorners(const std::int8_t* const* corner, const float* weight, Lanes* out) {
    const v128_t none = wasm_i64x2_const(0, 0);
    v128_t sum[10] = {none, none, none, none, none, none, none, none, none, none};
    const auto add = [&](v128_t bytes, v128_t weights, v128_t * to) __attribute__((always_inline)) {
        to[0] = wasm_i32x4_add(to[0], wasm_i32x4_dot_i16x8(wasm_i16x8_extend_low_i8x16(bytes), weights));
        to[1] = wasm_i32x4_add(to[1], wasm_i32x4_dot_i16x8(wasm_i16x8_extend_high_i8x16(bytes), weights));
    };
#pragma clang loop unroll(full)
    for (int c = 0; c < 8; c += 2) {
        const auto first = std::uint32_t(weight[c] * 32767 + 0.5f),
                   second = std::uint32_t(weight[c + 1] * 32767 + 0.5f);
        const v128_t weights = wasm_i32x4_splat(std::int32_t(first | second << 16));
#pragma clang loop unroll(full)
        for (int i = 0; i < 40; i += 8) {
            const v128_t a = wasm_v128_load64_zero(corner[c] + i), b = wasm_v128_load64_zero(corner[c + 1] + i);
            add(wasm_i8x16_shuffle(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23), weights, sum + i / 4);
        }
    }
#pragma clang loop unroll(full)
    for (int i = 0; i < 5; ++i) {
        toFloats({(IntQuad)sum[2 * i], (IntQuad)sum[2 * i + 1]}, out[i]);
        out[i] *= 1.0f / 32767;
    }
}
#endif

// Adds the share of a level to the row of one receiver.
inline void addLevel(const FarTable& table, int level, const Level& at, std::size_t lane, Lanes* row) {
    const float x = at.part[0][lane], y = at.part[1][lane], z = at.part[2][lane], share = at.share[lane];
    const std::int8_t* first = table.points + std::int64_t(at.first[lane]) * kRow;
    const float weight[8] = {(1 - x) * (1 - y) * (1 - z), x * (1 - y) * (1 - z), (1 - x) * y * (1 - z), x * y * (1 - z),
                             (1 - x) * (1 - y) * z,       x * (1 - y) * z,       (1 - x) * y * z,       x * y * z};
    const std::int64_t dx = at.stride[0] * kRow, dy = at.stride[1] * kRow, dz = at.stride[2] * std::int64_t(kRow);
    const std::int8_t* const corner[8] = {first,      first + dx,      first + dy,      first + dx + dy,
                                          first + dz, first + dx + dz, first + dy + dz, first + dx + dy + dz};
#ifdef __wasm_simd128__
    Lanes sum[5];
    sumCorners(corner, weight, sum);
#else
    Lanes s0, s1, s2, s3, s4;
    const auto add = [&](int c, bool begins) __attribute__((always_inline)) {
        Lanes v0, v1, v2, v3, v4;
        loadBytes(corner[c], v0);
        loadBytes(corner[c] + 8, v1);
        loadBytes(corner[c] + 16, v2);
        loadBytes(corner[c] + 24, v3);
        loadBytes(corner[c] + 32, v4);
        const float w = weight[c];
        s0 = begins ? w * v0 : s0 + w * v0;
        s1 = begins ? w * v1 : s1 + w * v1;
        s2 = begins ? w * v2 : s2 + w * v2;
        s3 = begins ? w * v3 : s3 + w * v3;
        s4 = begins ? w * v4 : s4 + w * v4;
    };
    add(0, true);
    add(1, false);
    add(2, false);
    add(3, false);
    add(4, false);
    add(5, false);
    add(6, false);
    add(7, false);
    const Lanes sum[5] = {s0, s1, s2, s3, s4};
#endif
    for (int i = 0; i < 5; ++i) {
        Lanes scale;
        loadFloats(table.scale[level] + 8 * i, scale);
        row[i] += share * (scale * sum[i]);
    }
}

// Writes V - 1 of a part in its rest frame, for the receivers that are wanted, and 0 for others: out [40]. `inside`
// tells how dark it is inside the part, as sampleField() has it.
inline void sample(const FarConstants& constants, const FarTable& table, const FarPart& posed, const Frames& frames,
                   const Ints& wanted, Lanes* out, Lanes& inside) {
    Lanes point[3], offset[3];
    const Lanes* p = frames.position;
    for (int axis = 0; axis < 3; ++axis) {
        const float* m = posed.to_part + 4 * axis;
        point[axis] = m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3];
        offset[axis] = point[axis] - table.center[axis];
    }
    const Lanes square = offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2];
    Level levels[3] = {};
    boxLevel(table.boxes[0], point, levels[0]);
    boxLevel(table.boxes[1], point, levels[1]);
    levels[1].share *= 1 - levels[0].share;
    levels[2].share = 1 - levels[0].share - levels[1].share;
    if (any(levels[2].share > 0)) sphereLevel(constants, table, offset, square, levels[2]);
    // The corners of all receivers are on their way while the first of them are read.
    for (std::size_t lane = 0; lane < kLanes; ++lane)
        for (int level = 0; level < 3; ++level) {
            if (!wanted[lane] || !(levels[level].share[lane] > 0)) continue;
            const std::int8_t* first = table.points + std::int64_t(levels[level].first[lane]) * kRow;
            const std::int64_t dy = levels[level].stride[1] * kRow, dz = levels[level].stride[2] * std::int64_t(kRow);
            __builtin_prefetch(first);
            __builtin_prefetch(first + dy);
            __builtin_prefetch(first + dz);
            __builtin_prefetch(first + dy + dz);
        }
    Lanes rows[kLanes][5];
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        for (int i = 0; i < 5; ++i) rows[lane][i] = kZeros;
        if (!wanted[lane]) continue;
        for (int level = 0; level < 3; ++level)
            if (levels[level].share[lane] > 0) addLevel(table, level, levels[level], lane, rows[lane]);
    }
    for (std::size_t i = 0; i < 5; ++i) transpose((const float*)rows + 8 * i, kRow, out + 8 * i);
    const Lanes fine = levels[0].share;
    inside = out[kDistance] * (-table.per_fade * constants.dark);
    clamp(inside, kZeros, fine);
    const Lanes scale = 1 / (square + 0.25f * table.radius * table.radius);
    for (int i = 0; i < kFull; ++i) out[i] *= scale;
}

// Tells how high a part stands over the horizon of each receiver, as farVisibility() has it, and which receivers its
// sphere covers too little of.
inline void heightOf(const FarConstants& constants, const FarPart& posed, const Frames& frames, Lanes& height,
                     Lanes& sine, Ints& small) {
    Lanes way[3];
    for (int axis = 0; axis < 3; ++axis) way[axis] = posed.center[axis] - frames.position[axis];
    const Lanes* n = frames.normal;
    const Lanes along = way[0] * n[0] + way[1] * n[1] + way[2] * n[2];
    height = along * (1 / posed.radius);
    clamp(height, kZeros - 1, kZeros + 1);
    const Lanes square = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
    Lanes distance = square + 1e-20f;
    root(distance);
    sine = along / distance;
    const float radius2 = posed.radius * posed.radius;
    small = (kZeros + radius2) < 4 * constants.blocked[0] * (square - radius2);
}

// What a part blocks at the receivers that are wanted.
struct Blocked {
    Lanes numbers[kRow];  // V - 1 in its rest frame
    Lanes share;          // of the sphere
    Lanes weight;         // by which it counts
    Lanes inside;         // how dark it is inside of it
};

// Returns whether the part counts anywhere.
inline bool blockedBy(const FarConstants& constants, const FarTable& table, const FarPart& posed, const Frames& frames,
                      const Ints& wanted, Blocked& out) {
    sample(constants, table, posed, frames, wanted, out.numbers, out.inside);
    out.share = out.numbers[0] * (-1 / kRootOfSphere);
    out.weight = (out.share - constants.blocked[0]) * (1 / (constants.blocked[1] - constants.blocked[0]));
    clamp(out.weight, kZeros, kZeros + 1);
    Lanes solid = out.share * (1 / constants.solid);
    clamp(solid, kZeros, kZeros + 1);
    out.weight *= constants.overlap + (1 - constants.overlap) * solid;
    return any((out.weight > 0) | (out.inside > 0));
}

}  // namespace

}  // namespace penumbra
