// What fits learned of the pose: models of visibility, of transfer, and zonal lobes.
#include "bake/info/info_files.h"
#include "formats/stage/lobe_file.h"
#include "formats/stage/model_file.h"
#include "formats/stage/transfer_file.h"

namespace penumbra {

namespace {

template <class Number>
Json rangeOf(const std::vector<ClusterModel>& clusters, Number number) {
    std::vector<std::size_t> values;
    for (const ClusterModel& cluster : clusters) values.push_back(number(cluster));
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    return {{"least", *low}, {"most", *high}};
}

}  // namespace

Json describeModel(const std::filesystem::path& path) {
    const Model model = readModel(path);
    Json json = describeKind(model);
    json["features"] = nameOf(model.features);
    json["convention"] = model.convention.name();
    json["sh_order"] = model.convention.order;
    json["input_variance"] = model.input_variance;
    json["output_variance"] = model.output_variance;
    json["mesh"] = describe(model.mesh);
    json["joints"] = model.skin.jointCount();
    json["frames"] = model.frames.frameCount();
    json["clips"] = describe(model.frames);
    json["holdout_clips"] = model.holdout_clips;
    json["clusters"] = model.clusters.size();
    json["cluster_vertices"] = rangeOf(model.clusters, [](const ClusterModel& c) { return c.vertices.size(); });
    json["inputs"] = rangeOf(model.clusters, [](const ClusterModel& c) { return c.inputs(); });
    json["groups"] = rangeOf(model.clusters, [](const ClusterModel& c) { return c.groups.size(); });
    json["units"] = rangeOf(model.clusters, [](const ClusterModel& c) { return c.units(); });
    json["components"] = rangeOf(model.clusters, [](const ClusterModel& c) { return c.bias.size(); });
    if (const std::optional<Composition>& composed = model.composition) {
        json["composition"] =
            describeComposition(composed->local_steps, composed->fields.parts.size(), composed->fields.byteCount(),
                                composed->residual, [](const ClusterModel& cluster) { return cluster.components(); });
        if (composed->floor) json["composition"]["floor"] = true;
        addNearParts(*composed, json["composition"]);
        for (const PartField& part : composed->fields.parts)
            json["part_joints"].push_back(partName(part, model.skin.joint_names));
    }
    if (const std::optional<IndirectModel>& indirect = model.indirect) {
        std::size_t count = 0;
        for (const ClusterModel& cluster : indirect->clusters) count += cluster.numberCount();
        json["bounced"] = describeBounced(*indirect, sizeof(float) * count, model.mesh.vertexCount(),
                                          [](const ClusterModel& cluster) { return cluster.components(); });
    }
    json["errors"] = describe(model.clip_errors);
    json["provenance"] = describe(model.provenance);
    return json;
}

Json describeTransfer(const std::filesystem::path& path) {
    const TransferModel model = readTransfer(path);
    Json json{{"model", nameOf(model.kind)},
              {"sh_order", model.order},
              {"mesh", describe(model.mesh)},
              {"joints", model.skin.jointCount()},
              {"pose", model.pose_size},
              {"angles", model.angles.size()},
              {"inputs", model.inputs()},
              {"outputs", model.outputs()},
              {"alpha", model.alpha},
              {"model_bytes", modelBytes(model)},
              {"paper_bytes", paperBytes(model)},
              {"paper_mesh_bytes", paperMeshBytes(model)},
              {"holdout_clips", model.holdout_clips}};
    json["provenance"] = describe(model.provenance);
    return json;
}

Json describeLobeModel(const std::filesystem::path& path) {
    const LobeModel model = readLobes(path);
    Json json{{"sh_order", model.order},
              {"lobes", model.lobes},
              {"mesh", describe(model.mesh)},
              {"joints", model.skin.jointCount()},
              {"pose", model.pose_mean.size()},
              {"inputs", model.inputs()},
              {"input_variance", model.input_variance},
              {"clusters", model.joint_of_cluster.size()},
              {"ridge", model.ridge},
              {"model_bytes", modelBytes(model)},
              {"holdout_clips", model.holdout_clips}};
    json["errors"] = describe(model.clip_errors);
    json["provenance"] = describe(model.provenance);
    return json;
}

}  // namespace penumbra
