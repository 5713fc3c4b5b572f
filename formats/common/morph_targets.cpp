#include "formats/common/morph_targets.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace penumbra {

RestShape restShape(const MorphTargets& morphs, RestShape rest, std::span<const float> weights) {
    assert(weights.size() == morphs.count());
    if (morphs.empty()) return rest;
    const std::vector<Vec3> at_rest = rest.normals;
    for (std::size_t m = 0; m < morphs.count(); ++m)
        addMorph(morphs.rowsOf(m), weights[m], rest.positions, rest.normals);
    for (const std::uint32_t v : morphs.vertices) keepNormal(at_rest[v], rest.normals[v]);
    return rest;
}

namespace {

// Appends a target whose rows are `kept`: pairs of a new vertex and the row that it comes from.
void appendTarget(const MorphRows& rows, std::vector<std::pair<std::uint32_t, std::size_t>>& kept, MorphTargets& out) {
    std::sort(kept.begin(), kept.end());
    for (const auto& [vertex, row] : kept) {
        out.vertices.push_back(vertex);
        out.positions.push_back(rows.positions[row]);
        out.normals.push_back(rows.normals[row]);
    }
    out.first.push_back(std::uint32_t(out.vertices.size()));
}

}  // namespace

MorphTargets selectVertices(const MorphTargets& morphs, std::span<const std::uint32_t> vertices) {
    MorphTargets out;
    if (morphs.empty()) return out;
    // 1. List the new numbers of each old vertex. An old one may be taken several times.
    std::uint32_t old = 0;
    for (const std::uint32_t v : vertices) old = std::max(old, v + 1);
    for (const std::uint32_t v : morphs.vertices) old = std::max(old, v + 1);
    std::vector<std::vector<std::uint32_t>> news(old);
    for (std::size_t i = 0; i < vertices.size(); ++i) news[vertices[i]].push_back(std::uint32_t(i));
    // 2. Rows go to all of them.
    out.names = morphs.names;
    out.rest_weights = morphs.rest_weights;
    out.first = {0};
    for (std::size_t m = 0; m < morphs.count(); ++m) {
        const MorphRows rows = morphs.rowsOf(m);
        std::vector<std::pair<std::uint32_t, std::size_t>> kept;
        for (std::size_t r = 0; r < rows.vertices.size(); ++r)
            for (const std::uint32_t v : news[rows.vertices[r]]) kept.emplace_back(v, r);
        appendTarget(rows, kept, out);
    }
    return out;
}

MorphTargets withBacks(const MorphTargets& morphs, std::size_t fronts) {
    if (morphs.empty()) return morphs;
    std::vector<std::uint32_t> twice;
    for (std::size_t v = 0; v < 2 * fronts; ++v) twice.push_back(std::uint32_t(v % fronts));
    MorphTargets out = selectVertices(morphs, twice);
    for (std::size_t r = 0; r < out.vertices.size(); ++r)
        if (out.vertices[r] >= fronts) out.normals[r] = -out.normals[r];
    return out;
}

}  // namespace penumbra
