#include "pack/pack_truth.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "formats/common/errors.h"
#include "formats/common/fp16.h"
#include "formats/common/joined.h"
#include "formats/common/write_file.h"
#include "pack/sections/asset_writer.h"

namespace penumbra {

constexpr std::size_t kLargestTruth = 2000000000;  // FlatBuffers' offsets end at 2 GiB; mesh and poses need the rest

TruthPlan planTruth(const VisibilityReader& reader, const TruthOptions& options) {
    const VisibilityHeader& header = reader.header();
    if (header.quantity != kHemisphereVisibility && header.quantity != kDiffuseTransfer)
        throw InvalidInput("quantity is " + header.quantity + "; truth is hemisphere_visibility or diffuse_transfer");
    const std::vector<std::string>& known = header.frames.clip_names;
    for (const std::string& clip : options.clips)
        if (std::find(known.begin(), known.end(), clip) == known.end())
            throw BadOption("clips", "no clip \"" + clip + "\"; there are: " + joined(known));
    TruthPlan plan;
    for (std::size_t f = 0; f < header.frames.frameCount(); ++f) {
        const std::string& clip = known[header.frames.clip[f]];
        if (options.clips.empty() || std::find(options.clips.begin(), options.clips.end(), clip) != options.clips.end())
            plan.frames.push_back(f);
    }
    plan.bytes =
        plan.frames.size() * header.mesh.vertexCount() * header.coefficientCount() * bytesPerNumber(options.precision);
    if (plan.bytes > kLargestTruth)
        throw BadOption("clips", "the moments would take " + std::to_string(plan.bytes) + " bytes; an asset holds " +
                                     std::to_string(kLargestTruth) + ": choose fewer, or precision f16");
    return plan;
}

namespace {

MeshSection meshOf(const VisibilityHeader& header) {
    MeshSection mesh;
    mesh.positions = header.mesh.rest_positions;
    mesh.normals = header.rest_normals;
    mesh.triangles = header.mesh.triangles;
    mesh.source_vertex = header.mesh.source_vertex;
    mesh.two_sided = header.mesh.two_sided;
    mesh.morphs = header.mesh.morphs;
    mesh.slots = header.mesh.slots;
    mesh.slot_of_vertex = header.mesh.slot_of_vertex;
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) mesh.shading_point.push_back(v);
    if (header.skin) {
        mesh.influences = header.skin->influences;
        mesh.skin_joints = header.skin->joints;
        mesh.skin_weights = header.skin->weights;
    }
    addSurface(header.mesh, header.skin ? &*header.skin : nullptr, mesh.shading_point, mesh);
    return mesh;
}

// Stores the moments of one frame at their place in the file.
void storeMoments(std::span<const float> moments, AssetPrecision precision, std::uint8_t* to) {
    for (float b : moments)
        if (!(std::abs(b) < 1e4f)) throw InvalidInput("/visibility/coefficients: a moment is not finite, or above 1e4");
    if (precision == AssetPrecision::kF32)
        std::memcpy(to, moments.data(), moments.size_bytes());
    else
        floatToHalf(moments, {reinterpret_cast<std::uint16_t*>(to), moments.size()});
}

}  // namespace

void packTruth(const VisibilityReader& reader, const TruthPlan& plan, const TruthOptions& options,
               const std::string& provenance, const std::filesystem::path& output,
               const std::function<void(std::size_t)>& progress) {
    const VisibilityHeader& header = reader.header();
    // The builder gets room for everything at the start: growing would copy the moments and double the memory.
    FlatBufferBuilder builder(plan.bytes + (std::size_t(1) << 20));
    std::uint8_t* moments = nullptr;
    builder.ForceVectorAlignment(plan.bytes, 1, 16);
    Offset<flatbuffers::Vector<std::uint8_t>> data = builder.CreateUninitializedVector(plan.bytes, &moments);
    AnimationSection animation;
    animation.input_names = header.input_names;
    FrameList frames;
    frames.clip_names = header.frames.clip_names;
    if (header.skin) {
        animation.joint_names = header.skin->joint_names;
        animation.parents = header.skin->parents;
        animation.rest_transforms = header.skin->rest_transforms;
        animation.inverse_bind = header.skin->inverse_bind;
    }
    std::vector<Vec3> positions;  // only for a deforming mesh
    const auto fronts = std::ptrdiff_t(header.mesh.frontVertexCount());
    const std::size_t frame_bytes = plan.frames.empty() ? 0 : plan.bytes / plan.frames.size();
    for (std::size_t i = 0; i < plan.frames.size(); ++i) {
        throwIfInterrupted();
        const VisibilityFrame frame = reader.readFrame(plan.frames[i]);
        storeMoments(frame.coefficients, options.precision, moments + i * frame_bytes);
        animation.bones.insert(animation.bones.end(), frame.bones.begin(), frame.bones.end());
        if (!header.skin) positions.insert(positions.end(), frame.positions.begin(), frame.positions.begin() + fronts);
        animation.inputs.insert(animation.inputs.end(), frame.pose.end() - std::ptrdiff_t(header.input_names.size()),
                                frame.pose.end());
        frames.clip.push_back(header.frames.clip[plan.frames[i]]);
        frames.time.push_back(header.frames.time[plan.frames[i]]);
        progress(i + 1);
    }
    animation.playback = quantizePositions(positions);
    animation.times = frames.time;
    animation.clips = clipsOf(frames, {});
    AssetSections sections;
    sections.truth = fbs::CreateTruth(builder, std::uint8_t(header.order), fbs::Precision(options.precision), data,
                                      header.quantity == kDiffuseTransfer);
    sections.mesh = writeMesh(builder, meshOf(header));
    sections.animation = writeAnimation(builder, animation);
    writeWholeFile(output, finishAsset(builder, sections, header.order, provenance));
}

}  // namespace penumbra
