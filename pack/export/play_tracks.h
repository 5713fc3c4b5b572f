#pragma once
// Animations of a .glb that get further morph weights.
#include <map>
#include <string>
#include <vector>

#include "formats/rig/gltf_numbers.h"
#include "formats/rig/growing_glb.h"
#include "pack/export/weight_tracks.h"

namespace penumbra {

// A node whose mesh has `own` morph targets of its own before those of the export.
struct MorphedNode {
    std::size_t node = 0, mesh = 0, own = 0;
};

// Adds the weights of the export to the animations. `played` has those of each animation that shows the export; its
// times are those of the file. Nodes of other animations keep what they show. Throws Unsupported where the file drives
// the weights by KHR_animation_pointer.
void addPlayTracks(GrowingGlb& glb, const GltfNumbers& numbers, const std::vector<MorphedNode>& nodes,
                   const std::map<std::size_t, WeightTrack>& played, std::size_t count);

}  // namespace penumbra
