#pragma once
// Expresses vertices of one cluster by the scores of a neighbouring one.
//
// Problem: a vertex that is drawn between two clusters needs the numbers of both, but has one list of scores.
//
// Naive: let it take only those of its own cluster. Then the triangles across the border are no gradient but a step,
// which is a seam.
//
// Here: over the training frames, the numbers that the model predicts for a vertex are regressed on the scores of the
// other cluster (least squares with a small ridge). Neighbouring clusters see nearly the same bones move, so that
// little is left over.
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "formats/stage/model_file.h"
#include "sh/turn_about_normal.h"

namespace penumbra {

// A vertex of the fitted mesh, for the scores of `cluster`.
struct BorderCorner {
    std::uint32_t cluster = 0, vertex = 0;
    auto operator<=>(const BorderCorner&) const = default;
};

// The three lists of clusters that a model can have.
constexpr std::size_t kClusterLists = 3;  // the model, the residual of a composed one, light that bounces
std::array<const std::vector<ClusterModel>*, kClusterLists> clusterLists(const Model& model);
std::array<TurnTable, kClusterLists> turnsOfLists(const Model& model);

// rows[list][i] are the numbers of corner i, [1 + K, n] with the K of corners[i].cluster: the mean, then the
// components, in the local frame of the vertex as that cluster's joint would carry it. An empty list has none.
using BorderRows = std::array<std::vector<std::vector<float>>, kClusterLists>;
BorderRows borderRows(const Model& fitted, std::span<const BorderCorner> corners, int threads);

}  // namespace penumbra
