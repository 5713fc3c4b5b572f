#pragma once
// Finds what casts shadows on a baked frame besides its mesh: the occluders of the bake, which the user names again.
#include "bake/trace/blockers.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

struct ReferenceBlockers {
    Blockers blockers;  // without triangles where a rig's skin alone is drawn: ray_start.h is not for it
    std::vector<Vec3> occluder_positions;   // [Vo] in this frame, model frame
    std::vector<std::uint32_t> other_side;  // [V] twinVertices(); empty without twins
    std::vector<std::uint8_t> front_alone;  // [T] 1: a triangle without a twin; empty without twins
};
// Reads the occluders. `name` of the visibility file starts messages. Throws UsageError unless `occluders` are those
// of the bake, by content.
ReferenceBlockers blockersOfFrame(const VisibilityHeader& header, std::size_t frame, const std::string& name,
                                  const std::vector<std::filesystem::path>& occluders);

}  // namespace penumbra
