// Checks whether a bake, predictions and a model belong to an asset.
#include <algorithm>
#include <cmath>

#include "formats/common/errors.h"
#include "pack/check/check_asset.h"

namespace penumbra {

std::vector<std::uint32_t> bakedRows(const AssetView& asset, const VisibilityHeader& header) {
    const MeshView& mesh = asset.mesh;
    const std::size_t baked = header.mesh.vertexCount(), all = mesh.positions.size();
    if (header.drawn && mesh.firstFollower() < all && header.drawn->mesh.vertexCount() == all &&
        baked == mesh.firstFollower()) {
        std::vector<std::uint32_t> point_of(all), rows;
        for (std::uint32_t p = 0; p < baked; ++p) point_of[header.drawn->vertex_of_point[p]] = p;
        for (std::size_t v = 0; v < baked; ++v) rows.push_back(point_of[mesh.shading_point[v]]);
        return rows;
    }
    if (baked != all)
        throw InvalidInput("has " + std::to_string(baked) + " vertices, the asset " + std::to_string(all));
    return {mesh.shading_point.begin(), mesh.shading_point.end()};
}

namespace {

void checkFits(const AssetView& asset, const VisibilityHeader& header) {
    if (!asset.hasCharacter()) throw InvalidInput("the asset has no model to check");
    const MeshView& mesh = asset.mesh;
    if (asset.model.deforming && header.skin) throw InvalidInput("has a skin; the asset's mesh is deforming");
    if (!asset.model.deforming && !header.skin) throw InvalidInput("has no skin; the asset's model needs one");
    if (header.mesh.two_sided != mesh.two_sided)
        throw InvalidInput(std::string(mesh.two_sided ? "is not" : "is") + " two-sided, unlike the asset");
    const std::vector<std::uint32_t> rows = bakedRows(asset, header);
    if (!std::equal(header.input_names.begin(), header.input_names.end(), asset.animation.input_names.begin(),
                    asset.animation.input_names.end()))
        throw InvalidInput("/inputs/names are not those of the asset");
    const std::size_t joints = asset.animation.jointCount() - asset.model.input_joints.size();
    if (header.skin && header.skin->jointCount() != joints)
        throw InvalidInput("has " + std::to_string(header.skin->jointCount()) + " joints, the asset " +
                           std::to_string(joints));
    if (header.order < asset.model.convention.order)
        throw InvalidInput("sh_order is " + std::to_string(header.order) + ", the asset needs " +
                           std::to_string(asset.model.convention.order));
    if (asset.model.features == FeatureKind::kJointAngles &&
        std::uint32_t(header.pose_size) != asset.animation.pose_size)
        throw InvalidInput("has a pose of " + std::to_string(header.pose_size) + " numbers, the asset of " +
                           std::to_string(asset.animation.pose_size));
    const double tolerance = 1e-5 * boxDiagonal(header.mesh.rest_positions);
    for (std::size_t v = 0; v < rows.size(); ++v)
        if (!(length(mesh.positions[v] - header.mesh.rest_positions[rows[v]]) <= tolerance))
            throw InvalidInput("/mesh/rest_positions are not those of the asset (vertex " +
                               std::to_string(mesh.shading_point[v]) + ")");
}

}  // namespace

void checkFits(const AssetView& asset, const VisibilityHeader& truth, const CheckReferences& references) {
    checkFits(asset, truth);
    if (references.predictions) {
        const VisibilityHeader& predictions = references.predictions->header();
        checkFits(asset, predictions);
        if (predictions.mesh.vertexCount() != truth.mesh.vertexCount())
            throw InvalidInput("has other vertices than the truth");
        if (predictions.quantity == kDiffuseTransfer)
            throw InvalidInput("quantity is " + predictions.quantity + "; predictions are of visibility");
    }
    if (references.second_bake) {
        const VisibilityHeader& second = references.second_bake->header();
        checkFits(asset, second);
        if (second.mesh.vertexCount() != truth.mesh.vertexCount())
            throw InvalidInput("has other vertices than the truth");
        if (second.quantity != truth.quantity) throw InvalidInput("quantity is " + second.quantity);
        if (second.seed == truth.seed && second.rays == truth.rays)
            throw InvalidInput("has the seed and rays of the truth, which show no noise");
    }
    if (!references.unpacked) return;
    const AssetView& unpacked = *references.unpacked;
    const auto same = [](auto a, auto b) { return std::equal(a.begin(), a.end(), b.begin(), b.end()); };
    bool fits = unpacked.model.convention == asset.model.convention && unpacked.model.kind == asset.model.kind &&
                unpacked.model.features == asset.model.features &&
                unpacked.model.clusters.size() == asset.model.clusters.size() &&
                same(unpacked.mesh.shading_point, asset.mesh.shading_point) &&
                unpacked.animation.jointCount() == asset.animation.jointCount();
    for (std::size_t c = 0; fits && c < asset.model.clusters.size(); ++c)
        fits = unpacked.model.clusters[c].vertex_count == asset.model.clusters[c].vertex_count;
    if (!fits) throw InvalidInput("not the model of the asset: another kind, other features, clusters or convention");
}

}  // namespace penumbra
