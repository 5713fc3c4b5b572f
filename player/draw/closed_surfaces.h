#pragma once
// Which triangles of a mesh need not be drawn from behind: of a closed surface, what is seen from behind is hidden by
// what is in front of it. On software GL that is nearly half of the time of a frame.
#include <cstdint>
#include <span>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

struct ClosedSurfaces {
    // [3T], those of closed surfaces first, one surface after another: connected triangles whose every edge has one
    // other triangle, which runs through it the other way.
    std::vector<std::uint32_t> triangles;
    std::vector<std::size_t> ends;  // [surface] into `triangles`
    std::size_t closedIndices() const { return ends.empty() ? 0 : ends.back(); }
};

ClosedSurfaces findClosedSurfaces(std::span<const std::uint32_t> triangles);

// Whether every closed surface has its outside outside in this pose, that is a positive volume: it has not after a
// mirrored bone, say.
bool allOutward(const ClosedSurfaces& surfaces, std::span<const Vec3> positions);

}  // namespace penumbra
