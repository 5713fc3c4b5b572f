#pragma once
// Fits one cluster of a composed model: the local visibility, and what the product with the far parts leaves
// (docs/formulas.md, section 7).
#include <span>
#include <vector>

#include "fit/visibility/far_factors.h"
#include "fit/visibility/fit_cluster.h"
#include "fit/visibility/near_gains.h"

namespace penumbra {

struct ComposedProblem {
    ClusterProblem local;     // its recipe sees the nearby joints; not clamped
    ClusterProblem residual;  // neither clamped nor with ambient weights
    const FarTables* far = nullptr;
    const VertexSet* vertices = nullptr;  // vertices of the cluster
    std::span<const PosedPart> posed;     // [F, P]
    const NearProblem* near = nullptr;    // null: the model has no near parts
};

struct ComposedFit {
    ClusterFit local, residual;
    std::vector<std::uint8_t> near_gains;  // [Vc, Composition::near_count]
    FrameErrors errors;                    // errors of local x far + residual
    FrameErrors without_residual;          // errors of local x far alone
    FrameErrors with_mean;                 // errors of local x far + the mean of the residual
    FrameErrors split;                     // errors of the true local x far, the limit for every local model
    // Energies over training frames of what the product leaves: as it is, about the mean of the other folds, and about
    // the mean of all, which is what the residual model is to predict.
    double left_as_it_is = 0, left_about_others = 0, left = 0;
};

// Fits the cluster to its local numbers and its whole numbers, both [F, Vc n]. Both are used up. With near parts
// it finds their gains, and the local model learns what is left when they are taken out.
ComposedFit fitComposed(const ComposedProblem& problem, MatrixF& local, MatrixF& whole);

}  // namespace penumbra
