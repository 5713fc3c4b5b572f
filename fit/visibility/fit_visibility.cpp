// Fits a model of the pose to a whole bake.
//
// Problem: predict the visibility of every vertex, some 15 numbers each, from a pose that nobody baked.
//
// Naive: train one regression from the whole pose to all numbers of all vertices. A vertex then pays for joints that it
// cannot see, and the numbers vary as the surface turns although nothing hides more or less of the sky.
//
// Here: the numbers are rotated into a local frame at each vertex, where turning alone changes nothing. Vertices that
// move alike form clusters. In each cluster a PCA over training frames reduces the numbers to a few scores, and one
// model predicts these scores from what the cluster sees of the pose (fit_cluster.cpp). Numbers do not all fit in
// memory, so clusters are read and fitted in batches; the size of a batch never changes the result.
//
// See docs/formulas.md, sections 2, 4 and 5.

#include "fit/visibility/fit_visibility.h"

#include <algorithm>
#include <cmath>

#include "fit/clusters/tangent_frames.h"
#include "fit/clusters/vertex_clusters.h"
#include "fit/numerics/cross_validation.h"
#include "fit/visibility/choose_near.h"
#include "fit/visibility/compose_fields.h"
#include "fit/visibility/fit_batches.h"
#include "formats/common/errors.h"
#include "formats/common/part_table.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

// Checks the options that only suit a skeleton or only suit a deforming mesh.
void checkKind(const VisibilityHeader& header, const std::string& file, const FitOptions& options) {
    if (header.skin) {
        if (options.features == FeatureKind::kDihedrals)
            throw BadOption("features",
                            "dihedral-angles: " + file + " has a skeleton; take joint-angles or relative-bones");
        if (options.parts > 0) throw BadOption("parts", file + " has a skeleton, whose joints are its parts");
        return;
    }
    if (options.features == FeatureKind::kJointAngles)
        throw BadOption("features", "joint-angles: " + file +
                                        " has no skeleton; take relative-bones (of its near-rigid parts) or "
                                        "dihedral-angles");
    if (options.features == FeatureKind::kDihedrals && header.edges.empty() && header.input_names.empty())
        throw InvalidInput(file + ": /mesh/edges: empty, but dihedral-angles are read from it");
    if (std::size_t(options.parts) > header.mesh.frontVertexCount())
        throw BadOption("parts", std::to_string(options.parts) + " is more than the " +
                                     std::to_string(header.mesh.frontVertexCount()) + " vertices");
}

// Checks that a composed model can be made: there are local moments, and the fields are those of this character and of
// what it was baked with.
void checkComposed(const VisibilityHeader& header, const std::string& file, const FitOptions& options) {
    if (options.convention.below != BelowHorizon::kMirrored)
        throw BadOption("convention", "a composed model takes convention D, not " + options.convention.name());
    if (header.distance)
        throw InvalidInput(file + ": was baked for a distance, but fields hide at any distance: bake without one");
    if (!header.local)
        throw InvalidInput(
            file + ": /visibility/local: missing, but composed models read it (penumbra-bake can bake local moments)");
    if (header.local->order < options.convention.order)
        throw BadOption("convention", options.convention.name() + ": " + file + " has local moments of order " +
                                          std::to_string(header.local->order));
    checkFields(header, file, options.fields);
}

// Weights of morph targets and other inputs are joints of their own (input_names).
bool hasOneJoint(const VisibilityHeader& header) {
    return header.skin && header.skin->jointCount() + header.input_names.size() < 2;
}

void checkInput(const VisibilityHeader& header, const std::string& file, const FitOptions& options) {
    if (header.quantity != "hemisphere_visibility")
        throw InvalidInput(file + ": quantity '" + header.quantity + "': a fit needs baked hemisphere_visibility");
    checkKind(header, file, options);
    if (!options.fields.empty()) checkComposed(header, file, options);
    const int needed = options.convention.order + options.form->more_bands;
    if (needed > header.order)
        throw BadOption("convention", options.convention.name() + " needs moments of order " + std::to_string(needed) +
                                          "; the file has order " + std::to_string(header.order));
    if (std::size_t(options.clusters) > header.mesh.vertexCount())
        throw BadOption("clusters", std::to_string(options.clusters) + " is more than the " +
                                        std::to_string(header.mesh.vertexCount()) + " vertices");
    if (options.features == FeatureKind::kJointAngles && header.pose_size == 0)
        throw InvalidInput(file + ": /frames/pose: empty, but joint-angles are read from it");
    if (options.features == FeatureKind::kRelativeBones && hasOneJoint(header))
        throw InvalidInput(file + ": /skin/joint_names: relative-bones need at least two joints; take joint-angles");
}

// Copies the poses. The table may have angles, which other features do not read.
void copyPose(const PoseTable& poses, const FitOptions& options, Model& model) {
    const std::size_t inputs = model.input_names.size();
    if (!poses.deforming || options.features == FeatureKind::kDihedrals) {
        model.pose_size = int(poses.pose_size);
        model.pose = poses.pose;
        model.pose_mean = poses.pose_mean;
        model.pose_basis = poses.pose_basis;
        return;
    }
    model.pose_size = int(inputs);
    for (std::size_t f = 0; f < poses.frameCount(); ++f) {
        const std::span<const float> pose = poses.poseOf(f).last(inputs);
        model.pose.insert(model.pose.end(), pose.begin(), pose.end());
    }
}

void copyInput(const VisibilityHeader& header, const PoseTable& poses, const FitOptions& options, Model& model) {
    model.mesh = header.mesh;
    model.drawn = header.drawn;
    model.skin = poses.skin;
    if (model.drawn) {  // the joints of inputs come last
        model.drawn->skin.joint_names = model.skin.joint_names;
        model.drawn->skin.parents = model.skin.parents;
    }
    model.rest_normals = header.rest_normals;
    model.frames = header.frames;
    model.bones = poses.bones;
    model.deforming = poses.deforming;
    model.positions = poses.positions;
    model.input_names = header.input_names;
    model.input_joints = poses.input_joints;
    copyPose(poses, options, model);
    model.holdout_clips = options.holdout;
    model.convention = options.convention;
    model.kind = options.model;
    model.features = options.features;
    model.feature_scale = characterDiagonal(header.mesh);
    model.joint_centers = poses.joint_centers;
    model.joint_spreads = jointSpreads(header.mesh, poses.skin, model.joint_centers, model.feature_scale);
    model.input_variance = inputVariance(options);
    model.output_variance = options.output_variance;
}

template <class Fit>
FrameErrors sumOverClusters(const std::vector<Fit>& fits, std::size_t frames, FrameErrors Fit::*errors) {
    FrameErrors sum(frames);
    for (const Fit& fit : fits) sum.add(fit.*errors);
    return sum;
}

FitReport reportOf(const std::vector<ClusterFit>& fits, const FrameErrors& errors, const Split& split,
                   const Model& model) {
    FitReport report;
    report.train_frames = split.train.size();
    report.held_out_frames = split.held_out.size();
    report.train = figuresOf(errors, split.train, model.mesh.vertexCount());
    report.held_out = figuresOf(errors, split.held_out, model.mesh.vertexCount());
    double variance = 0, validated = 0, left_out = 0, floor = 0;
    for (std::size_t f : split.train) variance += errors.variance[f];
    for (const ClusterFit& fit : fits) {
        validated += fit.cross_validated;
        left_out += fit.leave_one_out + fit.left_by_pca;
        floor += fit.left_by_pca;
    }
    if (variance > 0) {
        report.cross_validated_error = std::sqrt(validated / variance);
        report.leave_one_out_error = std::sqrt(left_out / variance);
        report.output_floor = std::sqrt(floor / variance);
    }
    for (const Triangle& t : model.mesh.triangles)
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t a = t[i], b = t[(i + 1) % 3];
            if (model.cluster_of_vertex[a] != model.cluster_of_vertex[b]) continue;
            report.largest_tangent_angle =
                std::max(report.largest_tangent_angle, neighbourAngle(model.rest_normals[a], model.rest_tangents[a],
                                                                      model.rest_normals[b], model.rest_tangents[b]));
        }
    return report;
}

// A residual model is kept when cross-validation says that it leaves less than this share of what it is to predict.
constexpr double kWorthResidual = 0.97;

// Leaves the mean alone, and one component that never counts: a cluster has at least one.
void dropComponents(ClusterModel& cluster) {
    cluster.weights.assign(cluster.units(), 0.0f);
    cluster.basis.resize(cluster.mean.size());
    cluster.bias.assign(1, 0.0f);
}

// Puts the clusters into the model, without the residual where it does not pay, and reports the errors. The mean of the
// residual is judged apart from its components: what the cut bands leave is partly the same in all poses.
void finishComposed(std::vector<ComposedFit> fits, const Split& split, FitResult& result) {
    Model& model = result.model;
    double left = 0, validated = 0, trained = 0;
    for (const ComposedFit& fit : fits) {
        left += fit.left;
        validated += fit.residual.cross_validated;
        for (const std::size_t f : split.train) trained += fit.residual.errors.squared[f];
    }
    double as_it_is = 0, about_others = 0;
    for (const ComposedFit& fit : fits) as_it_is += fit.left_as_it_is, about_others += fit.left_about_others;
    const bool keep = validated < kWorthResidual * left;
    const bool keep_mean = keep || about_others < kWorthResidual * as_it_is;
    if (keep && trained < left)
        model.composition->residual_worth = std::clamp((left - validated) / (left - trained), 0.0, 1.0);
    const std::size_t frames = model.frames.frameCount(), vertices = model.mesh.vertexCount();
    FrameErrors ComposedFit::*const kept = keep        ? &ComposedFit::errors
                                           : keep_mean ? &ComposedFit::with_mean
                                                       : &ComposedFit::without_residual;
    const FrameErrors split_errors = sumOverClusters(fits, frames, &ComposedFit::split),
                      without = sumOverClusters(fits, frames, &ComposedFit::without_residual),
                      errors = sumOverClusters(fits, frames, kept);
    const std::size_t nears = model.composition->near_count;
    std::vector<ClusterFit> parts;
    for (ComposedFit& fit : fits) {
        // Both parts of a cluster state the errors of the whole prediction.
        for (ClusterFit* part : {&fit.local, &fit.residual}) setErrorRatios(fit.*kept, split.train, part->model);
        parts.push_back(std::move(fit.local));
    }
    const FrameErrors local = sumOverClusters(parts, frames, &ClusterFit::errors);
    model.clip_errors = errorsByClip(errors, model.frames, model.holdout_clips, vertices);
    result.report = reportOf(parts, local, split, model);
    result.report.train = figuresOf(errors, split.train, vertices);
    result.report.held_out = figuresOf(errors, split.held_out, vertices);
    result.report.composed = ComposedReport{figuresOf(local, split.train, vertices),
                                            figuresOf(local, split.held_out, vertices),
                                            figuresOf(without, split.train, vertices),
                                            figuresOf(without, split.held_out, vertices),
                                            figuresOf(split_errors, split.train, vertices),
                                            figuresOf(split_errors, split.held_out, vertices),
                                            left > 0 ? std::sqrt(validated / left) : 0,
                                            keep,
                                            nears > 0,
                                            {},
                                            keep_mean,
                                            {}};
    for (std::size_t c = 0; c < fits.size(); ++c) {
        for (std::size_t i = 0; i < fits[c].near_gains.size(); ++i)
            model.composition->near_gains[parts[c].model.vertices[i / nears] * nears + i % nears] =
                fits[c].near_gains[i];
        model.clusters.push_back(std::move(parts[c].model));
        if (!keep) dropComponents(fits[c].residual.model);
        if (keep_mean) model.composition->residual.push_back(std::move(fits[c].residual.model));
    }
}

}  // namespace

double inputVariance(const FitOptions& options) {
    if (options.input_variance != 0) return options.input_variance;
    if (options.features != FeatureKind::kRelativeBones) return 0.9;
    return options.model == ModelKind::kNeural ? 0.95 : 0.99;
}

FeatureKind defaultFeatures(const VisibilityHeader& header) {
    return hasOneJoint(header) ? FeatureKind::kJointAngles : FeatureKind::kRelativeBones;
}

void checkFit(const VisibilityHeader& header, const std::string& file, const FitOptions& options) {
    checkInput(header, file, options);
    splitFrames(header.frames, options.holdout, options.train_frames);
}

FitResult fitVisibility(const VisibilityReader& reader, const std::string& file, const FitOptions& options,
                        const FitObserver& observer) {
    checkFit(reader.header(), file, options);
    if (observer.phase) observer.phase("poses");
    return fitVisibility(reader, readPoses(reader, poseRequest(reader.header(), options)), file, options, observer);
}

PoseRequest poseRequest(const VisibilityHeader& header, const FitOptions& options) {
    const double angles = options.features == FeatureKind::kDihedrals ? inputVariance(options) : 0;
    return {splitFrames(header.frames, options.holdout, options.train_frames).train, std::size_t(options.parts), angles,
            options.threads};
}

FitResult fitVisibility(const VisibilityReader& reader, const PoseTable& poses, const std::string& file,
                        const FitOptions& options, const FitObserver& observer) {
    const VisibilityHeader& header = reader.header();
    const auto phase = [&](const char* name) {
        throwIfInterrupted();
        if (observer.phase) observer.phase(name);
    };
    checkInput(header, file, options);
    const Split split = splitFrames(header.frames, options.holdout, options.train_frames);
    // 1. Copy what the model keeps of the bake.
    FitResult result;
    Model& model = result.model;
    copyInput(header, poses, options, model);
    // 2. Cluster the vertices, and give each a tangent, which completes its local frame.
    phase("clusters");
    const VertexClusters clusters = clustersOf(model.mesh, poses, std::size_t(options.clusters), options.threads);
    model.cluster_of_vertex = clusters.cluster_of_vertex;
    model.rest_tangents = restTangents(model.mesh, model.rest_normals, clusters, options.threads);
    // 3. Fit every cluster.
    const FitJob job{reader, options, observer, poses, clusters, split, makeFolds(header.frames, split.train)};
    if (!options.fields.empty()) {
        model.composition = compositionOf(model, options.fields, header);
        phase("near parts");
        const NearChoice near = chooseNearParts(job, model);
        phase("fit");
        finishComposed(fitComposedClusters(job, model, near.hidden), split, result);
        const FarSample sample{std::size_t(options.compared_vertices)};
        if (!model.deforming && sample.vertices > 0)
            result.report.composed->far = measureFar({reader, poses, clusters, split, options.threads}, model, sample);
        result.report.composed->near = near.report;
        return result;
    }
    phase("fit");
    std::vector<ClusterFit> fits = fitClusters(job, model);
    // 4. Sum the errors and report them by clip and over all.
    const FrameErrors errors = sumOverClusters(fits, poses.frameCount(), &ClusterFit::errors);
    model.clip_errors = errorsByClip(errors, model.frames, model.holdout_clips, model.mesh.vertexCount());
    result.report = reportOf(fits, errors, split, model);
    for (ClusterFit& fit : fits) model.clusters.push_back(std::move(fit.model));
    return result;
}

}  // namespace penumbra
