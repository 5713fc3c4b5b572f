// Makes the tangents of clusters agree where clusters meet.
//
// Problem: each cluster chooses its tangents for itself. Where two clusters meet they may point anywhere, and the
// highlight of a brushed material breaks off at the border.
//
// Naive: choose one field for the whole mesh. No field is smooth on all of a body, and the places where it spins would
// lie anywhere.
//
// Here: the fields of the clusters stay, which keep such places away. They are turned to agree, then blended a few
// vertices deep. The steps are numbered in join_tangents.h.
#include "fit/clusters/join_tangents.h"

#include <algorithm>
#include <cassert>
#include <complex>
#include <map>
#include <utility>

#include "sh/tangent.h"
#include "sh/turn_about_normal.h"

namespace penumbra {

namespace {

constexpr int kAngleSweeps = 30;  // sweeps of step 1; 12 clusters in a ring settle to a millionth of a radian in about
                                  // as many
constexpr int kBlendSweeps = 24;  // sweeps of step 2; a jump then spreads over about ten vertices

using Turn = std::complex<double>;  // a turn about the normal, of length 1
using TurnsToNeighbours = std::vector<std::map<std::uint32_t, Turn>>;

std::vector<std::vector<std::uint32_t>> neighboursOf(std::span<const Triangle> triangles, std::size_t vertices) {
    std::vector<std::vector<std::uint32_t>> neighbours(vertices);
    for (const Triangle& t : triangles)
        for (std::size_t i = 0; i < 3; ++i) {
            neighbours[t[i]].push_back(t[(i + 1) % 3]);
            neighbours[t[(i + 1) % 3]].push_back(t[i]);
        }
    for (auto& list : neighbours) {
        std::sort(list.begin(), list.end());
        list.erase(std::unique(list.begin(), list.end()), list.end());
    }
    return neighbours;
}

// Returns for clusters c and d that meet the sum over their common edges of the turn from the tangent in d to that in
// c, carried over the edge.
TurnsToNeighbours turnsBetween(const std::vector<std::vector<std::uint32_t>>& neighbours, std::span<const Vec3> normals,
                               std::span<const std::uint32_t> cluster_of_vertex, const std::vector<Vec3>& tangents) {
    TurnsToNeighbours turns(1 + *std::max_element(cluster_of_vertex.begin(), cluster_of_vertex.end()));
    for (std::uint32_t a = 0; a < neighbours.size(); ++a)
        for (const std::uint32_t b : neighbours[a]) {
            const std::uint32_t c = cluster_of_vertex[a], d = cluster_of_vertex[b];
            if (c == d) continue;
            const Vec3 carried = carriedTangent(normals[a], normals[b], tangents[a]);
            turns[d][c] += std::polar(1.0, angleBetween(normals[b], carried, tangents[b]));
        }
    return turns;
}

// Returns the turn of cluster d that fits the turns of those of its neighbours that have one (not 0) best.
Turn bestTurn(const TurnsToNeighbours& turns, const std::vector<Turn>& turn_of, std::uint32_t d) {
    Turn sum = 0;
    for (const auto& [c, turn] : turns[d]) sum += turn * turn_of[c];
    return std::abs(sum) > 1e-9 ? sum / std::abs(sum) : turn_of[d] == 0.0 ? Turn(1) : turn_of[d];
}

// Returns one turn for each cluster.
std::vector<Turn> synchronised(const TurnsToNeighbours& turns) {
    std::vector<Turn> turn_of(turns.size(), 0);
    // Each cluster that is placed next is the one with the strongest tie to those that are. Where there is no tie, a
    // new connected piece of the mesh begins.
    for (std::size_t placed = 0; placed < turns.size(); ++placed) {
        std::uint32_t next = 0;
        double strongest = -1;
        for (std::uint32_t d = 0; d < turns.size(); ++d) {
            if (turn_of[d] != 0.0) continue;
            Turn tie = 0;
            for (const auto& [c, turn] : turns[d]) tie += turn * turn_of[c];
            if (std::abs(tie) > strongest) strongest = std::abs(tie), next = d;
        }
        turn_of[next] = bestTurn(turns, turn_of, next);
    }
    for (int sweep = 0; sweep < kAngleSweeps; ++sweep)
        for (std::uint32_t d = 0; d < turns.size(); ++d) turn_of[d] = bestTurn(turns, turn_of, d);
    return turn_of;
}

// Returns the tangents after one sweep of step 2.
std::vector<Vec3> blended(const std::vector<std::vector<std::uint32_t>>& neighbours, std::span<const Vec3> normals,
                          const std::vector<Vec3>& tangents) {
    std::vector<Vec3> out(tangents.size());
    for (std::size_t v = 0; v < out.size(); ++v) {
        Vec3 sum = tangents[v];
        for (const std::uint32_t n : neighbours[v]) sum += carriedTangent(normals[n], normals[v], tangents[n]);
        // Around a place where the field spins the sum vanishes.
        const Vec3 flat = sum - normals[v] * dot(normals[v], sum);
        out[v] = length(flat) > 1e-3f ? tangentOf(normals[v], flat) : tangents[v];
    }
    return out;
}

}  // namespace

void joinTangents(std::span<const Triangle> triangles, std::span<const Vec3> normals,
                  std::span<const std::uint32_t> cluster_of_vertex, std::vector<Vec3>& tangents) {
    assert(!tangents.empty() && normals.size() == tangents.size() && cluster_of_vertex.size() == tangents.size());
    const std::vector<std::vector<std::uint32_t>> neighbours = neighboursOf(triangles, tangents.size());
    // 1. Turn each cluster as a whole.
    const std::vector<Turn> turn_of = synchronised(turnsBetween(neighbours, normals, cluster_of_vertex, tangents));
    for (std::size_t v = 0; v < tangents.size(); ++v) {
        const Turn turn = turn_of[cluster_of_vertex[v]];
        const Vec3 side = cross(normals[v], tangents[v]);
        tangents[v] = tangentOf(normals[v], tangents[v] * float(turn.real()) + side * float(turn.imag()));
    }
    // 2. Blend across the borders.
    for (int sweep = 0; sweep < kBlendSweeps; ++sweep) tangents = blended(neighbours, normals, tangents);
}

}  // namespace penumbra
