#pragma once
// Points spread evenly over the surface of a skinned mesh at rest.
#include <cstdint>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

struct SurfaceSamples {
    std::vector<Vec3d> points;         // [N] in the space of the rest positions
    std::vector<std::uint16_t> joint;  // [N] the joint that moves the point most; the lower one of two that are equal
};

// Takes `count` points from the fronts, each for the same share of the area: artists put more vertices where there is
// detail, and blockers must not follow them there. Without area there are no points.
SurfaceSamples sampleSurface(const Mesh& mesh, const Skin& skin, int count, std::uint64_t seed);

// Takes the vertices of the fronts that a triangle uses, as the papers do.
SurfaceSamples sampleVertices(const Mesh& mesh, const Skin& skin);

}  // namespace penumbra
