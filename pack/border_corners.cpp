#include "pack/border_corners.h"

#include <algorithm>
#include <cmath>

#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "pack/compress/dense_solvers.h"
#include "pack/pack_asset.h"
#include "runtime/evaluate/evaluator.h"
#include "sh/tangent.h"

namespace penumbra {

namespace {

// More frames than these tell little more about how the scores of two clusters go together.
constexpr std::size_t kMaxFrames = 240;
constexpr double kRidge = 1e-4;  // of the mean energy of a score

// What the fitted model does in some training frames.
struct SeenFrames {
    std::vector<std::size_t> frames;
    std::array<std::vector<Eigen::MatrixXd>, kClusterLists> scores;  // [list][cluster] [F, K]
    std::vector<std::vector<Mat3>> rotations;                        // [F][cluster] of its joint
};

std::vector<std::size_t> trainingFrames(const Model& model) {
    std::vector<std::size_t> all, some;
    for (std::size_t f = 0; f < model.frames.frameCount(); ++f) {
        const std::string& clip = model.frames.clip_names[model.frames.clip[f]];
        if (std::find(model.holdout_clips.begin(), model.holdout_clips.end(), clip) == model.holdout_clips.end())
            all.push_back(f);
    }
    const std::size_t count = std::min(all.size(), kMaxFrames);
    for (std::size_t i = 0; i < count; ++i) some.push_back(all[i * all.size() / count]);
    return some;
}

SeenFrames seenFrames(const Model& model, int threads) {
    PackOptions exact;
    exact.precision = AssetPrecision::kF32;
    const std::vector<std::byte> bytes = packAsset(model, {}, {}, exact, "{}", threads).bytes;
    const AssetView asset = openAsset(bytes);
    Evaluator evaluator(asset);
    SeenFrames seen;
    seen.frames = trainingFrames(model);
    const auto lists = clusterLists(model);
    for (std::size_t l = 0; l < kClusterLists; ++l)
        for (const ClusterModel& cluster : *lists[l])
            seen.scores[l].emplace_back(
                Eigen::MatrixXd::Zero(Eigen::Index(seen.frames.size()), Eigen::Index(cluster.components())));
    for (std::size_t i = 0; i < seen.frames.size(); ++i) {
        evaluator.setFrame(seen.frames[i]);
        seen.rotations.emplace_back();
        for (std::size_t c = 0; c < model.clusters.size(); ++c) {
            seen.rotations.back().push_back(evaluator.clusterRotation(c));
            const std::array<std::span<const float>, kClusterLists> scores{
                evaluator.scores(c), evaluator.residualScores(c), evaluator.indirectScores(c)};
            for (std::size_t l = 0; l < kClusterLists; ++l)
                for (std::size_t k = 0; k < scores[l].size(); ++k)
                    seen.scores[l][c](Eigen::Index(i), Eigen::Index(k)) = double(scores[l][k]);
        }
    }
    return seen;
}

// Maps numbers over the frames to components of the scores, [K, F], by least squares about the means.
struct ScoreFit {
    Eigen::RowVectorXd mean;  // [K]
    Eigen::MatrixXd solve;    // [K, F]
};

ScoreFit fitOfScores(const Eigen::MatrixXd& scores) {
    ScoreFit fit;
    const Eigen::Index components = scores.cols();
    if (components == 0) return {Eigen::RowVectorXd(0), Eigen::MatrixXd(0, scores.rows())};
    fit.mean = scores.colwise().mean();
    const Eigen::MatrixXd about = scores.rowwise() - fit.mean;
    Eigen::MatrixXd energy = about.transpose() * about;
    const double ridge = std::max(kRidge * energy.trace() / double(components), 1e-30);
    const SymmetricAxes axes = symmetricAxes(energy);
    const Eigen::VectorXd inverse = (axes.values.array().max(0.0) + ridge).inverse();
    fit.solve = axes.axes * inverse.asDiagonal() * axes.axes.transpose() * about.transpose();
    return fit;
}

// The normal of a vertex in each frame.
std::vector<Vec3> posedNormals(const Model& model, const SeenFrames& seen, std::uint32_t vertex) {
    const auto influences = std::size_t(model.skin.influences);
    std::vector<Vec3> normals;
    for (const std::size_t f : seen.frames) {
        Affine blend{{}};
        for (std::size_t k = vertex * influences; k < (vertex + 1) * influences; ++k)
            for (std::size_t i = 0; i < 12; ++i)
                blend.m[i] +=
                    model.skin.weights[k] * model.bones[f * model.skin.jointCount() + model.skin.joints[k]].m[i];
        normals.push_back(normalized(cofactor(blend.linear()) * model.rest_normals[vertex]));
    }
    return normals;
}

}  // namespace

std::array<const std::vector<ClusterModel>*, kClusterLists> clusterLists(const Model& model) {
    static const std::vector<ClusterModel> kEmpty;
    return {&model.clusters, model.composition ? &model.composition->residual : &kEmpty,
            model.indirect ? &model.indirect->clusters : &kEmpty};
}

std::array<TurnTable, kClusterLists> turnsOfLists(const Model& model) {
    return {turnsOf(model.convention), turnsOf(model.convention), turnsOfIndirect()};
}

namespace {

struct BorderProblem {
    const Model& fitted;
    const SeenFrames& seen;
    std::array<const std::vector<ClusterModel>*, kClusterLists> lists;
    std::array<TurnTable, kClusterLists> turns;
    std::vector<std::uint32_t> place;  // [V] in the vertices of its cluster
};

// Returns what the model predicts for the corner in each frame, [F, n], in the frame that its new cluster carries.
Eigen::MatrixXd coefficientsOverFrames(const BorderProblem& problem, std::size_t list, BorderCorner corner) {
    const std::size_t from = problem.fitted.cluster_of_vertex[corner.vertex], n = problem.turns[list].size();
    const ClusterModel& cluster = (*problem.lists[list])[from];
    const std::size_t at = problem.place[corner.vertex], count = cluster.vertices.size();
    const std::vector<Vec3> normals = posedNormals(problem.fitted, problem.seen, corner.vertex);
    const Vec3 rest = problem.fitted.rest_tangents[corner.vertex];
    std::vector<float> coefficients(n), turned(n);
    Eigen::MatrixXd out(Eigen::Index(normals.size()), Eigen::Index(n));
    for (std::size_t f = 0; f < normals.size(); ++f) {
        for (std::size_t j = 0; j < n; ++j) {
            double sum = cluster.mean[at * n + j];
            for (std::size_t k = 0; k < cluster.components(); ++k)
                sum += problem.seen.scores[list][from](Eigen::Index(f), Eigen::Index(k)) *
                       double(cluster.basis[(k * count + at) * n + j]);
            coefficients[j] = float(sum);
        }
        const std::vector<Mat3>& rotations = problem.seen.rotations[f];
        const Vec3 own = tangentOf(normals[f], rotations[from] * rest);
        const Vec3 other = tangentOf(normals[f], rotations[corner.cluster] * rest);
        apply(makeTurn(problem.turns[list], angleBetween(normals[f], own, other)), coefficients, turned);
        for (std::size_t j = 0; j < n; ++j) out(Eigen::Index(f), Eigen::Index(j)) = double(turned[j]);
    }
    return out;
}

std::vector<float> rowsOf(const ScoreFit& fit, const Eigen::MatrixXd& over_frames) {
    const Eigen::MatrixXd components = fit.solve * over_frames;
    Eigen::RowVectorXd mean = over_frames.colwise().mean();
    if (components.rows() > 0) mean -= fit.mean * components;
    std::vector<float> rows;
    for (Eigen::Index j = 0; j < mean.size(); ++j) rows.push_back(float(mean(j)));
    for (Eigen::Index k = 0; k < components.rows(); ++k)
        for (Eigen::Index j = 0; j < components.cols(); ++j) rows.push_back(float(components(k, j)));
    return rows;
}

// Returns where the corners of each cluster begin, and the end. Corners are sorted.
std::vector<std::size_t> runsOf(std::span<const BorderCorner> corners) {
    std::vector<std::size_t> first{0};
    for (std::size_t i = 1; i < corners.size(); ++i)
        if (corners[i].cluster != corners[i - 1].cluster) first.push_back(i);
    first.push_back(corners.size());
    return first;
}

}  // namespace

BorderRows borderRows(const Model& fitted, std::span<const BorderCorner> corners, int threads) {
    BorderRows rows;
    for (auto& list : rows) list.resize(corners.size());
    if (corners.empty()) return rows;
    const SeenFrames seen = seenFrames(fitted, threads);
    BorderProblem problem{fitted, seen, clusterLists(fitted), turnsOfLists(fitted), {}};
    problem.place.resize(fitted.mesh.vertexCount());
    for (const ClusterModel& cluster : fitted.clusters)
        for (std::size_t i = 0; i < cluster.vertices.size(); ++i) problem.place[cluster.vertices[i]] = std::uint32_t(i);
    const std::vector<std::size_t> first = runsOf(corners);
    parallelFor(first.size() - 1, threads, [&](std::size_t run) {
        for (std::size_t l = 0; l < kClusterLists; ++l) {
            if (problem.lists[l]->empty()) continue;
            const ScoreFit fit = fitOfScores(seen.scores[l][corners[first[run]].cluster]);
            for (std::size_t i = first[run]; i < first[run + 1]; ++i) {
                throwIfInterrupted();
                rows[l][i] = rowsOf(fit, coefficientsOverFrames(problem, l, corners[i]));
            }
        }
    });
    return rows;
}

}  // namespace penumbra
