#pragma once
// Takes near parts out of local numbers: finds how much each near part counts for each vertex, and what the vertex sees
// without them in every pose (docs/formulas.md, section 7, "The fit of near parts").
#include <cstdint>
#include <span>
#include <vector>

#include "fit/numerics/matrix.h"
#include "fit/visibility/far_factors.h"

namespace penumbra {

// How a fit treats vertices that other parts hide in all training frames (hiddenByParts()).
enum class HiddenVertices { kLearned, kOpened };

struct NearProblem {
    const FarTables* far = nullptr;  // with near parts
    const Model* model = nullptr;
    const PoseTable* poses = nullptr;
    std::span<const PosedPart> posed;       // [F, P]
    std::span<const int> joint_of_cluster;  // see LocalFrames
    std::span<const std::size_t> train;     // training frames, ascending
    HiddenVertices hidden = HiddenVertices::kLearned;
};

// Finds the gains of some vertices of the model, [Vc, Composition::near_count], and turns their local numbers [F, Vc n]
// into those without near parts: multiplied by the near parts with these gains, they give the local numbers back as
// well as they can. Where near parts hide nearly everything, the rest of a vertex cannot be told, and stays near what
// it is over all training frames.
std::vector<std::uint8_t> takeOutNearParts(const NearProblem& problem, std::span<const std::uint32_t> vertices,
                                           MatrixF& coefficients);

// Finds the vertices that see nothing in any training frame because other parts hide them, as a field says where it is
// dark. What such a vertex sees when it comes out cannot be learned, and what it sees of nearby parts alone misleads:
// from within the body it looks out of the ends where far parts are cut off. `whole` [F, Vc n] are the numbers of what
// all parts hide, and `ambient` [n] are the weights that give E. result[i] tells whether vertices[i] is one.
std::vector<bool> hiddenByParts(const NearProblem& problem, std::span<const std::uint32_t> vertices,
                                const MatrixF& whole, std::span<const float> ambient);
// Gives these vertices the whole sky as their numbers [F, Vc n] in all frames, and gains of 1. So near and far parts
// alone say what they see.
void openHidden(const std::vector<bool>& hidden, std::span<std::uint8_t> gains, MatrixF& coefficients);

}  // namespace penumbra
