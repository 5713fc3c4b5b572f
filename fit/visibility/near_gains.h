#pragma once
// Takes near parts out of local numbers: finds how much each near part counts for each vertex, and what the vertex sees
// without them in every pose (docs/formulas.md, section 7, "The fit of near parts").
#include <cstdint>
#include <span>
#include <vector>

#include "fit/numerics/matrix.h"
#include "fit/visibility/far_factors.h"

namespace penumbra {

struct NearProblem {
    const FarTables* far = nullptr;  // with near parts
    const Model* model = nullptr;
    const PoseTable* poses = nullptr;
    std::span<const PosedPart> posed;       // [F, P]
    std::span<const int> joint_of_cluster;  // as LocalFrames
    std::span<const std::size_t> train;     // training frames, ascending
};

// Finds the gains of some vertices of the model, [Vc, Composition::near_count], and turns their local numbers [F, Vc n]
// into those without near parts: multiplied by the near parts with these gains, they give the local numbers back as
// well as they can. Where near parts hide nearly everything, the rest of a vertex cannot be told, and stays near what
// it is over all training frames.
std::vector<std::uint8_t> takeOutNearParts(const NearProblem& problem, std::span<const std::uint32_t> vertices,
                                           MatrixF& coefficients);

}  // namespace penumbra
