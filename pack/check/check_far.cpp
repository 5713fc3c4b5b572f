#include "pack/check/check_far.h"

#include <array>
#include <numeric>

#include "formats/common/drawn_mesh.h"
#include "formats/common/parallel_for.h"
#include "formats/common/spread_evenly.h"
#include "sh/far/floor_factor.h"
#include "sh/reflectance.h"

namespace penumbra {

namespace {

PartRays raysOf(const VisibilityHeader& truth) {
    const Mesh& mesh = truth.drawn ? truth.drawn->mesh : truth.mesh;
    const Skin& skin = truth.drawn ? truth.drawn->skin : *truth.skin;
    return {mesh, skin, makePartTable(mesh, skin)};
}

}  // namespace

FarCheck::FarCheck(const AssetView& asset, const VisibilityHeader& truth, std::size_t vertices,
                   std::span<const std::vector<std::size_t>> frames)
    : asset_(asset),
      rays_(raysOf(truth)),
      vertices_(spreadEvenly(vertices, kComparedVertices)),
      takes_(truth.frames.frameCount()) {
    for (const std::vector<std::size_t>& kind : frames)
        for (const std::size_t i : spreadEvenly(kind.size(), kComparedFrames)) takes_[kind[i]] = true;
}

FarSums FarCheck::compareVertex(const Evaluator& posed, const FarFrame& frame, std::size_t v) const {
    const FarTables& tables = posed.farTables();
    const std::uint16_t part = asset_.model.composition->part_of_vertex[v];
    FarComparison far = compareFar({tables.fields(), rays_, posed.posedParts()}, tables.partsSeenBy(part),
                                   {frame.positions[v], frame.normals[v], frame.tangents[v]});
    if (tables.fields().floor)
        for (std::array<float, kFarCoefficients>* product : {&far.by_fields, &far.by_rays})
            multiplyByFloor(fastestFarPath(), frame.normals.subspan(v, 1), frame.tangents.subspan(v, 1), *product);
    const Convention& convention = asset_.model.convention;
    const std::size_t first = v * std::size_t(asset_.model.stride), size = std::size_t(convention.size());
    const auto error = [&](std::span<const float> factor) {
        return composedError(convention, frame.true_local.subspan(first, size), factor,
                             frame.truth.subspan(first, size));
    };
    return {error(far.by_fields), error(far.by_rays), 1};
}

FarSums FarCheck::compare(const Evaluator& posed, const FarFrame& frame, int threads) const {
    std::vector<FarSums> sums(vertices_.size());
    parallelFor(sums.size(), threads, [&](std::size_t i) { sums[i] = compareVertex(posed, frame, vertices_[i]); });
    FarSums all;
    for (const FarSums& one : sums) all.add(one);
    return all;
}

}  // namespace penumbra
