// Asks the run-time model of an asset, as an engine does, for poses of a rig's clips.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "formats/common/errors.h"
#include "formats/common/joined.h"
#include "formats/common/parallel_for.h"
#include "pack/export/occlusion_source.h"
#include "pack/export/turn_to_rest.h"
#include "runtime/evaluate/deformation.h"
#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading.h"
#include "sh/indirect_coefficients.h"

namespace penumbra {

namespace {

// Where the asset's joints and morph targets are in a rig.
struct RigMatch {
    std::vector<std::size_t> joints;   // [joints of the asset that stand for no inputs]
    std::vector<std::size_t> weights;  // [morph targets of the asset]; kNoWeightOfRig: the rig has none of the name
};
constexpr std::size_t kNoWeightOfRig = std::size_t(-1);

RigMatch matchRig(const AssetView& asset, const Rig& rig) {
    const AnimationView& animation = asset.animation;
    if (asset.model.deforming || asset.transfer)
        throw Unsupported(asset.name + ": clips of a rig need a model of a skinned character");
    const std::size_t morphs = asset.mesh.morphs.count(), inputs = animation.input_names.size();
    if (inputs > morphs)
        throw Unsupported(asset.name + ": reads the number '" + std::string(animation.input_names[0]) +
                          "', which clips of a rig do not have");
    RigMatch match;
    const std::vector<std::string>& known = rig.skin.joint_names;
    for (std::size_t j = 0; j < animation.jointCount() - asset.model.input_joints.size(); ++j) {
        const auto found = std::find(known.begin(), known.end(), animation.joint_names[j]);
        if (found == known.end())
            throw InvalidInput("has no joint '" + std::string(animation.joint_names[j]) + "' of the model");
        match.joints.push_back(std::size_t(found - known.begin()));
    }
    const std::vector<std::string>& targets = rig.mesh.morphs.names;
    for (std::size_t m = 0; m < morphs; ++m) {
        const auto found = std::find(targets.begin(), targets.end(), animation.input_names[m]);
        match.weights.push_back(found == targets.end() ? kNoWeightOfRig : std::size_t(found - targets.begin()));
    }
    return match;
}

// Returns the rig's clip of a name, or -1, which is the rest pose, where it has no clips.
int clipOfRig(const Rig& rig, const std::string& name) {
    const auto found = std::find_if(rig.clips.begin(), rig.clips.end(), [&](const Clip& c) { return c.name == name; });
    return found == rig.clips.end() ? -1 : int(found - rig.clips.begin());
}

class ModelOcclusion : public OcclusionSource {
public:
    ModelOcclusion(const AssetView& asset, const Rig* rig, const std::vector<std::string>& clips, double rate);
    bool hasBounces() const override { return at_rest_.hasIndirect() && !at_rest_.hasFollowers(); }
    OcclusionFrame read(std::size_t frame, FrameParts parts, int threads) const override;

private:
    const AssetView& asset_;
    const Rig* rig_;
    RigMatch match_;
    std::vector<std::size_t> asset_frames_;  // [F] without a rig
    Evaluator at_rest_;

    void takeMesh();
    void takeOwnFrames(const std::vector<std::string>& clips);
    void pose(std::size_t frame, Evaluator& evaluator) const;
    Vec3 visibleDirection(std::span<const float> coefficients, float ambient, const Mat3& to_local) const;
};

ModelOcclusion::ModelOcclusion(const AssetView& asset, const Rig* rig, const std::vector<std::string>& clips,
                               double rate)
    : asset_(asset), rig_(rig), at_rest_(asset) {
    takeMesh();
    if (rig) {
        match_ = matchRig(asset, *rig);
        frames_ = sampleFrames(*rig, clips, rate);
    } else {
        takeOwnFrames(clips);
    }
}

void ModelOcclusion::takeMesh() {
    const MeshView& mesh = asset_.mesh;
    mesh_.rest_positions.assign(mesh.positions.begin(), mesh.positions.end());
    mesh_.source_vertex.assign(mesh.source_vertex.begin(), mesh.source_vertex.end());
    for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3)
        mesh_.triangles.push_back({mesh.triangles[t], mesh.triangles[t + 1], mesh.triangles[t + 2]});
    for (const std::string_view slot : mesh.slots) mesh_.slots.emplace_back(slot);
    mesh_.slot_of_vertex.assign(mesh.slot_of_vertex.begin(), mesh.slot_of_vertex.end());
    rest_normals_.assign(mesh.normals.begin(), mesh.normals.end());
}

void ModelOcclusion::takeOwnFrames(const std::vector<std::string>& clips) {
    const AnimationView& animation = asset_.animation;
    if (asset_.model.features == FeatureKind::kJointAngles && animation.pose.empty() && animation.pose_size > 0)
        throw Unsupported(asset_.name + ": has no rotations of its frames; give the rig");
    if (asset_.model.deforming && animation.playback.positions.empty())
        throw Unsupported(asset_.name + ": has no positions of its frames");
    for (const ClipView& clip : animation.clips) frames_.clip_names.emplace_back(clip.name);
    for (const std::string& clip : clips)
        if (std::find(frames_.clip_names.begin(), frames_.clip_names.end(), clip) == frames_.clip_names.end())
            throw BadOption("clips", "no clip \"" + clip + "\"; there are: " + joined(frames_.clip_names));
    for (std::size_t c = 0; c < animation.clips.size(); ++c) {
        const ClipView& clip = animation.clips[c];
        if (!clips.empty() && std::find(clips.begin(), clips.end(), clip.name) == clips.end()) continue;
        for (std::size_t f = clip.first_frame; f < std::size_t(clip.first_frame) + clip.frame_count; ++f) {
            asset_frames_.push_back(f);
            frames_.clip.push_back(std::uint16_t(c));
            frames_.time.push_back(animation.times[f]);
        }
    }
    if (asset_frames_.empty()) throw InvalidInput(asset_.name + ": has no frames; give the rig");
}

void ModelOcclusion::pose(std::size_t frame, Evaluator& evaluator) const {
    if (!rig_) return evaluator.setFrame(asset_frames_[frame]);
    const int clip = clipOfRig(*rig_, frames_.clip_names[frames_.clip[frame]]);
    const RigPose posed = evaluatePose(*rig_, clip, frames_.time[frame]);
    std::vector<float> inputs, pose_values;
    for (std::size_t m = 0; m < match_.weights.size(); ++m)
        inputs.push_back(match_.weights[m] == kNoWeightOfRig ? asset_.mesh.morphs.rest_weights[m]
                                                             : posed.weights[match_.weights[m]]);
    std::vector<Affine> bones;
    for (const std::size_t joint : match_.joints) {
        bones.push_back(posed.bones[joint]);
        pose_values.insert(pose_values.end(), posed.pose.begin() + std::ptrdiff_t(3 * joint),
                           posed.pose.begin() + std::ptrdiff_t(3 * joint + 3));
    }
    for (const InputJointView& input : asset_.model.input_joints) bones.push_back(inputBone(asset_, input, inputs));
    pose_values.insert(pose_values.end(), inputs.begin(), inputs.end());
    evaluator.setPose(bones, pose_values);
}

// Returns the integral of V s over the hemisphere, in the model frame. Band 1 of the numbers has its part in the
// tangent plane, where what a convention puts below the horizon cancels or, mirrored, counts twice. The part along the
// normal is the ambient visibility times pi. An asset of transfer has it with the weight of the cosine.
Vec3 ModelOcclusion::visibleDirection(std::span<const float> coefficients, float ambient, const Mat3& to_local) const {
    const float band1 = float(std::sqrt(3 / (4 * std::numbers::pi)));
    if (asset_.transfer)
        return coefficients.size() < 4 ? Vec3{} : Vec3{-coefficients[3], -coefficients[1], coefficients[2]} / band1;
    const Convention& convention = asset_.model.convention;
    std::array<float, coefficientCount(kMaxOrder)> buffer{};
    fullCoefficients(convention, coefficients,
                     std::span(buffer).first(std::size_t(coefficientCount(convention.order))));
    const float share = convention.below == BelowHorizon::kMirrored ? 0.5f : 1.0f;
    const Vec3 local{-buffer[3] * share / band1, -buffer[1] * share / band1, ambient * std::numbers::pi_v<float>};
    return transposed(to_local) * local;
}

OcclusionFrame ModelOcclusion::read(std::size_t frame, FrameParts parts, int threads) const {
    Evaluator evaluator = at_rest_;
    pose(frame, evaluator);
    const std::size_t vertices = evaluator.vertexCount(), stride = std::size_t(asset_.model.stride);
    std::vector<float> coefficients(vertices * stride), indirect;
    std::vector<Vec3> positions(vertices), normals(vertices), tangents(vertices);
    const bool all = parts == FrameParts::kAll;
    if (all && hasBounces()) indirect.resize(vertices * kIndirectStride);
    parallelFor(evaluator.clusterCount(), threads, [&](std::size_t c) {
        evaluator.evaluateCluster(c, coefficients);
        if (!indirect.empty()) evaluator.evaluateIndirect(c, indirect);
    });
    if (all || evaluator.hasFollowers()) evaluator.skin(0, vertices, positions, normals, tangents);
    if (evaluator.hasFollowers())
        evaluator.follow(evaluator.firstFollower(), vertices, {normals, tangents}, coefficients);
    OcclusionFrame out;
    out.ambient.resize(vertices);
    ambient(asset_, coefficients, out.ambient);
    for (float& e : out.ambient) e = std::clamp(e, 0.0f, 1.0f);
    if (!all) return out;
    const std::size_t k = std::size_t(asset_.mesh.influences);
    const std::size_t size =
        asset_.transfer ? asset_.transfer->coefficients() : std::size_t(asset_.model.convention.size());
    for (std::size_t v = 0; v < vertices; ++v) {
        const Vec3 visible = visibleDirection(std::span(coefficients).subspan(v * stride, size), out.ambient[v],
                                              toLocalFrame(normals[v], tangents[v]));
        const PointMotion motion{asset_.mesh.skin_joints.subspan(v * k, k), asset_.mesh.skin_weights.subspan(v * k, k),
                                 asset_.model.deforming ? std::span<const Affine>() : evaluator.bones(),
                                 asset_.mesh.normals[v], normals[v]};
        out.bent.push_back(directionAtRest(motion, visible));
    }
    constexpr double kAmbientOfBand0 = 2 * std::numbers::inv_sqrtpi;  // sqrt(4 pi) / pi
    for (std::size_t v = 0; v < vertices && !indirect.empty(); ++v) {
        const float e = out.ambient[v];
        const std::span<const float> row = std::span(indirect).subspan(v * kIndirectStride, kIndirectStride);
        out.bounced.push_back(Vec3{e, e, e} +
                              float(kAmbientOfBand0) * indirectCoefficient(asset_.model.indirect->axes, row, 0));
    }
    return out;
}

}  // namespace

std::unique_ptr<OcclusionSource> modelOcclusion(const AssetView& asset, const Rig* rig,
                                                const std::vector<std::string>& clips, double rate) {
    if (!asset.hasCharacter())
        throw Unsupported(asset.name + ": has no model; an export of baked frames takes the .vis.h5");
    return std::make_unique<ModelOcclusion>(asset, rig, clips, rate);
}

}  // namespace penumbra
