#pragma once
// Finds triangles that need not be drawn from behind. On a closed surface what is seen from behind is hidden by what
// is in front of it. On software GL that saves nearly half of the time of a frame.
#include <cstdint>
#include <span>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

struct ClosedSurfaces {
    // [3T], closed surfaces first, one surface after another. A closed surface is a set of connected triangles in
    // which every edge has exactly one other triangle, which runs through the edge the other way.
    std::vector<std::uint32_t> triangles;
    std::vector<std::size_t> ends;  // [surface] into `triangles`
    std::size_t closedIndices() const { return ends.empty() ? 0 : ends.back(); }
};

ClosedSurfaces findClosedSurfaces(std::span<const std::uint32_t> triangles);

// Tells whether every closed surface has its outside outside in this pose, that is, a positive volume. After a
// mirrored bone, for instance, it has not.
bool allOutward(const ClosedSurfaces& surfaces, std::span<const Vec3> positions);

}  // namespace penumbra
