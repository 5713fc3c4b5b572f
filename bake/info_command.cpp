// penumbra-bake info FILE: what is in a Penumbra file of any kind, who made it and from what.
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <memory>
#include <numbers>
#include <numeric>

#include "bake/bake_verbs.h"
#include "bake/common/print_json.h"
#include "bake/visibility/bake_visibility.h"
#include "formats/asset/asset_file.h"
#include "formats/asset/cluster_bytes.h"
#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "formats/stage/blocker_file.h"
#include "formats/stage/brdf_file.h"
#include "formats/stage/field_file.h"
#include "formats/stage/light_file.h"
#include "formats/stage/lobe_file.h"
#include "formats/stage/model_file.h"
#include "formats/stage/pose_file.h"
#include "formats/stage/stage_file_kind.h"
#include "formats/stage/transfer_file.h"
#include "formats/stage/visibility_file.h"
#include "sh/angles.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Every describer returns what it found as JSON. That goes into --report and is also printed line by line.

Json describe(const Provenance& provenance) { return Json::parse(toJson(provenance)); }

// Adds the corners of the box around the rest positions. Who places a mesh in a scene asks where its feet are.
void addRestBox(Json& json, std::span<const Vec3> positions) {
    if (positions.empty()) return;
    Vec3 low = positions[0], high = low;
    for (const Vec3 p : positions)
        for (int c = 0; c < 3; ++c) low[c] = std::min(low[c], p[c]), high[c] = std::max(high[c], p[c]);
    json["rest_low"] = {low.x, low.y, low.z};
    json["rest_high"] = {high.x, high.y, high.z};
}

Json describe(const Mesh& mesh) {
    Json json{{"vertices", mesh.vertexCount()},
              {"source_vertices", mesh.source_vertex.size()},
              {"triangles", mesh.triangles.size()},
              {"slots", mesh.slots},
              {"rest_diagonal", boxDiagonal(mesh.rest_positions)}};
    addRestBox(json, mesh.rest_positions);
    if (mesh.two_sided) json["two_sided"] = true;
    return json;
}

Json describe(const FrameList& frames) {
    Json clips = Json::array();
    for (std::size_t c = 0; c < frames.clip_names.size(); ++c) {
        const auto [begin, end] = std::equal_range(frames.clip.begin(), frames.clip.end(), std::uint16_t(c));
        Json clip{{"name", frames.clip_names[c]}, {"frames", end - begin}};
        if (begin != end) {
            clip["from_seconds"] = frames.time[std::size_t(begin - frames.clip.begin())];
            clip["to_seconds"] = frames.time[std::size_t(end - frames.clip.begin()) - 1];
        }
        clips.push_back(clip);
    }
    return clips;
}

// Tells which frames a bake of some frames has, and of how many.
Json describe(const ShardPlace& shard, const FrameList& frames) {
    std::vector<ClipFrame> here;
    for (std::size_t f = 0; f < frames.frameCount(); ++f)
        here.push_back({frames.clip_names[frames.clip[f]], shard.frame_in_clip[f]});
    return {{"frames", frames.frameCount()},
            {"of", std::accumulate(shard.clip_frames.begin(), shard.clip_frames.end(), std::uint64_t(0))},
            {"ranges", rangesText(here, 20)}};
}

// Finds the least and the greatest coefficient, and the mean open share of the hemisphere, which for transfer is
// weighted by the cosine. Reads all frames of some vertices, in the blocks that the file keeps together, or of all
// vertices.
Json describeCoefficients(const VisibilityReader& reader, bool all_vertices) {
    constexpr std::size_t kBlock = 64, kSampledBlocks = 16;
    const VisibilityHeader& header = reader.header();
    const std::size_t vertices = header.mesh.vertexCount(), blocks = (vertices + kBlock - 1) / kBlock;
    const std::size_t step = all_vertices ? 1 : std::max<std::size_t>(1, blocks / kSampledBlocks);
    const std::size_t stride = header.coefficientCount(), frames = header.frames.frameCount();
    const double unblocked = unblockedOf(header.quantity);
    double least = INFINITY, greatest = -INFINITY, open = 0;
    std::size_t read = 0;
    for (std::size_t begin = 0; begin < vertices; begin += step * kBlock) {
        throwIfInterrupted();
        const std::size_t end = std::min(begin + kBlock, vertices);
        std::vector<float> coefficients(frames * (end - begin) * stride);
        reader.readVertices(begin, end, coefficients);
        const auto [low, high] = std::minmax_element(coefficients.begin(), coefficients.end());
        least = std::min(least, double(*low));
        greatest = std::max(greatest, double(*high));
        for (std::size_t i = 0; i < coefficients.size(); i += stride) open += coefficients[i] / unblocked;
        read += end - begin;
    }
    return {{"vertices_read", read},
            {"least", least},
            {"greatest", greatest},
            {"mean_open_share", open / double(frames * read)}};
}

// Tells where the albedo came from, as the options of the bake say it; null where they do not.
Json albedoFrom(const Provenance& provenance) {
    const Json options = Json::parse(provenance.options_json, nullptr, false);
    if (!options.is_object()) return nullptr;
    if (const auto from = options.find("albedo_from"); from != options.end()) return *from;
    const auto albedo = options.find("albedo");
    if (albedo == options.end()) return nullptr;
    return albedo->is_string() ? "table " + albedo->get<std::string>() : "one colour";
}

// Tells what the surface reflects, and the shares of the rays that hit it, as means over all frames.
Json describeBounces(const VisibilityReader& reader) {
    const VisibilityHeader& header = reader.header();
    Vec3d albedo;
    for (Vec3 color : header.colors.albedo) albedo += toDouble(color) / double(header.mesh.vertexCount());
    const std::size_t frames = header.frames.frameCount();
    double hits = 0, backs = 0;
    for (std::size_t f = 0; f < frames; ++f) {
        const std::array<float, 2> shares = reader.readHitShares(f);
        hits += double(shares[0]) / double(frames);
        backs += double(shares[1]) / double(frames);
    }
    return {{"mean_albedo", {albedo.x, albedo.y, albedo.z}},
            {"albedo_from", albedoFrom(header.provenance)},
            {"transmission", !header.colors.transmission.empty()},
            {"mean_hit_share", hits},
            {"mean_back_share_of_hits", backs}};
}

Json describeVisibility(const fs::path& path, bool all_vertices) {
    const VisibilityReader reader(path);
    const VisibilityHeader& header = reader.header();
    Json json{{"quantity", header.quantity},
              {"sh_order", header.order},
              {"rays", header.rays},
              {"seed", header.seed},
              {"bounces", header.bounces}};
    if (header.ground_y) json["ground_y"] = *header.ground_y;
    if (header.local) json["local"] = {{"steps", header.local->steps}, {"sh_order", header.local->order}};
    if (header.hasBounces()) json["light_that_bounces"] = describeBounces(reader);
    json["mesh"] = describe(header.mesh);
    json["joints"] = header.skin ? header.skin->jointCount() : 0;
    json["influences"] = header.skin ? header.skin->influences : 0;
    json["pose"] = {{"numbers", header.pose_size}, {"parameterisation", header.pose_parameterisation}};
    if (!header.edges.empty()) json["edges"] = header.edges.size();
    if (!header.input_names.empty()) json["inputs"] = header.input_names;
    json["frames"] = header.frames.frameCount();
    json["clips"] = describe(header.frames);
    if (reader.isVirtual()) json["virtual"] = true;
    if (header.shard) json["shard"] = describe(*header.shard, header.frames);
    json["coefficients"] = describeCoefficients(reader, all_vertices);
    json["provenance"] = describe(header.provenance);
    return json;
}

template <class Number>
Json rangeOf(const std::vector<ClusterModel>& clusters, Number number) {
    std::vector<std::size_t> values;
    for (const ClusterModel& cluster : clusters) values.push_back(number(cluster));
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    return {{"least", *low}, {"most", *high}};
}

// Names the model by the words that the fit took.
Json describeKind(ModelKind kind, bool composed) {
    if (!composed) return {{"model", nameOf(kind)}};
    return {{"model", "composed"}, {"local_model", nameOf(kind)}};
}

// Tells what a composed model multiplies and adds. `residual` has the clusters of the residual, or none.
template <class Clusters, class Number>
Json describeComposition(int local_steps, std::size_t parts, std::size_t field_bytes, const Clusters& residual,
                         Number components) {
    Json json{
        {"parts", parts}, {"local_steps", local_steps}, {"field_bytes", field_bytes}, {"residual", !residual.empty()}};
    std::size_t sum = 0;
    for (const auto& cluster : residual) sum += components(cluster);
    if (!residual.empty()) json["residual_components"] = double(sum) / double(residual.size());
    return json;
}

// Returns the name of a part's joint, "(still)" for an occluder that stands still.
template <class Names>
std::string partName(const PartField& part, const Names& joint_names) {
    return part.joint == kStillJoint ? "(still)" : std::string(joint_names[part.joint]);
}

// Tells what light that bounces has, of an asset and of a model. A share below 0 was not measured.
template <class Indirect, class Number>
Json describeBounced(const Indirect& indirect, std::size_t bytes, std::size_t vertices, Number components) {
    std::size_t sum = 0;
    for (const auto& cluster : indirect.clusters) sum += components(cluster);
    Json json{{"bounces", indirect.bounces},
              {"sh_order", kIndirectOrder},
              {"clusters", indirect.clusters.size()},
              {"components", double(sum) / double(indirect.clusters.size())},
              {"bytes", bytes},
              {"bytes_per_vertex", double(bytes) / double(vertices)},
              {"share_of_direct", {{"train", indirect.train_share}}}};
    if (indirect.holdout_share >= 0) json["share_of_direct"]["held_out"] = indirect.holdout_share;
    return json;
}

Json describe(const std::vector<ClipError>& errors) {
    Json list = Json::array();
    for (const ClipError& error : errors)
        list.push_back({{"clip", error.clip},
                        {"held_out", error.held_out},
                        {"relative_error", error.relative_error},
                        {"rms_v", error.rms_v},
                        {"ambient_error", error.ambient_error}});
    return list;
}

Json describeModel(const fs::path& path) {
    const Model model = readModel(path);
    Json json = describeKind(model.kind, model.composition.has_value());
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
        for (const PartField& part : composed->fields.parts)
            json["part_joints"].push_back(partName(part, model.skin.joint_names));
    }
    if (const std::optional<IndirectModel>& indirect = model.indirect) {
        std::size_t numbers = 0;
        for (const ClusterModel& cluster : indirect->clusters) numbers += cluster.numberCount();
        json["bounced"] = describeBounced(*indirect, sizeof(float) * numbers, model.mesh.vertexCount(),
                                          [](const ClusterModel& cluster) { return cluster.components(); });
    }
    json["errors"] = describe(model.clip_errors);
    json["provenance"] = describe(model.provenance);
    return json;
}

Json describeTransfer(const fs::path& path) {
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
              {"bytes", modelBytes(model)},
              {"paper_bytes", paperBytes(model)},
              {"paper_mesh_bytes", paperMeshBytes(model)},
              {"holdout_clips", model.holdout_clips}};
    json["provenance"] = describe(model.provenance);
    return json;
}

Json describeLobeModel(const fs::path& path) {
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
              {"bytes", modelBytes(model)},
              {"holdout_clips", model.holdout_clips}};
    json["errors"] = describe(model.clip_errors);
    json["provenance"] = describe(model.provenance);
    return json;
}

Json describeBrdf(const fs::path& path) {
    const BrdfFile brdf = readBrdf(path);
    Json json{{"name", brdf.name},
              {"slice_order", brdf.slice_order},
              {"view_order", brdf.view_order},
              {"view_functions", brdf.even_index.size()}};
    if (const BrdfOperators& operators = brdf.operators; operators.count > 0)
        json["operators"] = {{"count", operators.count},
                             {"source", operators.source},
                             {"order", operators.order},
                             {"view_functions", operators.view_index.size()}};
    if (brdf.isLive()) json["live"] = nameOf(brdf.lobes[0].model);
    if (brdf.steps) json["steps"] = {{"values", brdf.steps->values}, {"error", brdf.steps->error}};
    if (brdf.membrane) json["membrane"] = toString(*brdf.membrane);
    json["errors"] = brdf.errors;
    json["provenance"] = describe(brdf.provenance);
    return json;
}

Json describeLobes(const LightFile& light) {
    const LightLobesFit& lobes = light.lobes;
    Json json{{"fit", lobes.mode},
              {"count", lobes.directions.size()},
              {"residual", lobes.residual},
              {"irradiance_error", lobes.irradiance_error},
              {"directions", Json::array()}};
    for (Vec3d d : lobes.directions) json["directions"].push_back({d.x, d.y, d.z});
    return json;
}

Json describeSuns(const auto& suns) {
    Json json = Json::array();
    for (const auto& sun : suns)
        json.push_back({{"direction", {sun.direction.x, sun.direction.y, sun.direction.z}},
                        {"irradiance", {sun.irradiance.x, sun.irradiance.y, sun.irradiance.z}},
                        {"radius_degrees", degrees(sun.radius)}});
    return json;
}

Json describeLight(const fs::path& path) {
    const LightFile light = readLight(path);
    Json json{{"name", light.name}, {"sh_order", light.order}, {"residual", light.residual}};
    // The mean radiance over the sphere is coefficient 0 over y_0 4 pi, y_0 = 1 / sqrt(4 pi).
    json["mean_radiance"] = Json::array();
    for (std::size_t c = 0; c < 3; ++c) json["mean_radiance"].push_back(light.sh[c] / std::sqrt(4 * std::numbers::pi));
    if (!light.window.empty()) json["window"] = light.window;
    if (!light.lobes.directions.empty()) json["lobes"] = describeLobes(light);
    if (!light.factor.empty()) {
        json["factor"] = light.factor;
        json["suns"] = describeSuns(light.suns);
        json["picture"] = {light.picture.width, light.picture.height};
    }
    json["provenance"] = describe(light.provenance);
    return json;
}

Json describePoses(const fs::path& path) {
    const PoseFile poses = readPoseFile(path);
    const std::size_t frames = poses.frames.frameCount();
    Json json{{"joints", poses.joint_names.size()}, {"frames", frames}, {"sampled", poses.sampledCount()}};
    // The distance of the frame that was chosen last: all candidates are at most this far from a chosen one.
    if (poses.mixedCount() > 0) json["mixed"] = poses.mixedCount();
    const std::size_t chosen = frames - poses.sampledCount() - poses.mixedCount();
    if (chosen > 0)
        for (std::size_t f = 0; f < frames; ++f)
            if (poses.rank[f] + 1 == chosen) json["last_distance"] = poses.distance[f];
    json["clips"] = describe(poses.frames);
    json["provenance"] = describe(poses.provenance);
    return json;
}

Json describePart(const FieldFile& file, std::size_t p) {
    const PartField& part = file.fields.parts[p];
    Json json = Json::object();
    if (!file.joint_names.empty()) json["joint"] = file.partName(p);
    json["radius"] = part.radius;
    const auto size = [](const FieldBox& box) {
        return std::to_string(box.size[0]) + "x" + std::to_string(box.size[1]) + "x" + std::to_string(box.size[2]);
    };
    json["fine_box"] = size(part.boxes[0]);
    json["coarse_box"] = size(part.boxes[1]);
    json["points"] = part.pointCount();
    json["bytes"] = file.fields.values[p].size() + file.fields.distances[p].size();
    return json;
}

// Tells how the mesh of a fields file moves that has no joints.
std::string motionText(const OccluderMotion& motion) {
    if (!motion.follows.empty()) return "follows " + motion.follows;
    return motion.moves ? "moves" : "stands still";
}

Json describeFields(const fs::path& path) {
    const FieldFile file = readFieldShard(path);
    const std::size_t count = file.partCount(), first = file.shard ? file.shard->first_part : 0;
    Json json{{"sh_order", kFieldOrder}, {"joints", file.joint_names.size()}, {"vertices", file.vertex_count},
              {"rays", file.rays},       {"fade", file.fields.fade},          {"field_bytes", file.fields.byteCount()},
              {"part_count", count}};
    if (file.joint_names.empty()) json["occluder"] = motionText(file.motion);
    if (file.shard) json["shard"] = std::to_string(first) + ":" + std::to_string(first + file.fields.parts.size());
    json["parts"] = Json::array();
    for (std::size_t p = 0; p < file.fields.parts.size(); ++p) json["parts"].push_back(describePart(file, p));
    // A row a part: its distances in the skeleton from all parts.
    json["steps"] = Json::array();
    for (std::size_t p = 0; p < count; ++p) {
        const auto row = file.steps.begin() + std::ptrdiff_t(p * count);
        json["steps"].push_back(std::vector<int>(row, row + std::ptrdiff_t(count)));
    }
    json["provenance"] = describe(file.provenance);
    return json;
}

// Lists each sphere with its joint. Of an asset and of a blockers file.
template <class Spheres, class Joints, class Names>
Json describeSpheres(const Spheres& spheres, const Joints& joints, const Names& joint_names) {
    Json json = Json::array();
    for (std::size_t s = 0; s < spheres.size(); ++s) {
        const Vec3 center = spheres[s].centre;
        json.push_back({{"joint", joint_names[joints[s]]},
                        {"center", {center.x, center.y, center.z}},
                        {"radius", spheres[s].radius}});
    }
    return json;
}

Json describeBlockers(const fs::path& path) {
    const BlockerFile file = readBlockers(path);
    return {{"method", file.method},
            {"joints", file.joint_names.size()},
            {"scale", file.scale},
            {"mesh_area", file.mesh_area},
            {"area", file.area},
            {"blockers", describeSpheres(file.blockers.spheres, file.blockers.joints, file.joint_names)},
            {"provenance", describe(file.provenance)}};
}

void describeAssetModel(const AssetView& asset, Json& json) {
    const ModelView& model = asset.model;
    json["model"] = describeKind(model.kind, model.composition.has_value());
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

Json describeLight(const LightView& light) {
    Json json{{"name", light.name}, {"sh_order", light.order}};
    if (!light.suns.empty()) json["suns"] = describeSuns(light.suns);
    if (light.picture.width > 0) json["picture"] = {light.picture.width, light.picture.height};
    return json;
}

Json describeAsset(const fs::path& path) {
    const MappedFile file(path);
    AssetView asset;
    try {
        asset = openAsset(file.bytes());
    } catch (const InvalidInput& error) {
        throw InvalidInput(path.string() + ": " + error.what());
    }
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
    for (const MaterialView& material : asset.materials)
        json["materials"].push_back({{"name", material.name},
                                     {"slice_form", nameOf(material.slice_form)},
                                     {"bytes", material.stored_slices.size_bytes() + material.operators.u.size_bytes() +
                                                   material.operators.w.size_bytes()}});
    for (const LightView& light : asset.lights) json["lights"].push_back(describeLight(light));
    if (const BlockersView& blockers = asset.blockers; !blockers.spheres.empty())
        json["blockers"] = describeSpheres(blockers.spheres, blockers.joints, asset.animation.joint_names);
    json["provenance"] = Json::parse(asset.provenance, nullptr, false);
    return json;
}

// --- The verb -------------------------------------------------------------------------------------------------------

Json describeFile(const fs::path& path, bool all_vertices) {
    std::array<char, 8> head{};
    std::ifstream(path, std::ios::binary).read(head.data(), head.size());
    Json json{{"file", path.string()}, {"bytes", fs::file_size(path)}};
    std::string format = "penumbra.asset";
    Json content;
    if (std::string_view(head.data() + 4, 4) == kAssetIdentifier) {
        content = describeAsset(path);
    } else {
        format = stageFileKind(path);
        if (format == "penumbra.visibility") content = describeVisibility(path, all_vertices);
        if (format == "penumbra.model") content = describeModel(path);
        if (format == "penumbra.brdf") content = describeBrdf(path);
        if (format == "penumbra.poses") content = describePoses(path);
        if (format == "penumbra.fields") content = describeFields(path);
        if (format == "penumbra.light") content = describeLight(path);
        if (format == "penumbra.transfer") content = describeTransfer(path);
        if (format == "penumbra.lobes") content = describeLobeModel(path);
        if (format == "penumbra.blockers") content = describeBlockers(path);
        if (content.is_null()) throw Unsupported(path.string() + ": attribute format: \"" + format + "\" is unknown");
    }
    json["format"] = format;
    json.update(content);
    return json;
}

struct InfoCommand {
    std::string file;
    bool all = false;
};

}  // namespace

Verb infoVerb() {
    const auto command = std::make_shared<InfoCommand>();
    Verb verb;
    verb.name = "info";
    verb.help = "What is in a Penumbra file of any kind, who made it and from what.";
    verb.define = [command](CLI::App& app) {
        app.add_option(
               "file", command->file,
               ".vis.h5, .poses.h5, .fields.h5, .model.h5, .lobes.h5, .transfer.h5, .brdf.h5, .light.h5, .blockers.h5 "
               "or .pnb")
            ->required();
        app.add_flag("--all", command->all, "read the visibility of all vertices, not of some, for its range");
    };
    verb.inputs = [command] { return std::vector<fs::path>{command->file}; };
    verb.run = [command](const CommonOptions&, Report& report) {
        report.phase("read");
        report.figures = describeFile(command->file, command->all);
        printJson(report.figures);
    };
    return verb;
}

}  // namespace penumbra
