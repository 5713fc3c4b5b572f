#pragma once
// What casters hide from the vertices of a character, cluster by cluster.
#include <algorithm>
#include <array>

#include "runtime/cast/cast_shadow.h"

namespace penumbra {

// Vertices [begin, end) of a character, which are of one cluster.
struct ClusterPart {
    const Evaluator& evaluator;
    std::size_t cluster, begin, end;
};

// Writes what the chosen casters leave visible at vertices of a cluster: mirrored[(v - begin) *
// kFarCoefficients + i], as CastShadow::evaluate() does. `at(vertex)` returns a vertex in the scene (Receiver). Returns
// how many of them see any caster. What a vertex gets does not depend on which range it is asked for with. A thread
// keeps its room, so that nothing is allocated once it has seen as much.
template <class At>
std::size_t castOnCluster(const CastShadow& cast, CasterChoice choice, const ClusterPart& part, const At& at,
                          std::span<float> mirrored) {
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
    const FarLayout& layout = part.evaluator.castLayout();
    const FarRun& run = layout.runs[part.cluster];
    vertices.clear(), anchors.clear(), indices.clear(), anchor.clear(), weight.clear();
    for (std::uint32_t r = run.first; r < run.first + run.count; ++r) {
        const std::uint32_t v = layout.receivers[r];
        if (v < part.begin || v >= part.end) continue;
        indices.push_back(v);
        vertices.add(at(v));
        const auto first = std::ptrdiff_t(r * kAnchorsOfReceiver), last = first + std::ptrdiff_t(kAnchorsOfReceiver);
        anchor.insert(anchor.end(), layout.anchor.begin() + first, layout.anchor.begin() + last);
        weight.insert(weight.end(), layout.weight.begin() + first, layout.weight.begin() + last);
    }
    for (std::uint32_t a = run.first_anchor; a < run.first_anchor + run.anchor_count; ++a)
        anchors.add(at(layout.anchors[a]));
    rows.resize(indices.size() * kFarCoefficients);
    const std::size_t seen =
        cast.evaluateRun({vertices.view(), anchors.view(), anchor.data(), weight.data(), run.spacing}, choice, rows);
    for (std::size_t i = 0; i < indices.size(); ++i)
        std::copy_n(rows.begin() + std::ptrdiff_t(i * kFarCoefficients), kFarCoefficients,
                    mirrored.begin() + std::ptrdiff_t((indices[i] - part.begin) * kFarCoefficients));
    return seen;
}

// Does the same for vertices [begin, end) that follow points. They are of no cluster and share no anchors.
template <class At>
std::size_t castOnFollowers(const CastShadow& cast, CasterChoice choice, std::size_t begin, std::size_t end,
                            const At& at, std::span<float> mirrored) {
    constexpr std::size_t kPiece = 64;
    std::array<Vec3, kPiece> positions, normals, tangents;
    std::size_t seen = 0;
    for (std::size_t first = begin; first < end; first += kPiece) {
        const std::size_t n = std::min(kPiece, end - first);
        for (std::size_t i = 0; i < n; ++i) {
            const Receiver one = at(first + i);
            positions[i] = one.position;
            normals[i] = one.normal;
            tangents[i] = one.tangent;
        }
        seen += cast.evaluate({{positions.data(), n}, {normals.data(), n}, {tangents.data(), n}}, choice,
                              mirrored.subspan((first - begin) * kFarCoefficients, n * kFarCoefficients));
    }
    return seen;
}

}  // namespace penumbra
