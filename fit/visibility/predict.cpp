#include "fit/visibility/predict.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>

#include "fit/clusters/deforming_pose.h"
#include "fit/clusters/tangent_frames.h"
#include "fit/models/regressor.h"
#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "sh/sh_rotation.h"

namespace penumbra {

namespace {

std::vector<Mat3> rotationsOf(std::span<const Affine> bones) {
    std::vector<Mat3> rotations;
    for (const Affine& bone : bones) rotations.push_back(nearestRotation(bone.linear()));
    return rotations;
}

// Returns mean plus scores times basis.
std::vector<float> combined(const ClusterModel& cluster, const std::vector<float>& scores) {
    std::vector<float> sum = cluster.mean;
    for (std::size_t k = 0; k < scores.size(); ++k)
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += scores[k] * cluster.basis[k * sum.size() + i];
    return sum;
}

// Writes the numbers of a cluster's vertices: mean plus scores times basis, moved to where E lies in [0, 1].
void addComponents(const ClusterModel& cluster, const std::vector<float>& scores, std::span<const float> ambient,
                   std::span<float> numbers) {
    const std::size_t n = ambient.size();
    const float norm2 = std::inner_product(ambient.begin(), ambient.end(), ambient.begin(), 0.0f);
    std::vector<float> sum = combined(cluster, scores);
    for (std::size_t i = 0; i < cluster.vertices.size(); ++i) {
        const std::span<float> vertex = std::span(sum).subspan(i * n, n);
        clampAmbient(ambient, norm2, vertex);
        std::copy(vertex.begin(), vertex.end(), numbers.begin() + std::ptrdiff_t(cluster.vertices[i] * n));
    }
}

std::vector<int> jointsOfClusters(const Model& model) {
    std::vector<int> joints;
    for (const ClusterModel& cluster : model.clusters) joints.push_back(cluster.joint);
    return joints;
}

// Throws InvalidInput when the file shows another character than the model's.
void checkCharacter(const Model& model, const VisibilityHeader& header, const std::string& file) {
    const auto refuse = [&](const char* field) {
        throw InvalidInput(file + ": " + field + " of the poses is not that of the model: another character");
    };
    if (header.skin.has_value() == model.deforming) refuse("/skin");
    if (header.mesh.two_sided != model.mesh.two_sided) refuse("attribute two_sided");
    if (header.mesh.vertexCount() != model.mesh.vertexCount()) refuse("/mesh/rest_positions");
    if (header.mesh.triangles != model.mesh.triangles) refuse("/mesh/triangles");
    if (header.input_names != model.input_names) refuse("/inputs/names");
    if (model.deforming) {
        if (!model.pose_mean.empty() && header.edges.size() != model.pose_mean.size()) refuse("/mesh/edges");
        return;
    }
    const auto own = model.skin.joint_names.begin() + long(model.skin.jointCount() - model.input_joints.size());
    if (header.skin->joint_names != std::vector<std::string>(model.skin.joint_names.begin(), own))
        refuse("/skin/joint_names");
    if (header.pose_size != model.pose_size) refuse("/frames/pose");
}

// The bones and the pose that the model sees of a frame, for a file that passed checkCharacter().
struct SeenPose {
    std::vector<Affine> bones;
    std::vector<float> pose;
};

SeenPose seenPose(const Model& model, const VisibilityFrame& frame) {
    const std::span<const float> inputs = std::span(frame.pose).last(model.input_names.size());
    const std::size_t own = model.skin.jointCount() - model.input_joints.size();
    SeenPose seen{frame.bones, frame.pose};
    if (model.deforming) {
        seen.bones =
            partBones(model.mesh, model.skin, own, std::span(frame.positions).first(model.mesh.frontVertexCount()));
        seen.pose =
            reducedAngles(model.pose_mean, model.pose_basis, std::span(frame.pose).first(model.pose_mean.size()));
        seen.pose.insert(seen.pose.end(), inputs.begin(), inputs.end());
    }
    appendInputBones(model.input_joints, model.joint_centers, inputs, seen.bones);
    return seen;
}

}  // namespace

Predictor::Predictor(const Model& model)
    : model_(model), recipe_(recipeOf(model)), ambient_(std::size_t(model.convention.size())) {
    ambientWeights(model.convention, ambient_);
    if (!model.composition) return;
    far_.reset(new FarTables(makeFarTables(*model.composition, model.convention)));
    std::vector<std::uint32_t> all(model.mesh.vertexCount());
    std::iota(all.begin(), all.end(), 0u);
    vertices_ = vertexSet(model, all, jointsOfClusters(model));
}

Prediction Predictor::predict(std::span<const Affine> bones, std::span<const float> pose,
                              std::span<const Vec3> positions, std::span<const Vec3> normals) const {
    const std::vector<Mat3> rotations = rotationsOf(bones);
    Prediction prediction;
    prediction.numbers.resize(model_.mesh.vertexCount() * ambient_.size());
    std::vector<double> raw(recipe_.count());
    // Each cluster predicts its own vertices and tells how far the pose is out of its range.
    for (const ClusterModel& cluster : model_.clusters) {
        rawFeatures(recipe_, cluster.joint, bones, rotations, pose, raw);
        const ScoredPose scored = scoreCluster(model_.kind, recipe_, cluster, raw);
        prediction.out_of_range += scored.out_of_range * double(cluster.vertices.size());
        addComponents(cluster, scored.scores, ambient_, prediction.numbers);
    }
    if (far_) {
        assert(!model_.deforming || positions.size() == model_.mesh.frontVertexCount());
        compose(model_.deforming ? deformed(vertices_, positions, normals) : skinned(vertices_, bones), bones,
                rotations, pose, prediction.numbers);
    }
    prediction.out_of_range = std::sqrt(prediction.out_of_range / double(model_.mesh.vertexCount()));
    return prediction;
}

// Turns the local numbers of all vertices into whole ones: the far parts' visibility is multiplied in and the residual
// is added.
void Predictor::compose(const PosedVertices& vertices, std::span<const Affine> bones, std::span<const Mat3> rotations,
                        std::span<const float> pose, std::span<float> numbers) const {
    // 1. Local x far.
    std::vector<PosedPart> posed(far_->partCount());
    poseParts(far_->fields(), bones, posed);
    std::vector<float> far(model_.mesh.vertexCount() * kFarNumbers);
    farFactors(*far_, vertices_, vertices, bones, posed, far);
    multiplyByFar(*far_, far, numbers);
    // 2. The residual.
    const std::size_t n = ambient_.size();
    std::vector<double> raw(recipe_.count());
    for (const ClusterModel& cluster : model_.composition->residual) {
        rawFeatures(recipe_, cluster.joint, bones, rotations, pose, raw);
        const std::vector<float> sum = combined(cluster, scoreCluster(model_.kind, recipe_, cluster, raw).scores);
        for (std::size_t i = 0; i < sum.size(); ++i) numbers[cluster.vertices[i / n] * n + i % n] += sum[i];
    }
    const float norm2 = std::inner_product(ambient_.begin(), ambient_.end(), ambient_.begin(), 0.0f);
    for (std::size_t at = 0; at < numbers.size(); at += n) clampAmbient(ambient_, norm2, numbers.subspan(at, n));
}

std::vector<float> toModelFrame(const Convention& convention, const LocalFrames& frames, std::span<const Affine> bones,
                                const std::vector<Vec3>& normals, std::span<const float> numbers, int threads) {
    const auto n = std::size_t(convention.size()), count = std::size_t(coefficientCount(convention.order));
    // 1. Numbers include what lies below the horizon in convention A; moments do not.
    std::array<double, coefficientCount(kMaxOrder)> below{};
    if (convention.below == BelowHorizon::kOpen)
        belowHorizonCoefficients(convention.order, std::span(below).first(count));
    const std::vector<Mat3> rotations = rotationsOf(bones);
    std::vector<float> out(normals.size() * count);
    constexpr std::size_t kBlock = 1024;
    parallelFor((normals.size() + kBlock - 1) / kBlock, threads, [&](std::size_t block) {
        std::array<float, coefficientCount(kMaxOrder)> local;
        for (std::size_t v = block * kBlock; v < std::min((block + 1) * kBlock, normals.size()); ++v) {
            const std::span<float> coefficients = std::span(local).first(count);
            // 2. Rotate every vertex' coefficients from its local frame into the model frame.
            toCoefficients(convention, numbers.subspan(v * n, n), coefficients);
            for (std::size_t i = 0; i < count; ++i) coefficients[i] -= float(below[i]);
            const int joint = frames.joint_of_cluster[(*frames.cluster_of_vertex)[v]];
            const Vec3 tangent = carriedTangent(normals[v], rotations[std::size_t(joint)], (*frames.rest_tangents)[v]);
            apply(makeShRotation(convention.order, localFrame(normals[v], tangent)), coefficients,
                  std::span(out).subspan(v * count, count));
        }
    });
    return out;
}

std::vector<float> toModelFrame(const Model& model, std::span<const Affine> bones, const std::vector<Vec3>& normals,
                                std::span<const float> numbers, int threads) {
    const std::vector<int> joints = jointsOfClusters(model);
    return toModelFrame(model.convention, {&model.rest_tangents, &model.cluster_of_vertex, joints}, bones, normals,
                        numbers, threads);
}

VisibilityHeader predictionHeader(const Convention& convention, const VisibilityHeader& poses,
                                  const Provenance& provenance) {
    VisibilityHeader header = poses;
    header.order = convention.order;
    header.quantity = convention.below == BelowHorizon::kMirrored ? "mirrored_visibility" : "hemisphere_visibility";
    // a prediction has the whole visibility alone
    header.local.reset();
    header.bounces = 0;
    header.colors = {};
    header.provenance = provenance;
    return header;
}

PredictReport predictFile(const Model& model, const VisibilityReader& poses, const PredictFiles& files, int threads,
                          const std::function<void(double)>& progress) {
    checkCharacter(model, poses.header(), files.poses);
    VisibilityWriter writer(files.output, predictionHeader(model.convention, poses.header(), files.provenance),
                            Precision::kFloat32);
    const Predictor predictor(model);
    PredictReport report;
    report.frames = poses.header().frames.frameCount();
    for (std::size_t f = 0; f < report.frames; ++f) {
        throwIfInterrupted();
        VisibilityFrame frame = poses.readPose(f);
        const SeenPose seen = seenPose(model, frame);
        const Prediction prediction =
            predictor.predict(seen.bones, seen.pose, std::span(frame.positions).first(model.mesh.frontVertexCount()),
                              std::span(frame.normals).first(model.mesh.frontVertexCount()));
        frame.coefficients = toModelFrame(model, seen.bones, frame.normals, prediction.numbers, threads);
        writer.writeFrame(frame);
        report.out_of_range.push_back(prediction.out_of_range);
        if (progress) progress(double(f + 1));
    }
    writer.finish();
    return report;
}

}  // namespace penumbra
