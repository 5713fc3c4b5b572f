#include "pack/check_asset.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "formats/errors.h"
#include "formats/parallel_for.h"
#include "formats/write_file.h"
#include "pack/least_squares.h"
#include "player/runtime/evaluator.h"
#include "player/runtime/shading.h"
#include "sh/sh_rotation.h"

namespace penumbra {

namespace {

struct Sums {
    double error = 0, truth_squares = 0, outside = 0, ambient = 0, prediction = 0;

    void add(const Sums& other) {
        error += other.error;
        truth_squares += other.truth_squares;
        outside += other.outside;
        ambient += other.ambient;
        prediction += other.prediction;
    }
};

// One clip of the truth: sums, and per number the sum of the truth, for the mean over training frames.
struct ClipSums {
    std::string name;
    bool held_out = true;
    std::size_t frames = 0;
    std::vector<Sums> of_cluster;
    std::vector<double> truth_sum;  // [V * stride], asset order
};

// A frame as both sides see it, in asset order.
struct FrameBuffers {
    std::vector<float> evaluated, truth, predicted;  // [V * stride]
    std::vector<Vec3> positions, normals, tangents;
    std::vector<float> e_evaluated, e_truth;
};

class Checker {
public:
    Checker(const AssetView& asset, const VisibilityReader& truth, const VisibilityReader* predictions);
    void addFrame(std::size_t frame, int threads);
    CheckResult result() const;

private:
    const AssetView& asset_;
    const VisibilityReader& truth_;
    const VisibilityReader* predictions_;
    Evaluator evaluator_;
    std::vector<SpanProjector> projectors_;  // [cluster]
    std::vector<float> mean_;                // [V * stride], stored
    std::vector<ClipSums> clips_;
    std::map<std::pair<std::string, double>, std::size_t> prediction_of_;  // clip and time -> frame
    FrameBuffers buffers_;

    void compareCluster(std::size_t cluster, const VisibilityFrame& frame, const VisibilityFrame& predicted,
                        ClipSums& clip);
    ErrorFigures figuresOf(std::span<const ClipSums* const> clips, std::span<const double> mean) const;
};

Checker::Checker(const AssetView& asset, const VisibilityReader& truth, const VisibilityReader* predictions)
    : asset_(asset), truth_(truth), predictions_(predictions), evaluator_(asset) {
    const std::size_t count = evaluator_.vertexCount(), numbers = count * std::size_t(asset.model.stride);
    mean_.resize(numbers);
    std::size_t first = 0;
    for (const ClusterView& cluster : asset.model.clusters) {
        decode(cluster.mean, std::span(mean_).subspan(first, cluster.mean.count));
        first += cluster.mean.count;
        std::vector<float> basis(cluster.basis.count);
        decode(cluster.basis, basis);
        projectors_.emplace_back(std::move(basis), cluster.mean.count);
    }
    for (const std::string& name : truth.header().frames.clip_names) {
        ClipSums clip{name, true, 0, std::vector<Sums>(asset.model.clusters.size()), std::vector<double>(numbers)};
        for (const ClipView& known : asset.animation.clips)
            if (known.name == name) clip.held_out = known.held_out;
        clips_.push_back(std::move(clip));
    }
    if (predictions) {
        const FrameList& frames = predictions->header().frames;
        for (std::size_t f = 0; f < frames.frameCount(); ++f)
            prediction_of_[{frames.clip_names[frames.clip[f]], frames.time[f]}] = f;
    }
    buffers_ = {std::vector<float>(numbers), std::vector<float>(numbers), std::vector<float>(numbers),
                std::vector<Vec3>(count),    std::vector<Vec3>(count),    std::vector<Vec3>(count),
                std::vector<float>(count),   std::vector<float>(count)};
}

// Coefficients of one vertex of a prediction as numbers of the convention. Moments like the truth's, or the mirrored
// function itself, whose even coefficients in the local frame are the numbers.
void predictedNumbers(const Convention& convention, bool mirrored, std::span<const float> coefficients, Vec3 normal,
                      Vec3 tangent, std::span<float> numbers) {
    if (!mirrored) return numbersFromMoments(convention, coefficients, normal, tangent, numbers);
    std::array<float, coefficientCount(kMaxOrder)> local;
    const auto count = std::size_t(coefficientCount(convention.order));
    apply(makeShRotation(convention.order, localFrame(normal, tangent)), coefficients.first(count),
          std::span(local).first(count));
    std::size_t j = 0;
    for (int band = 0; band < convention.order; ++band)
        for (int m = -band; m <= band; m += 2) numbers[j++] = local[std::size_t(shIndex(band, m))];
}

double squaredDifference(std::span<const float> a, std::span<const float> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (double(a[i]) - b[i]) * (double(a[i]) - b[i]);
    return sum;
}

void Checker::compareCluster(std::size_t cluster, const VisibilityFrame& frame, const VisibilityFrame& predicted,
                             ClipSums& clip) {
    const ClusterView& view = asset_.model.clusters[cluster];
    const Convention& convention = asset_.model.convention;
    const std::size_t begin = view.first_vertex, end = begin + view.vertex_count;
    const std::size_t stride = std::size_t(asset_.model.stride), size = std::size_t(convention.size());
    const std::size_t moments = truth_.header().coefficientCount();
    FrameBuffers& b = buffers_;
    evaluator_.evaluateCluster(cluster, b.evaluated);
    evaluator_.skin(begin, end, b.positions, b.normals, b.tangents);
    Sums sums;
    for (std::size_t v = begin; v < end; ++v) {
        const std::size_t point = asset_.mesh.shading_point[v];
        const std::span<float> y = std::span(b.truth).subspan(v * stride, size);
        const std::span<float> evaluated = std::span(b.evaluated).subspan(v * stride, size);
        numbersFromMoments(convention, std::span(frame.coefficients).subspan(point * moments, moments), b.normals[v],
                           b.tangents[v], y);
        sums.error += squaredDifference(evaluated, y);
        for (std::size_t i = 0; i < size; ++i) {
            sums.truth_squares += double(y[i]) * y[i];
            clip.truth_sum[v * stride + i] += y[i];
        }
        if (!predictions_) continue;
        const std::size_t n = predictions_->header().coefficientCount();
        const std::span<float> p = std::span(b.predicted).subspan(v * stride, size);
        predictedNumbers(convention, predictions_->header().quantity == "mirrored_visibility",
                         std::span(predicted.coefficients).subspan(point * n, n), b.normals[v], b.tangents[v], p);
        sums.prediction += squaredDifference(evaluated, p);
    }
    ambient(convention, int(stride), begin, end, b.evaluated, b.e_evaluated);
    ambient(convention, int(stride), begin, end, b.truth, b.e_truth);
    for (std::size_t v = begin; v < end; ++v) sums.ambient += std::abs(double(b.e_evaluated[v]) - b.e_truth[v]);
    const std::size_t first = begin * stride, count = view.mean.count;
    sums.outside = projectors_[cluster].squaredDistance(std::span<const float>(b.truth).subspan(first, count),
                                                        std::span<const float>(mean_).subspan(first, count));
    clip.of_cluster[cluster].add(sums);
}

void Checker::addFrame(std::size_t frame, int threads) {
    const FrameList& frames = truth_.header().frames;
    ClipSums& clip = clips_[frames.clip[frame]];
    const VisibilityFrame baked = truth_.readFrame(frame);
    VisibilityFrame predicted;
    if (predictions_) {
        const auto found = prediction_of_.find({clip.name, frames.time[frame]});
        if (found == prediction_of_.end())
            throw InvalidInput("predictions: no frame of clip \"" + clip.name + "\" at " +
                               std::to_string(frames.time[frame]) + " s");
        predicted = predictions_->readFrame(found->second);
    }
    evaluator_.setPose(baked.bones, baked.pose);
    parallelFor(asset_.model.clusters.size(), threads,
                [&](std::size_t c) { compareCluster(c, baked, predicted, clip); });
    ++clip.frames;
}

// sum over frames (y - mean)^2 = sum y^2 - 2 mean . sum y + frames |mean|^2.
ErrorFigures Checker::figuresOf(std::span<const ClipSums* const> clips, std::span<const double> mean) const {
    ErrorFigures figures;
    Sums total;
    double variation = 0;
    for (const ClipSums* clip : clips) {
        figures.frames += clip->frames;
        for (const Sums& sums : clip->of_cluster) total.add(sums);
        for (std::size_t i = 0; i < mean.size(); ++i)
            variation += mean[i] * (double(clip->frames) * mean[i] - 2 * clip->truth_sum[i]);
    }
    variation += total.truth_squares;
    const double vertices = double(figures.frames) * double(evaluator_.vertexCount());
    figures.relative_error = std::sqrt(total.error / variation);
    figures.truncation = std::sqrt(total.outside / variation);
    figures.regression = std::sqrt(std::max(0.0, total.error - total.outside) / variation);
    figures.prediction_difference = std::sqrt(total.prediction / variation);
    figures.rms_v = std::sqrt(total.error / vertices / (4 * std::numbers::pi));
    figures.ambient_error = total.ambient / vertices;
    return figures;
}

CheckResult Checker::result() const {
    std::vector<const ClipSums*> training, held_out;
    for (const ClipSums& clip : clips_)
        if (clip.frames > 0) (clip.held_out ? held_out : training).push_back(&clip);
    std::vector<double> mean(mean_.begin(), mean_.end());
    CheckResult result;
    result.mean_from_truth = !training.empty();
    if (result.mean_from_truth) {
        std::fill(mean.begin(), mean.end(), 0.0);
        double frames = 0;
        for (const ClipSums* clip : training) {
            frames += double(clip->frames);
            for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += clip->truth_sum[i];
        }
        for (double& m : mean) m /= frames;
    }
    for (const ClipSums& clip : clips_) {
        if (clip.frames == 0) continue;
        const ClipSums* one[] = {&clip};
        result.clips.push_back(figuresOf(one, mean));
        result.clips.back().name = clip.name;
        result.clips.back().held_out = clip.held_out;
    }
    if (!training.empty()) result.training = figuresOf(training, mean);
    if (!held_out.empty()) result.held_out = figuresOf(held_out, mean);
    result.training.name = "all training";
    result.held_out.name = "all held out";
    result.held_out.held_out = true;
    return result;
}

}  // namespace

void checkFits(const AssetView& asset, const VisibilityHeader& header) {
    if (!asset.has_model) throw InvalidInput("the asset has no model to check");
    const MeshView& mesh = asset.mesh;
    if (!header.skin) throw InvalidInput("has no skin; the asset's model needs one");
    if (header.mesh.vertexCount() != mesh.positions.size())
        throw InvalidInput("has " + std::to_string(header.mesh.vertexCount()) + " vertices, the asset " +
                           std::to_string(mesh.positions.size()));
    if (header.skin->jointCount() != asset.animation.jointCount())
        throw InvalidInput("has " + std::to_string(header.skin->jointCount()) + " joints, the asset " +
                           std::to_string(asset.animation.jointCount()));
    if (header.order < asset.model.convention.order)
        throw InvalidInput("sh_order is " + std::to_string(header.order) + ", the asset needs " +
                           std::to_string(asset.model.convention.order));
    if (asset.model.features == AssetFeatures::kJointAngles &&
        std::uint32_t(header.pose_size) != asset.animation.pose_size)
        throw InvalidInput("has a pose of " + std::to_string(header.pose_size) + " numbers, the asset of " +
                           std::to_string(asset.animation.pose_size));
    const double tolerance = 1e-5 * boxDiagonal(header.mesh.rest_positions);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
        if (!(length(mesh.positions[v] - header.mesh.rest_positions[mesh.shading_point[v]]) <= tolerance))
            throw InvalidInput("/mesh/rest_positions are not those of the asset (vertex " +
                               std::to_string(mesh.shading_point[v]) + ")");
}

CheckResult checkAsset(const AssetView& asset, const VisibilityReader& truth, const VisibilityReader* predictions,
                       int threads, const std::function<void(std::size_t)>& progress) {
    checkFits(asset, truth.header());
    if (predictions) checkFits(asset, predictions->header());
    Checker checker(asset, truth, predictions);
    for (std::size_t f = 0; f < truth.header().frames.frameCount(); ++f) {
        throwIfInterrupted();
        checker.addFrame(f, threads);
        progress(f + 1);
    }
    return checker.result();
}

}  // namespace penumbra
