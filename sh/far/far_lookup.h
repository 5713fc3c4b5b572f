#pragma once
// Looks up what a part blocks at 8 receivers. Part of far_lanes.cpp.
#include "sh/far/far_turns.h"

namespace penumbra {

namespace {

// Eight points of a level around each receiver.
struct Level {
    Lanes share, part[3];
    Ints first, weights[4];  // weighCorners()
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

// Splits whole numbers in two: `share` of each goes to `second`, and what is left stays.
inline void split(const Lanes& share, Ints& whole, Ints& second) {
    Lanes number;
    toFloats(whole, number);
    toInts(share * number + 0.5f, second);
    whole = whole - second;
}

// Weights of the eight corners as whole numbers of 15 bits, two in one number: of first and first + x, the same at y,
// at z, and at y + z. They add up to kWholeWeight, so that what is rounded counts only as far as corners differ.
constexpr std::int32_t kWholeWeight = 32767;
inline void weighCorners(Level& at) {
    Ints edges[4];
    edges[0] = Ints{} + kWholeWeight;
    split(at.part[2], edges[0], edges[2]);
    split(at.part[1], edges[0], edges[1]);
    split(at.part[1], edges[2], edges[3]);
    for (int i = 0; i < 4; ++i) {
        Ints far;
        split(at.part[0], edges[i], far);
        at.weights[i] = edges[i] + far * 65536;
    }
}

// Adds 16 bytes, those of two corners in turn, times the two weights. What a byte counts in the sum is kPerByte.
#ifdef __AVX2__
constexpr float kPerByte = 1;
inline void addBytes(const Bytes& both, std::int32_t weights, Ints& sum) {
    addDots((DotWords)_mm256_cvtepi8_epi16((__m128i)both), weights, sum);
}
#else
constexpr float kPerByte = 256;  // to put a byte into the upper half of a word is the quickest way to keep its sign
inline void addBytes(const Bytes& both, std::int32_t weights, Ints& sum) {
    const Bytes none = {};
    addDots((Words)__builtin_shufflevector(none, both, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23), weights,
            sum.low);
    addDots((Words)__builtin_shufflevector(none, both, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31),
            weights, sum.high);
}
#endif

// Adds two corners of 40 bytes.
inline void addCorners(const std::int8_t* first, const std::int8_t* second, std::int32_t weights, Ints* sum) {
    Bytes a, b;
    for (int i = 0; i < 2; ++i) {
        __builtin_memcpy(&a, first + 16 * i, sizeof a);
        __builtin_memcpy(&b, second + 16 * i, sizeof b);
        addBytes(__builtin_shufflevector(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23), weights,
                 sum[2 * i]);
        addBytes(__builtin_shufflevector(a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31), weights,
                 sum[2 * i + 1]);
    }
    long long low, high;
    __builtin_memcpy(&low, first + 32, sizeof low);
    __builtin_memcpy(&high, second + 32, sizeof high);
    a = (Bytes)Longs{low, 0};
    b = (Bytes)Longs{high, 0};
    addBytes(__builtin_shufflevector(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23), weights, sum[4]);
}

// Adds `share` of a level to the row of one receiver. Two corners lie side by side, as combinePairs() has two
// components, so that whole numbers of 16 bits are multiplied, two at a time.
inline void addLevel(const FarTable& table, int level, const Level& at, std::size_t lane, float share, Lanes* row) {
    const std::int8_t* first = table.points + std::int64_t(at.first[lane]) * kRow;
    const std::int64_t dx = at.stride[0] * kRow, dy = at.stride[1] * kRow, dz = at.stride[2] * std::int64_t(kRow);
    Ints sum[5] = {};
    addCorners(first, first + dx, at.weights[0][lane], sum);
    addCorners(first + dy, first + dy + dx, at.weights[1][lane], sum);
    addCorners(first + dz, first + dz + dx, at.weights[2][lane], sum);
    addCorners(first + dy + dz, first + dy + dz + dx, at.weights[3][lane], sum);
    for (int i = 0; i < 5; ++i) {
        Lanes scale, number;
        loadFloats(table.scale[level] + 8 * i, scale);
        toFloats(sum[i], number);
        row[i] += share * scale * number;
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
    Level levels[3];
    boxLevel(table.boxes[0], point, levels[0]);
    boxLevel(table.boxes[1], point, levels[1]);
    levels[1].share *= 1 - levels[0].share;
    levels[2].share = 1 - levels[0].share - levels[1].share;
    if (any(levels[2].share > 0)) sphereLevel(constants, table, offset, square, levels[2]);
    // The corners of all receivers are on their way while the first of them are read.
    unsigned lanes[3];
    for (int l = 0; l < 3; ++l) {
        const Level& level = levels[l];
        lanes[l] = bitsOf(wanted & (level.share > 0));
        if (lanes[l] == 0) continue;
        weighCorners(levels[l]);
        const std::int64_t dy = level.stride[1] * kRow, dz = level.stride[2] * std::int64_t(kRow);
        for (unsigned left = lanes[l]; left != 0; left &= left - 1) {
            const std::int8_t* first = table.points + std::int64_t(level.first[__builtin_ctz(left)]) * kRow;
            __builtin_prefetch(first);
            __builtin_prefetch(first + dy);
            __builtin_prefetch(first + dz);
            __builtin_prefetch(first + dy + dz);
        }
    }
    const Lanes away = square + 0.25f * table.radius * table.radius;  // the factor with which rows are stored
    Lanes shares[3], rows[kLanes][5];
    for (int l = 0; l < 3; ++l) shares[l] = levels[l].share / (away * (kPerByte * float(kWholeWeight)));
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        Lanes row[5] = {};
        for (int l = 0; l < 3; ++l)
            if (lanes[l] >> lane & 1) addLevel(table, l, levels[l], lane, shares[l][lane], row);
        for (int i = 0; i < 5; ++i) rows[lane][i] = row[i];
    }
    for (std::size_t i = 0; i < 5; ++i) transpose((const float*)rows + 8 * i, kRow, out + 8 * i);
    inside = out[kDistance] * (away * (-table.per_fade * constants.dark));
    clamp(inside, kZeros, levels[0].share);
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

// The visibility that a part blocks at the wanted receivers.
struct Blocked {
    Lanes coefficients[kRow];  // V - 1 in its rest frame
    Lanes share;               // share of the sphere that is blocked
    Lanes weight;              // weight with which it counts
    Lanes inside;              // how dark it is inside of it
};

// Returns whether the part counts anywhere.
inline bool blockedBy(const FarConstants& constants, const FarTable& table, const FarPart& posed, const Frames& frames,
                      const Ints& wanted, Blocked& out) {
    sample(constants, table, posed, frames, wanted, out.coefficients, out.inside);
    out.share = out.coefficients[0] * (-1 / kRootOfSphere);
    out.weight = (out.share - constants.blocked[0]) * (1 / (constants.blocked[1] - constants.blocked[0]));
    clamp(out.weight, kZeros, kZeros + 1);
    Lanes solid = out.share * (1 / constants.solid);
    clamp(solid, kZeros, kZeros + 1);
    out.weight *= constants.overlap + (1 - constants.overlap) * solid;
    return any((out.weight > 0) | (out.inside > 0));
}

}  // namespace

}  // namespace penumbra
