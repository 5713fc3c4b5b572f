#include "runtime/evaluate/far_evaluator.h"

#include <algorithm>
#include <cassert>

#include "sh/far/floor_factor.h"

namespace penumbra {

namespace {

std::array<FarLayout, 2> layoutsOf(const AssetView& asset, const FarTables& tables) {
    std::vector<std::size_t> part_counts;
    for (std::size_t p = 0; p < tables.partCount(); ++p) part_counts.push_back(tables.partsSeenBy(p).size());
    return {makeFarLayout(asset, part_counts, FarQuality::kFull), makeFarLayout(asset, part_counts, FarQuality::kFast)};
}

// Skinned vertices, as many as the kernel takes at once.
struct FarBatch {
    std::array<Vec3, kMaxReceivers> positions, normals, tangents;
    std::array<std::uint8_t, kMaxReceivers * kMaxNear> gains;
    std::size_t count = 0;

    void add(const Receiver& vertex) {
        positions[count] = vertex.position;
        normals[count] = vertex.normal;
        tangents[count++] = vertex.tangent;
    }
    // Sets the gains [columns] of the vertex that is added next.
    void setGains(std::span<const std::uint8_t> of_vertices, std::size_t vertex, std::size_t columns) {
        std::copy_n(of_vertices.begin() + std::ptrdiff_t(vertex * columns), columns,
                    gains.begin() + std::ptrdiff_t(count * columns));
    }
    FarReceivers view() const { return {positions.data(), normals.data(), tangents.data(), count, gains.data()}; }
};

}  // namespace

FarEvaluator::Decoded::Decoded(const AssetView& asset)
    : tables(makeFarTables(*asset.model.composition, asset.model.convention.order)),
      layouts(layoutsOf(asset, tables)) {}

FarEvaluator::FarEvaluator(const AssetView& asset)
    : decoded_(std::make_shared<const Decoded>(asset)),
      pose_(decoded_->tables),
      anchors_(std::max(decoded_->layouts[0].values, decoded_->layouts[1].values)) {}

void FarEvaluator::evaluate(const FarPath& path, const PosedMesh& mesh, std::size_t cluster,
                            std::span<float> far) const {
    const FarLayout& of_cluster = layout();
    assert(far.size() == mesh.asset->mesh.positions.size() * kFarCoefficients);
    for (std::uint32_t r = of_cluster.first_run[cluster]; r < of_cluster.first_run[cluster + 1]; ++r)
        evaluateRun(path, mesh, of_cluster.runs[r], cluster, far);
}

void FarEvaluator::evaluateRun(const FarPath& path, const PosedMesh& mesh, const FarRun& run, std::size_t cluster,
                               std::span<float> far) const {
    const FarTables& tables = decoded_->tables;
    const FarLayout& in = layout();
    const FarConstants& constants = tables.constants(quality_);
    FarScene scene = tables.sceneOf(run.part, pose_.parts.data());
    if (near_factors_ == NearFactors::kWithout) scene.near_count = 0;
    const std::span<const std::uint8_t> gains = mesh.asset->model.composition->near_gains;
    // 1. The anchors. Their tangents do not matter.
    FarAnchors anchors;
    anchors.stride = anchorStride(scene.part_count);
    if (run.anchor_count > 0) anchors.values = anchors_.data() + run.first_value;
    for (std::size_t first = 0; first < run.anchor_count; first += kMaxReceivers) {
        FarBatch batch;
        for (std::size_t a = first; a < std::min<std::size_t>(run.anchor_count, first + kMaxReceivers); ++a)
            batch.add(mesh.vertex(in.anchors[run.first_anchor + a], cluster));
        path.anchors(constants, scene, batch.view(), anchors_.data() + run.first_value + first * anchors.stride);
    }
    // 2. The vertices.
    std::array<float, kMaxReceivers * kFarCoefficients> out;
    for (std::size_t first = run.first; first < run.first + run.count; first += kMaxReceivers) {
        FarBatch batch;
        const std::size_t end = std::min<std::size_t>(run.first + run.count, first + kMaxReceivers);
        for (std::size_t r = first; r < end; ++r) {
            batch.setGains(gains, in.receivers[r], scene.near_count);
            batch.add(mesh.vertex(in.receivers[r], cluster));
        }
        anchors.anchor = in.anchor.data() + first * kAnchorsOfReceiver;
        anchors.weight = in.weight.data() + first * kAnchorsOfReceiver;
        path.far(constants, scene, anchors, batch.view(), out.data());
        if (tables.fields().floor)
            multiplyByFloor(path, std::span(batch.normals).first(batch.count),
                            std::span(batch.tangents).first(batch.count),
                            std::span(out).first(batch.count * kFarCoefficients));
        for (std::size_t i = 0; i < batch.count; ++i)
            std::copy_n(out.begin() + std::ptrdiff_t(i * kFarCoefficients), kFarCoefficients,
                        far.begin() + std::ptrdiff_t(in.receivers[first + i] * kFarCoefficients));
    }
}

}  // namespace penumbra
