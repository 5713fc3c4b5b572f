#pragma once
// The inner loops of height fields (height_visibility.h). They read plain tables and work on 8 points at a time
// (height_lanes.cpp).
#include <cstddef>
#include <cstdint>

#include "sh/kernel.h"
#include "sh/vec3.h"

namespace penumbra {

// A tap of horizon.h with what its level needs: a place x of level 0 is at scale x + offset.
struct HeightTap {
    float row, column, per_metre;
    float scale, offset;
    float last_row, last_column;  // of the level
    std::int32_t columns, first;
};

struct HeightScene {
    const float* heights;  // of all levels
    float rows, columns;   // of level 0
    bool wraps, open;
    float least;  // leastHorizon()
    int order, azimuths;
    const HeightTap* taps;  // [azimuths, tap_count]
    std::size_t tap_count;
    const float* turns;  // [azimuths, order, 2]: 2 pi / azimuths times cos m phi, sin m phi
    const float* norms;  // [order (order + 1) / 2] factors of the integrals of horizonThetas()
};

// Places are in texels, heights at or above the field.
struct HeightPoints {
    const float *rows, *columns, *heights;
    std::size_t count;
};

struct HeightTurn {
    std::uint16_t to, from;
    float value;
};
// Numbers of +m and -m.
struct HeightPair {
    std::uint16_t m, plus, minus;
};
// From SH in the frame of a field to mirrored numbers in the frames of points: turns about z, a quarter turn about x, a
// turn about z, `mirror` (the quarter turn back, then the mirror), a turn about z.
struct HeightMirror {
    int order, size;  // of V; numbers that come out
    const HeightTurn *quarter, *mirror;
    std::size_t quarter_count, mirror_count;
    const HeightPair* pairs;  // of the numbers that come out
    std::size_t pair_count;
    const float* below;    // [size] what is added: the mirrored "1 below the horizon"; null: nothing
    const float* ambient;  // [size] weights of E, which is clamped to [0, 1]
    float ambient_norm2;
};
struct HeightFrames {
    const Vec3 *normals, *tangents;  // in the frame of the field
};

// The values around a texel among those of receivers: four rows of `row_size` numbers.
struct HeightBlend {
    const float* corners[4];
    float weights[4];
};

struct HeightPath {
    static const HeightPath portable, avx2;
    const char* name;
    // out[p * stride + i], i < order^2.
    void (*visibility)(const HeightScene&, const HeightPoints&, std::size_t stride, float* out);
    // out[p * stride + i], i < size.
    void (*mirror)(const HeightMirror&, const HeightFrames&, const float* rows, std::size_t row_stride,
                   std::size_t count, std::size_t stride, float* out);
    // out[b * row_size + i] = sum of the weighted corners; row_size is a multiple of 8.
    void (*blend)(const HeightBlend* blends, std::size_t count, std::size_t row_size, float* out);
};
inline const HeightPath& fastestHeightPath() { return fastestPath<HeightPath>(); }

}  // namespace penumbra
