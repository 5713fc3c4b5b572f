#include "pack/pack_asset.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "formats/asset/asset_kinds.h"
#include "formats/common/errors.h"
#include "pack/compress/compress_model.h"
#include "pack/compress/packing_error.h"
#include "pack/pack_indirect.h"
#include "pack/pack_within.h"
#include "pack/sections/asset_writer.h"
#include "pack/sections/composition_section.h"
#include "pack/sections/look_section.h"
#include "pack/sections/material_section.h"
#include "pack/sections/mesh_section.h"

namespace penumbra {

namespace {

// Fills up each row of `size` numbers with zeros to `stride`.
std::vector<float> padded(std::span<const float> numbers, std::size_t size, std::size_t stride) {
    std::vector<float> out(numbers.size() / size * stride, 0.0f);
    for (std::size_t row = 0; row * size < numbers.size(); ++row)
        std::copy_n(numbers.begin() + std::ptrdiff_t(row * size), size, out.begin() + std::ptrdiff_t(row * stride));
    return out;
}

// Returns the units of a cluster, which ClusterModel::units() cannot tell where no components are left.
std::size_t unitsOf(const Model& model, const ClusterModel& cluster) {
    switch (model.kind) {
        case ModelKind::kLinear:
            break;
        case ModelKind::kQuadratic:
            return quadraticUnits(cluster.inputs());
        case ModelKind::kNeural:
            return cluster.hidden.size() / (cluster.inputs() + 1);
        case ModelKind::kAdditive:
            return cluster.unit_group.size();
    }
    return cluster.inputs();
}

// Precision of the basis, and of the regression's weights and units. Mean and units have half precision at least,
// except for those of light that bounces.
struct Precisions {
    AssetPrecision basis, weights;
    AssetPrecision coarsest_mean = AssetPrecision::kF16;
    AssetPrecision coarsest_units = AssetPrecision::kF16;
};

Offset<fbs::Cluster> writeCluster(FlatBufferBuilder& builder, const Model& model, const ClusterModel& cluster,
                                  std::size_t size, const std::string& what, std::uint32_t first_vertex,
                                  Precisions precisions) {
    const AssetPrecision precision = precisions.basis;
    const AssetPrecision fine = precision == AssetPrecision::kF32 ? precision : AssetPrecision::kF16;
    const AssetPrecision of_mean = precision == AssetPrecision::kI8 ? precisions.coarsest_mean : fine;
    const AssetPrecision of_units =
        precisions.weights == AssetPrecision::kF16 ? precisions.coarsest_units : precisions.weights;
    const std::size_t stride = (size + 3) / 4 * 4;
    const std::size_t row = cluster.vertices.size() * stride;
    const auto feature_mean = writeVector<float>(builder, cluster.feature_mean);
    const auto input_basis =
        writeNumbers(builder, quantize(cluster.input_basis, cluster.feature_mean.size(), fine, what + ".input_basis"));
    const auto input_min = writeVector<float>(builder, cluster.input_min);
    const auto input_max = writeVector<float>(builder, cluster.input_max);
    const auto center = writeVector<float>(builder, std::span(&cluster.center, 1));
    const std::vector<std::uint16_t> joints(cluster.groups.begin(), cluster.groups.end());
    const auto groups = writeVector<std::uint16_t>(builder, joints);
    const auto group_weight = writeVector<float>(builder, cluster.group_weight);
    const std::size_t group_size = groupInputs(model.features), units = unitsOf(model, cluster);
    const auto group_min = writeNumbers(builder, quantize(cluster.group_min, group_size, fine, what + ".group_min"));
    const auto group_max = writeNumbers(builder, quantize(cluster.group_max, group_size, fine, what + ".group_max"));
    const std::size_t width = model.kind == ModelKind::kNeural     ? cluster.inputs() + 1
                              : model.kind == ModelKind::kAdditive ? group_size
                                                                   : 0;
    const auto hidden = writeNumbers(builder, quantize(cluster.hidden, width, of_units, what + ".hidden"));
    const std::vector<std::uint16_t> unit_groups(cluster.unit_group.begin(), cluster.unit_group.end());
    const auto unit_group = writeVector<std::uint16_t>(builder, unit_groups);
    const auto weights = writeNumbers(builder, quantize(cluster.weights, units, precisions.weights, what + ".weights"));
    const auto bias = writeVector<float>(builder, cluster.bias);
    const auto mean = writeNumbers(builder, quantize(padded(cluster.mean, size, stride), row, of_mean, what + ".mean"));
    const auto basis =
        writeNumbers(builder, quantize(padded(cluster.basis, size, stride), row, precision, what + ".basis"));
    return fbs::CreateCluster(builder, std::uint16_t(cluster.joint), first_vertex,
                              std::uint32_t(cluster.vertices.size()), center, feature_mean, input_basis, input_min,
                              input_max, groups, group_weight, group_min, group_max, hidden, unit_group, weights, bias,
                              mean, basis);
}

Offset<flatbuffers::Vector<Offset<fbs::InputJoint>>> writeInputJoints(FlatBufferBuilder& builder,
                                                                      const std::vector<InputJoint>& joints) {
    std::vector<Offset<fbs::InputJoint>> written;
    for (const InputJoint& input : joints)
        written.push_back(fbs::CreateInputJoint(builder, std::uint16_t(input.joint), input.column,
                                                std::uint8_t(input.columns), input.offset, input.scale));
    return builder.CreateVector(written);
}

std::vector<Offset<fbs::Cluster>> writeClusters(FlatBufferBuilder& builder, const Model& model,
                                                const std::vector<ClusterModel>& clusters, std::size_t size,
                                                const std::string& what, Precisions precisions) {
    std::vector<Offset<fbs::Cluster>> written;
    std::uint32_t next = 0;
    for (const ClusterModel& cluster : clusters) {
        written.push_back(writeCluster(builder, model, cluster, size, what + "[" + std::to_string(written.size()) + "]",
                                       next, precisions));
        next += std::uint32_t(cluster.vertices.size());
    }
    return written;
}

Offset<fbs::Indirect> writeIndirect(FlatBufferBuilder& builder, const Model& model, Precisions precisions,
                                    double packing_error) {
    const IndirectModel& indirect = *model.indirect;
    precisions.coarsest_mean = precisions.coarsest_units = AssetPrecision::kI8;
    const auto clusters = builder.CreateVector(
        writeClusters(builder, model, indirect.clusters, kIndirectSize, "model.indirect.clusters", precisions));
    const auto axes = writeVector<float>(builder, std::span(&indirect.axes, 1));
    const double held_out = std::isfinite(indirect.holdout_share) ? indirect.holdout_share : -1;
    return fbs::CreateIndirect(builder, std::uint8_t(indirect.bounces), axes, clusters, float(indirect.train_share),
                               float(held_out), float(packing_error));
}

// What of a model its section has beside the numbers of the model file.
struct ModelExtras {
    double quantization_error;
    const PackedIndirect& indirect;
    VertexParts vertices;  // of the mesh section
};

Offset<fbs::Model> writeModelSection(FlatBufferBuilder& builder, const Model& model, Precisions precisions,
                                     const ModelExtras& extras) {
    const auto size = std::size_t(model.convention.size());
    const std::vector<Offset<fbs::Cluster>> clusters =
        writeClusters(builder, model, model.clusters, size, "model.clusters", precisions);
    const auto convention = builder.CreateString(model.convention.name());
    const auto centers = writeVector<float>(builder, model.joint_centers);
    const auto spreads = writeVector<float>(builder, model.joint_spreads);
    const auto cluster_vector = builder.CreateVector(clusters);
    Offset<flatbuffers::Vector<Offset<fbs::InputJoint>>> input_joints;
    if (!model.input_joints.empty()) input_joints = writeInputJoints(builder, model.input_joints);
    Offset<flatbuffers::Vector<float>> pose_mean;
    Offset<fbs::Numbers> pose_basis;
    if (model.features == FeatureKind::kDihedrals) {
        const AssetPrecision fine = precisions.basis == AssetPrecision::kF32 ? precisions.basis : AssetPrecision::kF16;
        pose_mean = writeVector<float>(builder, model.pose_mean);
        pose_basis =
            writeNumbers(builder, quantize(model.pose_basis, model.pose_mean.size(), fine, "model.pose_basis"));
    }
    Offset<fbs::Composition> composition;
    if (model.composition)
        composition = writeComposition(
            builder, *model.composition, extras.vertices,
            writeClusters(builder, model, model.composition->residual, size, "model.composition.residual", precisions));
    Offset<fbs::Indirect> bounced;
    if (model.indirect)
        bounced = writeIndirect(builder, model, {precisions.basis, extras.indirect.weights}, extras.indirect.error);
    return fbs::CreateModel(builder, toStored(model.kind), toStored(model.features), convention,
                            std::uint8_t((model.convention.size() + 3) / 4 * 4), float(model.feature_scale), centers,
                            spreads, cluster_vector, float(extras.quantization_error), model.deforming, input_joints,
                            pose_mean, pose_basis, composition, bounced);
}

// Tells what an asset stores of the frames. An attempt keeps the bones, because comparePacked() needs them.
enum class FramesOf { kAttempt, kPlayback, kNoPlayback };

AnimationSection animationOf(const Model& model, FramesOf frames) {
    AnimationSection animation{model.skin.joint_names,
                               model.skin.parents,
                               clipsOf(model.frames, model.holdout_clips),
                               model.frames.time,
                               model.bones,
                               model.pose_size,
                               {},
                               model.skin.rest_transforms,
                               model.skin.inverse_bind};
    if (model.features != FeatureKind::kRelativeBones) animation.pose = model.pose;
    const std::size_t pose = std::size_t(model.pose_size), inputs = model.input_names.size();
    animation.input_names = model.input_names;
    for (std::size_t f = 0; inputs > 0 && f < model.frames.frameCount(); ++f)
        animation.inputs.insert(animation.inputs.end(), model.pose.begin() + std::ptrdiff_t((f + 1) * pose - inputs),
                                model.pose.begin() + std::ptrdiff_t((f + 1) * pose));
    if (frames == FramesOf::kAttempt || (!model.deforming && frames == FramesOf::kPlayback)) return animation;
    animation.bones.clear();  // of a deforming mesh they follow from the positions
    animation.pose.clear();
    if (!model.deforming) {
        animation.clips.clear();
        animation.times.clear();
        animation.inputs.clear();
    }
    if (frames == FramesOf::kPlayback) animation.playback = quantizePositions(model.positions);
    return animation;
}

// What an asset holds beside the model.
struct Additions {
    std::span<const BrdfFile> materials;
    std::span<const LightFile> lights;
    std::vector<std::uint16_t> slot_material;
    SphereBlockers blockers;
    PackedIndirect indirect = {};
    const SurfaceLook* surface = nullptr;  // its materials follow `materials`
};

std::vector<std::byte> packOnce(const Model& model, const Additions& additions, Precisions precisions, double error,
                                FramesOf frames, const std::string& provenance) {
    FlatBufferBuilder builder(1 << 20);
    AssetSections sections;
    // An attempt is compared by its clusters alone, which dense vertices are not of.
    const MeshSection mesh = model.drawn && frames != FramesOf::kAttempt ? denseSection(model) : meshSection(model);
    sections.mesh = writeMesh(builder, mesh);
    sections.slot_material = additions.slot_material;
    sections.animation = writeAnimation(builder, animationOf(model, frames));
    sections.model = writeModelSection(builder, model, precisions, {error, additions.indirect, partsOf(model, mesh)});
    for (const BrdfFile& brdf : additions.materials) sections.materials.push_back(writeMaterial(builder, brdf));
    if (additions.surface) {
        for (const BrdfFile& brdf : additions.surface->materials)
            sections.materials.push_back(writeMaterial(builder, brdf));
        sections.surface = writeSurface(builder, *additions.surface, mesh.triangles, mesh.positions.size(),
                                        additions.materials.size());
    }
    for (const LightFile& light : additions.lights) sections.lights.push_back(writeLightSection(builder, light));
    sections.blockers = additions.blockers;
    const std::span<std::byte> bytes = finishAsset(builder, sections, model.convention.order, provenance);
    return {bytes.begin(), bytes.end()};  // a copy, because the builder's buffer is not 16-byte aligned
}

}  // namespace

std::vector<std::byte> packLibrary(std::span<const BrdfFile> materials, std::span<const LightFile> lights,
                                   const std::string& provenance) {
    if (materials.empty() && lights.empty())
        throw BadOption("model", "nothing to pack: neither a model nor a material or light");
    checkNames(materials, lights);
    FlatBufferBuilder builder;
    AssetSections sections;
    int order = 1;  // the highest order that is in the file
    for (const BrdfFile& brdf : materials) sections.materials.push_back(writeMaterial(builder, brdf));
    for (const LightFile& light : lights) {
        sections.lights.push_back(writeLightSection(builder, light));
        order = std::max(order, light.order);
    }
    const std::span<std::byte> bytes = finishAsset(builder, sections, order, provenance);
    return {bytes.begin(), bytes.end()};
}

namespace {

// Checks what the reader of the model file promises and what a model made in memory may break.
void checkModel(const Model& model) {
    std::vector<bool> seen(model.mesh.vertexCount());
    std::size_t count = 0;
    for (const ClusterModel& cluster : model.clusters)
        for (std::uint32_t v : cluster.vertices) {
            if (v >= seen.size() || seen[v])
                throw InvalidInput("model.clusters: vertex " + std::to_string(v) +
                                   " is out of range or in two clusters");
            seen[v] = true;
            ++count;
        }
    if (count != seen.size()) throw InvalidInput("model.clusters: not every vertex is in a cluster");
    const auto checkSame = [&](const std::vector<ClusterModel>& clusters, const std::string& what) {
        const auto same = [](const ClusterModel& a, const ClusterModel& b) { return a.vertices == b.vertices; };
        if (!std::equal(clusters.begin(), clusters.end(), model.clusters.begin(), model.clusters.end(), same))
            throw InvalidInput(what + ": has not the clusters of the model");
    };
    if (model.composition && !model.composition->residual.empty())
        checkSame(model.composition->residual, "model.composition.residual");
    if (model.indirect) checkSame(model.indirect->clusters, "model.indirect");
    if (model.skin.influences < 1 || model.skin.influences > 255)
        throw InvalidInput("model.skin: " + std::to_string(model.skin.influences) + " influences; 1..255 are possible");
}

// Chooses half precision for the weights unless that makes a difference. The weights of a model of few training
// frames can be large and nearly cancel (18% of the signal for an additive model of 38 frames), or be too large for a
// half.
AssetPrecision weightPrecision(const Model& model, int threads) {
    const auto large = [](const std::vector<float>& v) {
        return std::any_of(v.begin(), v.end(), [](float x) { return std::abs(x) > 60000; });
    };
    for (const ClusterModel* cluster : allClusters(model))
        if (large(cluster->weights) || large(cluster->hidden)) return AssetPrecision::kF32;
    constexpr double kFelt = 0.02;  // share of the signal; rounding the basis to bytes costs as much
    const auto packed = [&](AssetPrecision precision) {
        return packOnce(model, {}, {precision, precision}, 0, FramesOf::kAttempt, "{}");
    };
    const std::vector<std::byte> half = packed(AssetPrecision::kF16), exact = packed(AssetPrecision::kF32);
    const double error = comparePacked(openAsset(half), openAsset(exact), threads).relative();
    return error > kFelt ? AssetPrecision::kF32 : AssetPrecision::kF16;
}

std::optional<double> indirectBound(const PackOptions& options) {
    const bool as_it_is = options.precision && !options.max_error && !options.max_bytes_per_vertex;
    if (options.indirect_bytes_per_vertex || as_it_is) return options.indirect_bytes_per_vertex;
    return kBouncedBytes;
}

}  // namespace

namespace {

// Gives the slots that the options do not name the diffuse material of their surface.
std::vector<std::uint16_t> surfaceSlotMaterials(const Mesh& mesh, std::span<const BrdfFile> materials,
                                                const PackOptions& options) {
    std::vector<std::uint16_t> out;
    for (const SlotSurface& slot : options.surface->surface.slots)
        out.push_back(std::uint16_t(materials.size() + slot.materials.diffuse));
    const std::vector<std::string_view> slots(mesh.slots.begin(), mesh.slots.end());
    const std::vector<std::uint16_t> chosen = slotMaterials(mesh, materials, options.slot_materials, options.slots);
    for (const SlotChoice& choice : options.slots)
        for (const std::size_t slot : findSlots(slots, choice.slot)) out[slot] = chosen[slot];
    if (mesh.slots.empty()) out.clear();
    return out;
}

}  // namespace

Packed packAsset(const Model& given, std::span<const BrdfFile> materials, std::span<const LightFile> lights,
                 const PackOptions& options, const std::string& provenance, int threads) {
    checkNames(materials, lights);
    checkModel(given);
    if (given.drawn && given.indirect)
        throw Unsupported("light that bounces does not go with chosen points of a bake: bake all vertices");
    if (given.drawn && options.surface)
        throw Unsupported("textures do not go with chosen points of a bake: bake all vertices");
    checkLooks(given.mesh, materials);
    Model model = given;
    Additions additions{materials, lights, slotMaterials(model.mesh, materials, options.slot_materials, options.slots),
                        options.blockers};
    if (options.surface) {
        std::vector<BrdfFile> all(materials.begin(), materials.end());
        all.insert(all.end(), options.surface->materials.begin(), options.surface->materials.end());
        checkNames(all, lights);
        additions.surface = &*options.surface;
        additions.slot_material = surfaceSlotMaterials(model.mesh, materials, options);
    }
    if (model.indirect)
        additions.indirect = shrinkIndirect(
            model, options.precision.value_or(AssetPrecision::kI8), indirectBound(options),
            [](const Model& attempt, AssetPrecision precision, const PackedIndirect& indirect) {
                const Additions alone{{}, {}, {}, {}, indirect};
                return packOnce(attempt, alone, {precision, AssetPrecision::kF32}, 0, FramesOf::kAttempt, "{}");
            });
    const AssetPrecision weights =
        options.precision == AssetPrecision::kF32 ? AssetPrecision::kF32 : weightPrecision(model, threads);
    const WriteAsset write = [&](const Model& chosen, AssetPrecision precision, std::optional<double> error) {
        const bool exact = precision == AssetPrecision::kF32;
        const FramesOf frames = !error             ? FramesOf::kAttempt
                                : options.playback ? FramesOf::kPlayback
                                                   : FramesOf::kNoPlayback;
        return packOnce(chosen, additions, {precision, exact ? precision : weights}, error.value_or(0), frames,
                        provenance);
    };
    Packed packed = packWithin(model, options, write, threads);
    packed.indirect_error = additions.indirect.error;
    packed.indirect_components = additions.indirect.components;
    packed.all_indirect_components = additions.indirect.all_components;
    return packed;
}

}  // namespace penumbra
