#pragma once
// What casts shadows on a baked frame besides its mesh: the occluders of the bake, given again.
#include "bake/blockers.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

struct ReferenceBlockers {
    Blockers blockers;  // no triangles where the frame is of a rig's skin alone: ray_start.h is not for it
    std::vector<Vec3> occluder_positions;  // model frame, in the frame
};
// `name` of the visibility file starts messages. UsageError unless `occluders` are those of the bake, by content.
ReferenceBlockers blockersOfFrame(const VisibilityHeader& header, std::size_t frame, const std::string& name,
                                  const std::vector<std::filesystem::path>& occluders);

}  // namespace penumbra
