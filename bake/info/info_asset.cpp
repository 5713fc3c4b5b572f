// An asset: its mesh, its model, its materials and lights.
#include "bake/info/info_files.h"
#include "formats/asset/asset_file.h"
#include "formats/asset/cluster_bytes.h"
#include "formats/asset/mapped_file.h"

namespace penumbra {

namespace {

void describeAssetModel(const AssetView& asset, Json& json) {
    const ModelView& model = asset.model;
    json["model"] = describeKind(model);
    json["model"].update({{"features", nameOf(model.features)},
                          {"convention", model.convention.name()},
                          {"clusters", model.clusters.size()},
                          {"precision", model.clusters.empty() ? "" : nameOf(model.clusters[0].basis.precision)},
                          {"quantization_error", model.quantization_error}});
    if (const std::optional<CompositionView>& composed = model.composition) {
        json["composition"] =
            describeComposition(composed->local_steps, composed->parts.size(), composed->byteCount(),
                                composed->residual, [](const ClusterView& cluster) { return cluster.components(); });
        if (composed->floor) json["composition"]["floor"] = true;
        addNearParts(*composed, json["composition"]);
        for (const PartFieldView& part : composed->parts)
            json["part_joints"].push_back(partName(part.field, asset.animation.joint_names));
    }
    if (const std::optional<IndirectView>& indirect = model.indirect) {
        const std::vector<ClusterView>& clusters = indirect->clusters;
        json["bounced"] =
            describeBounced(*indirect, outputBytes(clusters) + regressionBytes(clusters), asset.mesh.positions.size(),
                            [](const ClusterView& cluster) { return cluster.components(); });
        json["bounced"].update(
            {{"precision", nameOf(clusters[0].basis.precision)}, {"packing_error", indirect->packing_error}});
    }
}

Json describeMaterial(const MaterialView& material) {
    Json json{{"name", material.name}};
    if (material.isLive())
        json["live"] = nameOf(material.lobes[0].model);
    else
        json["slice_form"] = nameOf(material.slice_form);
    if (material.membrane) json["membrane"] = toString(*material.membrane);
    if (material.hasSteps())
        json["steps"] = {{"values", std::vector(material.steps.begin(), material.steps.end())},
                         {"error", material.step_error}};
    if (const Vec3 e = material.emission; e != Vec3{}) json["emission"] = {e.x, e.y, e.z};
    json["bytes"] = material.stored_slices.size_bytes() + material.stored_step_slices.size_bytes() +
                    material.operators.u.size_bytes() + material.operators.w.size_bytes();
    return json;
}

Json describeAssetLight(const LightView& light) {
    Json json{{"name", light.name}, {"sh_order", light.order}};
    if (!light.suns.empty()) json["suns"] = describeSuns(light.suns);
    if (light.picture.width > 0) json["picture"] = {light.picture.width, light.picture.height};
    return json;
}

}  // namespace

Json describeAsset(const std::filesystem::path& path) {
    const MappedFile file(path);
    const AssetView asset = openAsset(file.bytes(), path.string());
    Json json = Json::object();
    if (asset.has_mesh) {
        json["mesh"] = {{"vertices", asset.mesh.positions.size()},
                        {"source_vertices", asset.mesh.source_vertex.size()},
                        {"triangles", asset.mesh.triangles.size() / 3},
                        {"slots", asset.mesh.slots},
                        {"bytes_per_vertex", double(file.bytes().size()) / double(asset.mesh.positions.size())}};
        addRestBox(json["mesh"], asset.mesh.positions);
    }
    json["joints"] = asset.animation.jointCount();
    json["frames"] = asset.animation.times.size();
    json["clips"] = Json::array();
    for (const ClipView& clip : asset.animation.clips)
        json["clips"].push_back({{"name", clip.name}, {"frames", clip.frame_count}, {"held_out", clip.held_out}});
    if (asset.has_model) describeAssetModel(asset, json);
    if (asset.has_truth)
        json["truth"] = {{"sh_order", asset.truth.order}, {"precision", nameOf(asset.truth.precision)}};
    for (const MaterialView& material : asset.materials) json["materials"].push_back(describeMaterial(material));
    for (const LightView& light : asset.lights) json["lights"].push_back(describeAssetLight(light));
    if (const BlockersView& blockers = asset.blockers; !blockers.spheres.empty())
        json["blockers"] = describeSpheres(blockers.spheres, blockers.joints, asset.animation.joint_names);
    json["provenance"] = Json::parse(asset.provenance, nullptr, false);
    return json;
}

}  // namespace penumbra
