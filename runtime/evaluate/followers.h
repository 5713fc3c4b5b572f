#pragma once
// Vertices of a dense character that interpolate between its points (asset.fbs, Mesh.point_corners).
//
// Problem: a scan has hundreds of thousands of vertices, of which few are baked and fitted: the points. Where two
// clusters meet, their scores disagree a little in poses that the model has not seen. Between two points that is a
// gradient; between two vertices of the scan it would be a step, which is a seam.
//
// Naive: give every vertex components of its own, of one cluster. That has the seam, and bytes and times of the scan.
//
// Here: the points are evaluated, whatever their clusters are. Then each vertex takes the numbers of the three points
// around it, each turned about the normal from the frame of the point to its own.
#include <span>

#include "formats/asset/asset_file.h"
#include "sh/turn_about_normal.h"

namespace penumbra {

// The vertices of a pose in any one frame: unit normals and tangents [V].
struct FollowedFrames {
    std::span<const Vec3> normals, tangents;
};

// Writes the numbers of the vertices [begin, end), which follow points, from those of the points. `coefficients` is [V,
// stride] of all vertices. May be called from many threads.
void followPoints(const MeshView& mesh, const TurnTable& turns, std::size_t begin, std::size_t end,
                  const FollowedFrames& frames, std::size_t stride, std::span<float> coefficients);

}  // namespace penumbra
