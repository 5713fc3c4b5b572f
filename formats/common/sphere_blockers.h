#pragma once
// The sphere blockers of a character, as blockers files hold them. docs/formulas.md, section 9, has the reasons.
#include <cstdint>
#include <vector>

#include "sh/cast/caster_sphere.h"

namespace penumbra {

// More spheres than about 20 gain nothing: their silhouettes overlap, and few bands of SH count the overlaps twice.
constexpr std::size_t kMaxBlockers = 64;
// Bounds of centers and radii: the squares of such lengths, and their inverses, are still numbers.
constexpr float kLargestBlockerLength = 1e15f;

struct SphereBlockers {
    std::vector<CasterSphere> spheres;  // [S], 1..kMaxBlockers
    std::vector<std::uint16_t> joints;  // [S], the joint that each sphere moves with
};

}  // namespace penumbra
