#pragma once
// Adds morph targets to a surface at rest, before bones move it.
//
// A target says for some vertices how far each moves, and how its normal changes, at weight 1. With the weights w the
// rest position is p + sum_t w_t dp_t, and the rest normal n + sum_t w_t dn_t, which skinning normalises. Bake, fit and
// run time all add in single precision and in the order of the targets, so that their surfaces have the same bits.
#include <cassert>
#include <cstdint>
#include <span>

#include "sh/vec3.h"

namespace penumbra {

// Changes of one morph target: vertices [R], ascending, and for each the offset of position and normal at weight 1.
struct MorphRows {
    std::span<const std::uint32_t> vertices;
    std::span<const Vec3> positions, normals;
};

inline void addMorph(const MorphRows& rows, float weight, std::span<Vec3> positions, std::span<Vec3> normals) {
    assert(rows.positions.size() == rows.vertices.size() && rows.normals.size() == rows.vertices.size());
    if (weight == 0) return;
    for (std::size_t r = 0; r < rows.vertices.size(); ++r) {
        const std::uint32_t v = rows.vertices[r];
        positions[v] = positions[v] + weight * rows.positions[r];
        normals[v] = normals[v] + weight * rows.normals[r];
    }
}

// A normal that targets have cancelled has no direction. The one at rest then stands for it.
inline void keepNormal(Vec3 at_rest, Vec3& normal) {
    if (!(dot(normal, normal) > 1e-6f)) normal = at_rest;
}

}  // namespace penumbra
