#include "pack/pack_transfer.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "formats/common/errors.h"
#include "pack/sections/look_section.h"
#include "pack/sections/material_section.h"
#include "sh/quadrature.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

MeshSection meshOf(const TransferModel& model) {
    MeshSection mesh;
    mesh.positions = model.mesh.rest_positions;
    mesh.normals = model.rest_normals;
    mesh.triangles = model.mesh.triangles;
    mesh.shading_point.resize(mesh.positions.size());
    std::iota(mesh.shading_point.begin(), mesh.shading_point.end(), 0u);
    mesh.source_vertex = model.mesh.source_vertex;
    mesh.influences = model.skin.influences;
    mesh.skin_joints = model.skin.joints;
    mesh.skin_weights = model.skin.weights;
    mesh.slots = model.mesh.slots;
    mesh.slot_of_vertex = model.mesh.slot_of_vertex;
    mesh.two_sided = model.mesh.two_sided;
    addSurface(model.mesh, model.skin.influences > 0 ? &model.skin : nullptr, mesh.shading_point, mesh);
    return mesh;
}

AnimationSection animationOf(const TransferModel& model) {
    AnimationSection animation{model.skin.joint_names,
                               model.skin.parents,
                               clipsOf(model.frames, model.holdout_clips),
                               model.frames.time,
                               model.bones,
                               model.pose_size,
                               model.pose,
                               model.skin.rest_transforms,
                               model.skin.inverse_bind};
    animation.input_names = model.input_names;
    const std::size_t pose = std::size_t(model.pose_size), inputs = model.input_names.size();
    for (std::size_t f = 0; inputs > 0 && f < model.frames.frameCount(); ++f)
        animation.inputs.insert(animation.inputs.end(), model.pose.begin() + std::ptrdiff_t((f + 1) * pose - inputs),
                                model.pose.begin() + std::ptrdiff_t((f + 1) * pose));
    return animation;
}

Offset<fbs::Transfer> writeTransferSection(FlatBufferBuilder& builder, const TransferModel& model,
                                           AssetPrecision precision) {
    const bool reduced = model.kind == TransferModelKind::kPca;
    const AssetPrecision fine = precision == AssetPrecision::kF32 ? precision : AssetPrecision::kF16;
    const auto angles = writeVector<std::uint32_t>(builder, model.angles);
    const auto weights = writeNumbers(builder, quantize(model.weights, model.outputs(), fine, "/transfer/weights"));
    Offset<flatbuffers::Vector<float>> pose_basis, mean;
    Offset<fbs::Numbers> basis;
    if (reduced) {
        pose_basis = writeVector<float>(builder, model.pose_basis);
        basis = writeNumbers(builder, quantize(model.basis, model.mesh.vertexCount(), precision, "/transfer/basis"));
        mean = writeVector<float>(builder, model.mean);
    }
    return fbs::CreateTransfer(builder, std::uint8_t(model.order), angles, pose_basis, weights, basis, mean,
                               float(model.alpha));
}

}  // namespace

BrdfFile diffuseMaterial(Vec3 albedo) {
    BrdfFile brdf;
    brdf.name = "diffuse";
    brdf.slice_order = 5;
    brdf.view_order = 1;
    brdf.even_index = {0};
    const auto n = std::size_t(coefficientCount(brdf.slice_order));
    std::vector<double> cosine(n), y(n);  // moments of the clamped cosine
    for (const WeightedDirection& sample : gaussHemisphere(2 * brdf.slice_order, 4 * brdf.slice_order)) {
        evalBasis(brdf.slice_order, sample.direction, std::span(y));
        for (std::size_t i = 0; i < n; ++i) cosine[i] += sample.weight * sample.direction.z * y[i];
    }
    // The one view function is the constant y_0.
    const double y0 = 0.5 * std::numbers::inv_sqrtpi;
    for (const double moment : cosine)
        for (int c = 0; c < 3; ++c)
            brdf.slices.push_back(std::abs(moment) < 1e-12 ? 0
                                                           : double(albedo[c]) * moment * std::numbers::inv_pi / y0);
    brdf.lobes = {{BrdfModel::kLambert, {}, albedo}};
    return brdf;
}

std::vector<std::byte> packTransfer(const TransferModel& model, std::span<const BrdfFile> materials,
                                    std::span<const LightFile> lights, const TransferPackOptions& options,
                                    const std::string& provenance) {
    const auto lambert = [](const BrdfFile& brdf) {
        return brdf.lobes.size() == 1 && brdf.lobes[0].model == BrdfModel::kLambert && brdf.lobe_error == 0 &&
               !brdf.membrane;
    };
    if (std::ranges::none_of(materials, lambert))
        throw Unsupported("linear transfer is diffuse, and no material is lambert");
    if (!model.mesh.morphs.empty())
        throw Unsupported("the model has morph targets, and an asset of transfer cannot move a mesh by them");
    checkNames(materials, lights);
    checkLooks(model.mesh, materials);
    FlatBufferBuilder builder(std::size_t(1) << 20);
    AssetSections sections;
    sections.mesh = writeMesh(builder, meshOf(model));
    sections.slot_material = slotMaterials(model.mesh, materials, {}, options.slots);
    sections.animation = writeAnimation(builder, animationOf(model));
    sections.transfer = writeTransferSection(builder, model, options.precision);
    for (const BrdfFile& brdf : materials) sections.materials.push_back(writeMaterial(builder, brdf));
    for (const LightFile& light : lights) sections.lights.push_back(writeLightSection(builder, light));
    const std::span<std::byte> bytes = finishAsset(builder, sections, model.order, provenance);
    return {bytes.begin(), bytes.end()};
}

}  // namespace penumbra
