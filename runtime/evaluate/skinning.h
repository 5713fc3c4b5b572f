#pragma once
#include <span>

#include "formats/asset/asset_file.h"
#include "runtime/evaluate/pose_features.h"
#include "sh/far/far_visibility.h"

namespace penumbra {

// Returns the cluster that turns the tangent of a vertex: its own, or that of the point that a follower has most of.
std::size_t clusterAt(const AssetView& asset, std::size_t vertex);

// Skinned vertices of the current pose, in the model frame: all of them, or none.
struct SkinnedVertices {
    std::span<const Vec3> positions, normals, tangents;  // [V]
};

// Where the vertices of a pose are. All that it refers to outlives it.
struct PosedMesh {
    const AssetView* asset;
    const PoseFeatures* pose;
    std::span<const Vec3> rest_positions, rest_normals;  // [V], as morph targets shape them
    std::span<const Vec3> points, point_normals;         // [Vs] of a deforming asset, else empty
    SkinnedVertices skinned = {};                        // vertex() reads them where they are known

    // Returns a vertex, whose cluster the caller knows; a skinned one has the tangent of its own. The rule is that of
    // skinVertices() (formats/common/mesh.h) in single precision: tangent = normalised(R_c t0 - N (N . R_c t0)), or any
    // unit vector orthogonal to N where that vanishes.
    Receiver vertex(std::size_t vertex, std::size_t cluster) const;
    // Writes vertices from `begin` on, as many as the arrays have.
    void skin(std::size_t begin, std::span<Vec3> positions, std::span<Vec3> normals, std::span<Vec3> tangents) const;
};

}  // namespace penumbra
