#pragma once
// The inner loop of castVisibility() (sh/cast/cast_visibility.h). It reads plain tables and works on 8 receivers at a
// time (cast_lanes.cpp).
#include <cstddef>
#include <cstdint>

#include "sh/cast/repeated_product.h"
#include "sh/far/far_kernel.h"
#include "sh/kernel.h"
#include "sh/vec3.h"

namespace penumbra {

struct CastTables {
    int order;
    const float* logs;                               // rows of 8 (CapLogTable)
    const BasicRepeatedProduct<float>::Term* terms;  // output i has the terms first[i] up to first[i + 1]
    const std::uint16_t* first;
    const FarConstants* turns;  // only `mirror` and `quarter_turn` are read
};
struct CastScene {
    const float* spheres;  // x, y, z, radius
    std::size_t sphere_count;
    const Vec3* positions;
    std::size_t count;
    const Vec3 *normals, *tangents;  // null: the frame of the spheres
    float least, full;               // CastFade
    float spacing = 0;               // FarScene::spacing, for anchors
    FarAnchors anchors = {};         // for receivers with normals
};
// Writes a row for each position: order^2 numbers, or the 21 of the mirrored function where there are normals.
using CastVisibilityLanes = void (*)(const CastTables&, const CastScene&, float* out);
// Writes what anchors at the positions know (FarAnchors): the sum [25] of the logarithms of the spheres that are not
// near, zeros up to kAnchorSums, then how near each sphere is.
using CastAnchorLanes = void (*)(const CastTables&, const CastScene&, float* values);

struct CastPath {
    static const CastPath portable, avx2;
    CastVisibilityLanes visibility;
    CastAnchorLanes anchors;  // anchors of order 5
};
inline const CastPath& fastestCastPath() { return fastestPath<CastPath>(); }

}  // namespace penumbra
