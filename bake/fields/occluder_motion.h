#pragma once
// Finds out how an occluder moves: not at all, with a point of --inputs, or otherwise.
#include <filesystem>
#include <optional>

#include "bake/source/bake_source.h"
#include "formats/stage/field_file.h"

namespace penumbra {

// Compares all frames of the source's clips with its rest positions, and with the points of the table `inputs`. Parts
// of a rig move with their bones, so that there is nothing to find out. Throws InvalidInput, which names the frame,
// where a mesh with `inputs` turns, bends or moves in another way than all points do.
OccluderMotion motionOf(const BakeSource& source, const std::optional<std::filesystem::path>& inputs);

}  // namespace penumbra
