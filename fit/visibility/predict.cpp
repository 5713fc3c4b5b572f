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
#include "sh/indirect_coefficients.h"
#include "sh/sh_rotation.h"

namespace penumbra {

namespace {

// Writes the numbers of a cluster's vertices, `n` each: mean plus scores times basis.
void addComponents(const ClusterModel& cluster, const std::vector<float>& scores, std::size_t n,
                   std::span<float> coefficients) {
    const std::vector<float> sum = sumOfComponents(cluster, scores);
    for (std::size_t i = 0; i < cluster.vertices.size(); ++i)
        std::copy_n(sum.begin() + std::ptrdiff_t(i * n), n,
                    coefficients.begin() + std::ptrdiff_t(cluster.vertices[i] * n));
}

// Turns the numbers of a vertex into transfer, [3, kIndirectCoefficients] in the local frame and then in the model's.
void toTransfer(const ColorAxes& axes, std::span<const float> coefficients, const Mat3& frame, std::span<float> out) {
    std::array<float, kIndirectCoefficients> local;
    for (std::size_t channel = 0; channel < 3; ++channel) {
        for (std::size_t i = 0; i < local.size(); ++i)
            local[i] = indirectCoefficient(axes, coefficients, i)[int(channel)];
        apply(makeShRotation(kIndirectOrder, frame), std::span<const float>(local),
              out.subspan(channel * kIndirectCoefficients, kIndirectCoefficients));
    }
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

std::vector<int> jointsOfClusters(const Model& model) {
    std::vector<int> joints;
    for (const ClusterModel& cluster : model.clusters) joints.push_back(cluster.joint);
    return joints;
}

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
    prediction.coefficients.resize(model_.mesh.vertexCount() * ambient_.size());
    std::vector<double> raw(recipe_.count());
    // Each cluster predicts its own vertices and tells how far the pose is out of its range.
    for (const ClusterModel& cluster : model_.clusters) {
        rawFeatures(recipe_, cluster.joint, bones, rotations, pose, raw);
        const ScoredPose scored = scoreCluster(model_.kind, recipe_, cluster, raw);
        prediction.out_of_range += scored.out_of_range * double(cluster.vertices.size());
        addComponents(cluster, scored.scores, ambient_.size(), prediction.coefficients);
    }
    if (far_) {
        assert(!model_.deforming || positions.size() == model_.mesh.frontVertexCount());
        compose(model_.deforming ? deformed(vertices_, positions, normals) : skinned(vertices_, bones), bones,
                rotations, pose, prediction.coefficients);
    }
    // What the clusters predict is moved to where E lies in [0, 1], local numbers of a composed model only as a whole.
    const std::size_t n = ambient_.size();
    const float norm2 = std::inner_product(ambient_.begin(), ambient_.end(), ambient_.begin(), 0.0f);
    for (std::size_t at = 0; at < prediction.coefficients.size(); at += n)
        clampAmbient(ambient_, norm2, std::span(prediction.coefficients).subspan(at, n));
    prediction.out_of_range = std::sqrt(prediction.out_of_range / double(model_.mesh.vertexCount()));
    return prediction;
}

// Turns the local numbers of all vertices into whole ones: the far parts' visibility is multiplied in and the residual
// is added.
void Predictor::compose(const PosedVertices& vertices, std::span<const Affine> bones, std::span<const Mat3> rotations,
                        std::span<const float> pose, std::span<float> coefficients) const {
    // 1. Local x far.
    std::vector<PosedPart> posed(far_->partCount());
    poseParts(far_->fields(), bones, posed);
    std::vector<float> far(model_.mesh.vertexCount() * kFarCoefficients);
    farFactors(*far_, vertices_, {vertices, bones, posed}, far);
    multiplyByFar(*far_, far, coefficients);
    // 2. The residual.
    const std::size_t n = ambient_.size();
    std::vector<double> raw(recipe_.count());
    for (const ClusterModel& cluster : model_.composition->residual) {
        rawFeatures(recipe_, cluster.joint, bones, rotations, pose, raw);
        const std::vector<float> sum =
            sumOfComponents(cluster, scoreCluster(model_.kind, recipe_, cluster, raw).scores);
        for (std::size_t i = 0; i < sum.size(); ++i) coefficients[cluster.vertices[i / n] * n + i % n] += sum[i];
    }
}

std::vector<float> toModelFrame(const Convention& convention, const LocalFrames& frames, std::span<const Affine> bones,
                                const std::vector<Vec3>& normals, std::span<const float> coefficients, int threads) {
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
            const std::span<float> full = std::span(local).first(count);
            // 2. Rotate every vertex' coefficients from its local frame into the model frame.
            fullCoefficients(convention, coefficients.subspan(v * n, n), full);
            for (std::size_t i = 0; i < count; ++i) full[i] -= float(below[i]);
            const int joint = frames.joint_of_cluster[(*frames.cluster_of_vertex)[v]];
            const Vec3 tangent = carriedTangent(normals[v], rotations[std::size_t(joint)], (*frames.rest_tangents)[v]);
            apply(makeShRotation(convention.order, localFrame(normals[v], tangent)), full,
                  std::span(out).subspan(v * count, count));
        }
    });
    return out;
}

std::vector<float> toModelFrame(const Model& model, std::span<const Affine> bones, const std::vector<Vec3>& normals,
                                std::span<const float> coefficients, int threads) {
    const std::vector<int> joints = jointsOfClusters(model);
    return toModelFrame(model.convention, {&model.rest_tangents, &model.cluster_of_vertex, joints}, bones, normals,
                        coefficients, threads);
}

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

std::vector<float> predictIndirect(const Model& model, std::span<const Affine> bones, std::span<const float> pose,
                                   std::span<const Vec3> normals, int threads) {
    const IndirectModel& indirect = *model.indirect;
    const FeatureRecipe recipe = recipeOf(model);
    const std::vector<Mat3> rotations = rotationsOf(bones);
    constexpr std::size_t kStride = 3 * kIndirectCoefficients;
    std::vector<float> out(normals.size() * kStride);
    parallelFor(indirect.clusters.size(), threads, [&](std::size_t c) {
        const ClusterModel& cluster = indirect.clusters[c];
        std::vector<double> raw(recipe.count());
        rawFeatures(recipe, cluster.joint, bones, rotations, pose, raw);
        const std::vector<float> coefficients =
            sumOfComponents(cluster, scoreCluster(model.kind, recipe, cluster, raw).scores);
        for (std::size_t i = 0; i < cluster.vertices.size(); ++i) {
            const std::size_t v = cluster.vertices[i];
            const Vec3 tangent =
                carriedTangent(normals[v], rotations[std::size_t(cluster.joint)], model.rest_tangents[v]);
            toTransfer(indirect.axes, std::span(coefficients).subspan(i * kIndirectSize, kIndirectSize),
                       localFrame(normals[v], tangent), std::span(out).subspan(v * kStride, kStride));
        }
    });
    return out;
}

void writePredictions(const VisibilityReader& poses, int order, const char* quantity, const PredictionOutput& to,
                      const std::function<std::vector<float>(const VisibilityFrame& pose)>& predict) {
    VisibilityHeader header = poses.header();
    header.order = order;
    header.quantity = quantity;
    // A prediction has the whole visibility alone.
    header.local.reset();
    header.bounces = 0;
    header.colors = {};
    header.provenance = to.provenance;
    VisibilityWriter writer(to.file, header, Precision::kFloat32);
    for (std::size_t f = 0; f < header.frames.frameCount(); ++f) {
        throwIfInterrupted();
        VisibilityFrame frame = poses.readPose(f);
        frame.coefficients = predict(frame);
        writer.writeFrame(frame);
        if (to.progress) to.progress(double(f + 1));
    }
    writer.finish();
}

const char* predictedQuantity(const Convention& convention) {
    return convention.below == BelowHorizon::kMirrored ? "mirrored_visibility" : kHemisphereVisibility;
}

std::vector<double> predictFile(const Model& model, const VisibilityReader& poses, const PredictionOutput& to) {
    const Predictor predictor(model);
    const std::size_t fronts = model.mesh.frontVertexCount();
    std::vector<double> out_of_range;
    writePredictions(poses, model.convention.order, predictedQuantity(model.convention), to,
                     [&](const VisibilityFrame& frame) {
                         const SeenPose seen = seenPose(model, frame);
                         const Prediction prediction =
                             predictor.predict(seen.bones, seen.pose, std::span(frame.positions).first(fronts),
                                               std::span(frame.normals).first(fronts));
                         out_of_range.push_back(prediction.out_of_range);
                         return toModelFrame(model, seen.bones, frame.normals, prediction.coefficients, to.threads);
                     });
    return out_of_range;
}

}  // namespace penumbra
