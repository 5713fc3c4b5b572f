#pragma once
// What casters hide from the vertices of a character, cluster by cluster.
#include "runtime/cast/cast_shadow.h"

namespace penumbra {

// Writes what the chosen casters leave visible at vertices [begin, end) of a cluster: mirrored[(v - begin) *
// kFarNumbers + i], as CastShadow::evaluate() does. `at(vertex)` returns a vertex in the scene (Receiver). Returns how
// many of them see any caster. What a vertex gets does not depend on which range it is asked for with. A thread keeps
// its room, so that nothing is allocated once it has seen as much.
template <class At>
std::size_t castOnCluster(const CastShadow& cast, CasterChoice choice, const Evaluator& evaluator, std::size_t cluster,
                          std::size_t begin, std::size_t end, const At& at, std::span<float> mirrored) {
    struct Points {
        std::vector<Vec3> positions, normals, tangents;
        void clear() { positions.clear(), normals.clear(), tangents.clear(); }
        void add(const Receiver& point) {
            positions.push_back(point.position);
            normals.push_back(point.normal);
            tangents.push_back(point.tangent);
        }
        CastReceivers view() const { return {positions, normals, tangents}; }
    };
    thread_local Points vertices, anchors;
    thread_local std::vector<std::uint32_t> indices;
    thread_local std::vector<std::uint16_t> anchor;
    thread_local std::vector<float> weight, rows;
    const FarLayout& layout = evaluator.castLayout();
    const FarRun& run = layout.runs[cluster];
    vertices.clear(), anchors.clear(), indices.clear(), anchor.clear(), weight.clear();
    for (std::uint32_t r = run.first; r < run.first + run.count; ++r) {
        const std::uint32_t v = layout.receivers[r];
        if (v < begin || v >= end) continue;
        indices.push_back(v);
        vertices.add(at(v));
        const auto first = std::ptrdiff_t(r * kAnchorsOfReceiver), last = first + std::ptrdiff_t(kAnchorsOfReceiver);
        anchor.insert(anchor.end(), layout.anchor.begin() + first, layout.anchor.begin() + last);
        weight.insert(weight.end(), layout.weight.begin() + first, layout.weight.begin() + last);
    }
    for (std::uint32_t a = run.first_anchor; a < run.first_anchor + run.anchor_count; ++a)
        anchors.add(at(layout.anchors[a]));
    rows.resize(indices.size() * kFarNumbers);
    const std::size_t seen =
        cast.evaluateRun({vertices.view(), anchors.view(), anchor.data(), weight.data(), run.spacing}, choice, rows);
    for (std::size_t i = 0; i < indices.size(); ++i)
        std::copy_n(rows.begin() + std::ptrdiff_t(i * kFarNumbers), kFarNumbers,
                    mirrored.begin() + std::ptrdiff_t((indices[i] - begin) * kFarNumbers));
    return seen;
}

}  // namespace penumbra
