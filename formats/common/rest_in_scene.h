#pragma once
// How large a character is, and how it stands, where its mesh is bound in another space than the scene's.
#include <span>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

// The rows of Skin or of an asset's mesh.
struct SkinRows {
    int influences = 0;                     // K
    std::span<const std::uint16_t> joints;  // [V,K]
    std::span<const float> weights;         // [V,K]
};

// Returns `rest_positions` as they are where `bones` (skinning matrices of the first frame; may be empty) keep lengths
// to a factor of 2, which is their median. Otherwise the mesh is bound in other units, often centimetres that lie on
// their back, and the answer is the first frame. Pictures are framed by this, so that all frames of a scene are seen
// alike.
std::vector<Vec3> restInScene(std::span<const Vec3> rest_positions, const SkinRows& skin,
                              std::span<const Affine> bones);

}  // namespace penumbra
