#include "player/scene/cast_on.h"

#include <algorithm>
#include <numeric>

#include "formats/common/parallel_for.h"
#include "runtime/cast/cast_on_cluster.h"

namespace penumbra {

namespace {

constexpr std::size_t kPiece = 512;  // receivers that a thread takes at once

}  // namespace

std::size_t castOn(const CastShadow& cast, CasterChoice choice, const CastReceivers& receivers, int threads,
                   std::vector<float>& mirrored) {
    const std::size_t count = receivers.positions.size(), pieces = (count + kPiece - 1) / kPiece;
    mirrored.resize(count * kFarCoefficients);
    std::vector<std::size_t> seen(pieces);
    parallelFor(pieces, threads, [&](std::size_t piece) {
        const std::size_t first = piece * kPiece, n = std::min(kPiece, count - first);
        seen[piece] =
            cast.evaluate({receivers.positions.subspan(first, n), receivers.normals.subspan(first, n),
                           receivers.tangents.subspan(first, n)},
                          choice, std::span(mirrored).subspan(first * kFarCoefficients, n * kFarCoefficients));
    });
    return std::accumulate(seen.begin(), seen.end(), std::size_t(0));
}

std::size_t castOnCharacter(const CastShadow& cast, CasterChoice choice, const Evaluator& character,
                            const CastReceivers& vertices, int threads, std::vector<float>& mirrored) {
    mirrored.resize(vertices.positions.size() * kFarCoefficients);
    const std::vector<ClusterView>& clusters = character.asset().model.clusters;
    const std::size_t count = vertices.positions.size(), first = character.firstFollower();
    std::vector<std::size_t> seen(clusters.size() + (count - first + kPiece - 1) / kPiece);
    const auto at = [&](std::size_t v) {
        return Receiver{vertices.positions[v], vertices.normals[v], vertices.tangents[v]};
    };
    const auto rows = [&](std::size_t begin, std::size_t end) {
        return std::span(mirrored).subspan(begin * kFarCoefficients, (end - begin) * kFarCoefficients);
    };
    parallelFor(seen.size(), threads, [&](std::size_t c) {
        if (c < clusters.size()) {
            const std::size_t begin = clusters[c].first_vertex, end = begin + clusters[c].vertex_count;
            seen[c] = castOnCluster(cast, choice, {character, c, begin, end}, at, rows(begin, end));
            return;
        }
        const std::size_t begin = first + (c - clusters.size()) * kPiece, end = std::min(count, begin + kPiece);
        seen[c] = castOnFollowers(cast, choice, begin, end, at, rows(begin, end));
    });
    return std::accumulate(seen.begin(), seen.end(), std::size_t(0));
}

}  // namespace penumbra
