#include "pack/sections/asset_writer.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "formats/common/errors.h"
#include "formats/common/twin_triangles.h"
#include "sh/bounding_box.h"
#include "sh/sh_basis.h"

namespace penumbra {

Offset<fbs::Numbers> writeNumbers(FlatBufferBuilder& builder, const StoredNumbers& numbers) {
    const auto data = writeVector<std::uint8_t>(builder, numbers.data);
    const auto scale = writeVector<float>(builder, numbers.scale);
    return fbs::CreateNumbers(builder, fbs::Precision(numbers.precision), std::uint32_t(numbers.count),
                              std::uint32_t(numbers.row_length), data, scale);
}

static Offset<fbs::Morphs> writeMorphs(FlatBufferBuilder& builder, const MorphTargets& morphs) {
    if (morphs.empty()) return {};
    const auto rest_weights = writeVector<float>(builder, morphs.rest_weights);
    const auto first = writeVector<std::uint32_t>(builder, morphs.first);
    const auto vertices = writeVector<std::uint32_t>(builder, morphs.vertices);
    const auto positions = writeVector<float>(builder, morphs.positions);
    const auto normals = writeVector<float>(builder, morphs.normals);
    return fbs::CreateMorphs(builder, rest_weights, first, vertices, positions, normals);
}

Offset<fbs::Mesh> writeMesh(FlatBufferBuilder& builder, const MeshSection& mesh) {
    const auto positions = writeVector<float>(builder, mesh.positions);
    const auto normals = writeVector<float>(builder, mesh.normals);
    const auto tangents = writeVector<float>(builder, mesh.tangents);
    const auto triangles = writeVector<std::uint32_t>(builder, mesh.triangles);
    const auto shading_point = writeVector<std::uint32_t>(builder, mesh.shading_point);
    const auto source_vertex = writeVector<std::uint32_t>(builder, mesh.source_vertex);
    const auto joints = writeVector<std::uint16_t>(builder, mesh.skin_joints);
    const auto weights = writeVector<float>(builder, mesh.skin_weights);
    Offset<flatbuffers::Vector<Offset<flatbuffers::String>>> slots;
    Offset<flatbuffers::Vector<std::uint16_t>> slot_of_vertex;
    if (!mesh.slots.empty()) {
        slots = builder.CreateVectorOfStrings(mesh.slots);
        slot_of_vertex = writeVector<std::uint16_t>(builder, mesh.slot_of_vertex);
    }
    Offset<flatbuffers::Vector<std::uint32_t>> casting;
    if (!mesh.casting.empty()) casting = writeVector<std::uint32_t>(builder, mesh.casting);
    const Offset<fbs::Morphs> morphs = writeMorphs(builder, mesh.morphs);
    Offset<flatbuffers::Vector<std::uint32_t>> corners;
    Offset<flatbuffers::Vector<float>> corner_weights;
    if (!mesh.point_corners.empty()) {
        corners = writeVector<std::uint32_t>(builder, mesh.point_corners);
        corner_weights = writeVector<float>(builder, mesh.point_weights);
    }
    return fbs::CreateMesh(builder, positions, normals, tangents, triangles, shading_point, source_vertex,
                           std::uint8_t(mesh.influences), joints, weights, slots, slot_of_vertex, mesh.two_sided,
                           morphs, mesh.cull_backs, casting, corners, corner_weights);
}

// A depth map holds one depth a texel, so a triangle casts or does not. Those with the mean opacity a cast as often as
// a says. Which ones tells the carry of the shares that were left over before (error diffusion), so that of neighbours,
// which follow one another in most files, as many cast as their opacity says.
void addSurface(const Mesh& mesh, const Skin* skin, std::span<const std::uint32_t> new_of_old, MeshSection& section) {
    const std::vector<std::uint32_t> twins =
        skin && !mesh.two_sided ? twinTriangles(mesh, *skin) : std::vector<std::uint32_t>{};
    section.cull_backs = !twins.empty();
    const std::vector<std::uint8_t> opacity = meanOpacity(mesh.opacity, mesh.frontTriangleCount());
    int carry = kStopsAll / 2;
    for (std::size_t t = 0; t < opacity.size(); ++t) {
        if (!twins.empty() && twins[t] < t) continue;
        carry += opacity[t];
        const auto [a, b, c] = mesh.triangles[t];
        if (carry >= kStopsAll) section.casting.push_back({new_of_old[a], new_of_old[b], new_of_old[c]});
        if (carry >= kStopsAll) carry -= kStopsAll;
    }
    // An empty list says that all cast, so where none does there is one without area.
    if (!opacity.empty() && section.casting.empty()) section.casting.push_back({0, 0, 0});
}

// Computes in double and rounds once to what is stored, so that the measured error is the one that readers see.
PlaybackSection quantizePositions(std::span<const Vec3> positions) {
    PlaybackSection playback;
    if (positions.empty()) return playback;
    for (const Vec3& p : positions)
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            throw InvalidInput("positions: a number is not finite");
    const auto [low, high] = boundsOf(positions);
    constexpr double kSteps = 65535;
    double side = 0;
    for (int i = 0; i < 3; ++i) side = std::max(side, double(high[i]) - low[i]);
    playback.origin = low;
    playback.step = float(side / kSteps);
    double error = 0;
    for (const Vec3& p : positions) {
        double squared = 0;
        for (int i = 0; i < 3; ++i) {
            const double steps = playback.step > 0 ? (double(p[i]) - low[i]) / playback.step : 0;
            const auto number = std::uint16_t(std::clamp(std::round(steps), 0.0, kSteps));
            playback.positions.push_back(number);
            const double there = low[i] + playback.step * float(number);  // readPositions() computes it in the same way
            squared += (there - p[i]) * (there - p[i]);
        }
        error = std::max(error, squared);
    }
    playback.error = std::nextafter(float(std::sqrt(error)), std::numeric_limits<float>::max());
    return playback;
}

Offset<fbs::Animation> writeAnimation(FlatBufferBuilder& builder, const AnimationSection& animation) {
    const auto names = builder.CreateVectorOfStrings(animation.joint_names);
    const auto parents = writeVector<std::int32_t>(builder, animation.parents);
    std::vector<Offset<fbs::Clip>> clips;
    for (const ClipView& clip : animation.clips)
        clips.push_back(fbs::CreateClip(builder, builder.CreateString(clip.name.data(), clip.name.size()),
                                        clip.first_frame, clip.frame_count, clip.held_out));
    const auto clip_vector = builder.CreateVector(clips);
    const auto times = writeVector<double>(builder, animation.times);
    const auto bones = writeVector<float>(builder, animation.bones);
    const auto pose = writeVector<float>(builder, animation.pose);
    Offset<flatbuffers::Vector<float>> rest, inverse_bind;
    if (!animation.rest_transforms.empty()) {
        rest = writeVector<float>(builder, animation.rest_transforms);
        inverse_bind = writeVector<float>(builder, animation.inverse_bind);
    }
    Offset<flatbuffers::Vector<Offset<flatbuffers::String>>> input_names;
    Offset<flatbuffers::Vector<float>> inputs, origin;
    if (!animation.input_names.empty()) {
        input_names = builder.CreateVectorOfStrings(animation.input_names);
        inputs = writeVector<float>(builder, animation.inputs);
    }
    Offset<flatbuffers::Vector<std::uint16_t>> positions;
    const PlaybackSection& playback = animation.playback;
    if (!playback.positions.empty()) {
        positions = writeVector<std::uint16_t>(builder, playback.positions);
        origin = builder.CreateVector(&playback.origin.x, 3);
    }
    return fbs::CreateAnimation(builder, names, parents, clip_vector, times, bones, std::uint32_t(animation.pose_size),
                                pose, rest, inverse_bind, input_names, inputs, positions, origin, playback.step,
                                playback.error);
}

std::vector<ClipView> clipsOf(const FrameList& frames, std::span<const std::string> held_out) {
    std::vector<ClipView> clips;
    for (std::size_t f = 0; f < frames.frameCount(); ++f) {
        const std::string& name = frames.clip_names[frames.clip[f]];
        if (clips.empty() || clips.back().name != name)
            clips.push_back(
                {name, std::uint32_t(f), 0, std::find(held_out.begin(), held_out.end(), name) != held_out.end()});
        ++clips.back().frame_count;
    }
    return clips;
}

std::span<std::byte> finishAsset(FlatBufferBuilder& builder, const AssetSections& sections, int sh_order,
                                 const std::string& provenance) {
    const auto convention = builder.CreateString(kShConvention.data(), kShConvention.size());
    const auto made_by = builder.CreateString(provenance);
    const auto materials = builder.CreateVector(sections.materials);
    const auto lights = builder.CreateVector(sections.lights);
    constexpr std::uint64_t kPlaceholder = 1;  // not the default, because a field that holds its default is not stored
    Offset<flatbuffers::Vector<std::uint16_t>> slot_material;
    if (!sections.slot_material.empty()) slot_material = writeVector<std::uint16_t>(builder, sections.slot_material);
    Offset<flatbuffers::Vector<float>> spheres;
    Offset<flatbuffers::Vector<std::uint16_t>> joints;
    if (const SphereBlockers& blockers = sections.blockers; !blockers.spheres.empty()) {
        spheres = writeVector<float>(builder, blockers.spheres);
        joints = builder.CreateVector(blockers.joints);
    }
    const auto asset =
        fbs::CreateAsset(builder, kAssetFormat.version, convention, std::uint8_t(sh_order), made_by, kPlaceholder,
                         sections.mesh, sections.animation, sections.model, sections.transfer, sections.truth,
                         materials, slot_material, lights, spheres, joints, sections.surface);
    fbs::FinishAssetBuffer(builder, asset);
    const std::span<std::byte> bytes(reinterpret_cast<std::byte*>(builder.GetBufferPointer()), builder.GetSize());
    [[maybe_unused]] const bool sealed = sealAsset(bytes);
    assert(sealed);
    return bytes;
}

}  // namespace penumbra
