#pragma once
// Counts what each stage of a frame on the CPU has to move and to calculate: the least that its formulas ask for,
// from the asset's own arrays. An addition, multiplication, division, root, exp or tanh is one flop. The
// orthogonalisation of the bones' rotations is left out.
#include <cstddef>

#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading_set.h"

namespace penumbra {

struct StageWork {
    std::size_t read = 0, written = 0;  // bytes a frame, counting every array once
    double flop = 0;                    // a frame
    std::size_t bytes() const { return read + written; }
};

StageWork poseWork(const AssetView& asset);      // Evaluator::setPose: features and regression
StageWork skinWork(const AssetView& asset);      // Evaluator::skin
StageWork evaluateWork(const AssetView& asset);  // Evaluator::evaluateCluster, all clusters
// Evaluator::evaluateFar of a composed asset, all clusters, as if every far part counted at every vertex. It is a part
// of evaluateWork().
StageWork farWork(const AssetView& asset);
StageWork shadeWork(const ShadingSet& shading);  // ShadingSet::shade with what is on

}  // namespace penumbra
