#pragma once
// What each stage of a frame on the CPU has to move and to calculate: the least that its formulas ask for, counted from
// the asset's own arrays. Additions, multiplications, divisions, roots, exp and tanh are one flop each;
// what orthogonalises the bones' rotations is left out.
#include <cstddef>

#include "player/runtime/evaluator.h"
#include "player/runtime/shading_set.h"

namespace penumbra {

struct StageWork {
    std::size_t read = 0, written = 0;  // bytes a frame, every array once
    double flop = 0;                    // a frame
    std::size_t bytes() const { return read + written; }
};

StageWork poseWork(const AssetView& asset);      // Evaluator::setPose: features and regression
StageWork skinWork(const AssetView& asset);      // Evaluator::skin
StageWork evaluateWork(const AssetView& asset);  // Evaluator::evaluateCluster, all clusters
StageWork shadeWork(const ShadingSet& shading);  // ShadingSet::shade with what is on

}  // namespace penumbra
