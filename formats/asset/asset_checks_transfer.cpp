// Checks an asset's transfer, the linear models of transfer.
#include <algorithm>
#include <cmath>

#include "asset_generated.h"
#include "formats/asset/asset_checks.h"
#include "formats/asset/asset_field.h"

namespace penumbra {

namespace {

constexpr std::uint32_t kPiece = 512;  // vertices that are evaluated together

TransferView transferOf(const fbs::Transfer& stored, const Field& at, const AssetView& asset) {
    TransferView transfer;
    const std::uint64_t vertices = asset.mesh.positions.size();
    transfer.order = stored.order();
    checkRange(at / "order", transfer.order, 1, kMaxOrder);
    transfer.angles = spanOf<std::uint32_t>(stored.angles(), at / "angles");
    (at / "angles").require(!transfer.angles.empty(), "is empty");
    checkIndices(at / "angles", transfer.angles, asset.animation.pose_size);
    for (std::size_t i = 1; i < transfer.angles.size(); ++i)
        (at / "angles")[i].require(transfer.angles[i] > transfer.angles[i - 1], "is not above the one before");
    transfer.alpha = stored.alpha();
    (at / "alpha").require(std::isfinite(transfer.alpha) && transfer.alpha >= 0, "is not a number >= 0");
    const bool reduced = stored.basis() != nullptr;
    transfer.pose_basis = spanOf<float>(stored.pose_basis(), at / "pose_basis");
    checkFinite(at / "pose_basis", transfer.pose_basis);
    (at / "pose_basis").require(transfer.pose_basis.size() % transfer.angles.size() == 0, "has a broken last row");
    (at / "pose_basis").require(transfer.pose_basis.empty() != reduced, "does not go with basis: both or none");
    // Principal components are no more than the angles. This bounds what the sizes below multiply to.
    checkRange(at / "pose_basis", std::int64_t(transfer.inputs()), 1, std::int64_t(transfer.angles.size()));
    std::uint64_t outputs = vertices;
    if (reduced) {
        outputs = stored.basis()->count() / vertices;
        (at / "basis").require(outputs > 0, "is empty");
        transfer.basis = numbersOf(stored.basis(), at / "basis", outputs, vertices, AssetPrecision::kI8);
    }
    const std::uint64_t rows = std::uint64_t(transfer.coefficients()) * (transfer.inputs() + 1);
    transfer.weights = numbersOf(stored.weights(), at / "weights", rows, outputs, AssetPrecision::kF16);
    transfer.mean = floatsOf(stored.mean(), at / "mean", reduced ? vertices : 0);
    return transfer;
}

// Returns what says where the transfer of vertices lies.
ModelView layoutOf(const TransferView& transfer, std::size_t vertices) {
    ModelView model;
    model.convention = {BelowHorizon::kBlocked, transfer.order};
    model.stride = int((transfer.coefficients() + 3) / 4 * 4);
    model.features = FeatureKind::kJointAngles;
    for (std::uint32_t first = 0; first < vertices; first += kPiece) {
        ClusterView& piece = model.clusters.emplace_back();
        piece.first_vertex = first;
        piece.vertex_count = std::min(kPiece, std::uint32_t(vertices) - first);
    }
    return model;
}

}  // namespace

void setTransfer(const fbs::Asset& stored, const Field& file, AssetView& asset) {
    const Field at = file / "transfer";
    at.require(!asset.has_model, "cannot stand beside a model");
    at.require(asset.animation.jointCount() > 0, "needs joints");
    (file / "mesh.influences").require(asset.mesh.influences > 0, "is 0 in a file with transfer");
    // A pose has three numbers a joint, and the inputs. This bounds what a few bytes can ask for.
    const std::uint64_t numbers = 3 * asset.animation.jointCount() + asset.animation.input_names.size();
    checkRange(file / "animation.pose_size", asset.animation.pose_size, std::int64_t(numbers), std::int64_t(numbers));
    const std::uint64_t frames = asset.animation.frameCount();
    checkCount(file / "animation.pose", asset.animation.pose, frames * asset.animation.pose_size);
    for (std::size_t v = 0; v < asset.mesh.shading_point.size(); ++v)
        (file / "mesh.shading_point")[v].require(asset.mesh.shading_point[v] == v, "is not in the bake's order");
    asset.transfer = transferOf(*stored.transfer(), at, asset);
    asset.model = layoutOf(*asset.transfer, asset.mesh.positions.size());
}

}  // namespace penumbra
