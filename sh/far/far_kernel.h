#pragma once
// The inner loop of far visibility (farVisibility(), sh/far/far_visibility.h) for many receivers of one part. It reads
// plain tables and works on 8 receivers at a time (far_lanes.cpp). docs/formulas.md, section 7, has the formulas.
#include <cstddef>
#include <cstdint>

#include "sh/kernel.h"
#include "sh/vec3.h"

namespace penumbra {

constexpr int kMaxSpheres = 4;             // of a field
constexpr std::size_t kMaxReceivers = 64;  // of a call

// Near parts (sh/far/near_parts.h).
constexpr std::size_t kMaxNear = 4;       // of a part
constexpr std::uint16_t kNoPart = 65535;  // stands where a part has fewer near parts than others
constexpr float kPerGain = 1 / 128.0f;    // a gain is a byte times this

// A box of a field: cell coordinate = (p - low) * per_cell, clamped to [0, cells].
struct FarBox {
    float low[3], high[3], per_cell[3], cells[3];
    float per_width;  // 1 / width over which it fades into the next level
    std::int32_t stride[3];
    std::int32_t first;  // its first point
};
// A FieldTable (sh/far/part_field.h) as the kernel reads it.
struct FarTable {
    FarBox boxes[2];
    std::int32_t first_sphere;
    float center[3], radius;
    float per_fade;      // 1 / depth over which a point inside goes dark
    float scale[3][40];  // [level]
    const std::int8_t* points;
};
// A PosedPart.
struct FarPart {
    float to_part[12], turn[9], center[3], radius;
    const float* to_model;  // blocks of the rotation, band after band
};

struct FarTerm {
    std::uint16_t from;
    float value;
};
// A sparse matrix: row r has terms[first[r]] up to terms[first[r + 1]].
struct FarMatrix {
    const std::uint16_t* first;
    const FarTerm* terms;
};
// Values of mirrored functions of order 6 at a grid of directions above the horizon: 4 rings of 16. Ring k lies at the
// height of a Gauss-Legendre node; `ring` has the part of y_i that depends on it, in the order of evenIndices(), and
// `ring_back` that times the weight of the node. Products of two such functions come back exact.
struct FarGrid {
    float ring[4][21], ring_back[4][21];
};
// Products of mirrored functions of any order. Pair n is a_j b_k + a_k b_j, or a_j b_j where j = k; a product's number
// i is the sum of value times pair over row i. Rows have multiples of 4 terms.
constexpr std::size_t kMaxPairs = 576;
struct FarProduct {
    const std::uint8_t *j, *k;
    std::size_t pairs;
    FarMatrix rows;
    int size_out;
};
struct FarConstants {
    float quarter_turn[286];  // blocks of R(X(90)), band after band
    float mirror[21][6];      // [even][l]: what mirrorAtHorizon() takes from the odd coefficient (l, m) of the same m
    FarGrid grid;
    FarProduct compose;                // of the local visibility and a far one; only of orders above 6
    int order;                         // of the local visibility
    float sphere_scales[kMaxSpheres];  // kFieldSphereScales
    // Anchors sum parts that block up to near[0] of the sphere; receivers multiply those above near[1] in one by one.
    // Between the two both have a share. The sum takes what blocks most 1 + depth times.
    float near[2], depth;
    // A part that blocks next to nothing counts `overlap` times, one that blocks a share of `solid` and more once.
    float overlap, solid;
    float most;        // no direction is more visible than this, however many factors ring above 1 there; 0: no bound
    float dark;        // how fast points inside a part go dark, as a share of how fast they do in its own character
    float blocked[2];  // a part that blocks less than the first share of the sphere does not count, more than the
                       // second in full
};

struct FarReceivers {
    const Vec3 *positions, *normals, *tangents;  // [count], count <= kMaxReceivers
    std::size_t count;
    const std::uint8_t* gains = nullptr;  // [count, FarScene::near_count], times kPerGain
};

// The parts that receivers see, and their fields.
struct FarScene {
    const FarTable* tables;
    const FarPart* posed;
    const std::uint16_t* parts;
    std::size_t part_count;
    float spacing = 0;  // of the anchors, kept away from what is nearer than kNearSpacings; 0: size alone decides
    // What receivers multiply in besides, by gains of their own (sh/far/near_parts.h). Anchors know nothing of it.
    const std::uint16_t* near_parts = nullptr;  // [near_count], kNoPart: none
    std::size_t near_count = 0;
};

// What anchors know, for the receivers around them. An anchor has `stride` floats: the sum [36] over the parts that
// block little, 4 zeros, then how near each part is (0..1, as `near` above tells by what it blocks).
constexpr std::size_t kAnchorSums = 40, kMaxAnchorParts = 32, kAnchorsOfReceiver = 4;
constexpr std::size_t kMaxNearParts = 128;  // of a call of FarPath::far() with anchors
// Anchors leave out what stands nearer than the first number of their spacings, and take whole what stands farther than
// the second: what they see changes too much from one to the next.
constexpr float kNearSpacings[2] = {4, 8};
constexpr std::size_t anchorStride(std::size_t part_count) { return kAnchorSums + (part_count + 7) / 8 * 8; }
struct FarAnchors {
    const float* values = nullptr;          // [anchors, stride]; null: receivers find out for themselves
    std::size_t stride = 0;                 // anchorStride(part_count), part_count <= kMaxNearParts
    const std::uint16_t* anchor = nullptr;  // [receivers, kAnchorsOfReceiver]
    const float* weight = nullptr;          // [receivers, kAnchorsOfReceiver], rows sum to 1
};

struct FarPath {
    static const FarPath portable, avx2, avx512;
    // Writes the values of anchors at `receivers`. It does not read their tangents. part_count <= kMaxAnchorParts.
    void (*anchors)(const FarConstants& constants, const FarScene& scene, const FarReceivers& receivers,
                    float* values) = nullptr;
    // Writes far[r * 21 + i] of every receiver.
    void (*far)(const FarConstants& constants, const FarScene& scene, const FarAnchors& anchors,
                const FarReceivers& receivers, float* far) = nullptr;
    // Multiplies numbers[v * stride + i] by far[v * 21 + i] and adds mean[v * stride + i], unless mean is null.
    void (*compose)(const FarConstants& constants, const float* far, const float* mean, std::size_t vertices,
                    std::size_t stride, float* coefficients) = nullptr;
};

inline const FarPath& fastestFarPath() { return fastestPath<FarPath>(); }

}  // namespace penumbra
