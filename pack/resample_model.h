#pragma once
// Draws a fitted model with another mesh of the same skeleton.
#include <cstddef>

#include "formats/common/drawn_mesh.h"
#include "formats/stage/model_file.h"

namespace penumbra {

struct Resampled {
    Model model;
    std::size_t border_corners = 0;  // vertices of the fitted mesh that were expressed by another cluster's scores
};

// Returns the model with the vertices of `drawn`. Each has the cluster of most of its three points, and takes mean and
// components from them. The numbers of a point stay what they are relative to its normal: they are turned from its
// local frame to that of the vertex about the normal alone, which is exact within a band. Scores, features and fields
// stay as fitted. A point of another cluster is expressed by the scores of this one (border_corners.h). Throws
// Unsupported for a deforming mesh.
Resampled resampledModel(const Model& fitted, const DrawnMesh& drawn, int threads);

}  // namespace penumbra
