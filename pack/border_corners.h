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

namespace penumbra {

// The SH band and order of each number of a vertex: number i turns with number partner[i] by the angle order[i] times
// that of the frame.
struct TurnTable {
    std::vector<int> order;            // m; 0: it does not turn
    std::vector<std::size_t> partner;  // the number of -m in the same band

    std::size_t size() const { return order.size(); }
};
TurnTable turnsOf(const Convention& convention);
TurnTable turnsOfIndirect();
// Turns functions of a local frame: its x axis stands at an angle (radians, about the normal) in the new frame.
struct Turn {
    const TurnTable& turns;
    std::vector<float> cosine, sine;  // of m times the angle
};
Turn makeTurn(const TurnTable& turns, double angle);
// `in` and `out` have turns.size() numbers and do not overlap.
void apply(const Turn& turn, std::span<const float> in, std::span<float> out);
// Returns the angle of the tangent `a` in a frame with the tangent `b`; both lie in the plane of the unit `normal`.
double angleBetween(Vec3 normal, Vec3 a, Vec3 b);

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
