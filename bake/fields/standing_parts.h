#pragma once
// Finds the parts of a character that stand on the ground: feet and toes.
#include <vector>

#include "bake/source/bake_source.h"
#include "formats/common/part_table.h"

namespace penumbra {

// Returns for each part whether a good part of it touches the ground in enough frames of the source's clips, or at rest
// where it has none. The ground of a frame is where the lowest vertex is. At most 64 frames at equal steps are looked
// at.
std::vector<bool> standingParts(const BakeSource& source, const PartTable& table);

}  // namespace penumbra
