#pragma once
// Texture coordinates that an export adds to a .glb.
#include <span>
#include <vector>

#include "pack/export/glb_targets.h"

namespace penumbra {

// Returns the first set that is free, with all behind it, in every target, and at least `least`.
std::size_t freeUvSet(GrowingGlb& glb, std::span<const GlbTarget> targets, std::size_t least);

// Adds TEXCOORD_`set` of a target, [vertices, 2]. Sets between those that the primitive has and this one, which readers
// take for the end of the list, become TEXCOORD_0 once more, or zeros where it has none.
void addUvSet(GrowingGlb& glb, const GlbTarget& target, std::size_t set, std::span<const float> uv);

}  // namespace penumbra
