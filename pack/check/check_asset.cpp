// Measures the error of an asset frame by frame.
//
// Problem: tell how far the evaluator's numbers are from the truth, and which stage the error comes from, over bakes
// that are larger than memory.
//
// Here: every frame is read once. Each cluster adds up sums of squares: of the error, of the truth, and of the truth
// outside the span of the components. All figures are ratios of such sums. The mean over training frames is known
// only at the end, so that the variation around it is computed from sums of the truth and of its squares.
// docs/formulas.md, section 5, defines the figures.
#include "pack/check/check_asset.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "pack/check/baked_frames.h"
#include "pack/check/check_far.h"
#include "pack/check/check_sums.h"
#include "pack/check/component_spans.h"
#include "pack/check/rank_correlation.h"
#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading.h"
#include "sh/sh_rotation.h"

namespace penumbra {

namespace {

// Buffers for one frame as both sides see it, in asset order.
struct FrameBuffers {
    std::vector<float> evaluated, truth, predicted, second, unpacked;  // [V * stride]
    // Only for a composed asset: local visibility of the model, of the truth, and of the truth in the model's span.
    std::vector<float> local, true_local, spanned_local;  // [V * stride]
    std::vector<float> far, far_alone;                    // [V * kFarCoefficients], the latter without near parts
    std::vector<Vec3> positions, normals, tangents;
    std::vector<float> e_evaluated, e_truth;

    FrameBuffers(const Evaluator& evaluator, std::size_t stride);
};

class Checker {
public:
    Checker(const AssetView& asset, const VisibilityReader& truth, const CheckReferences& references);
    void addFrame(std::size_t frame, int threads);
    CheckResult result() const;

private:
    const AssetView& asset_;
    const VisibilityReader& truth_;
    const CheckReferences references_;
    Evaluator evaluator_;
    ComponentSpans spans_;
    std::optional<Evaluator> unpacked_;
    std::optional<ComponentSpans> unpacked_spans_;
    std::optional<Evaluator> far_alone_;  // without near parts, which the truth's local numbers have already
    std::vector<ClipSums> clips_;
    std::vector<FrameCheck> frames_;
    FrameFinder predictions_, second_bake_;
    FrameBuffers buffers_;
    std::vector<double> frame_error_;  // [cluster], squared, of the frame that was added last; then of followers
    std::vector<std::uint32_t> rows_;  // of the truth for each vertex that it has, bakedRows()
    std::optional<FarCheck> far_;

    void compareVertex(std::size_t vertex, const BakedFrames& baked, CheckSums& sums);
    const LocalMoments* trueLocal() const;
    void findLocal(std::size_t cluster, const BakedFrames& baked);
    void compareComposition(std::size_t cluster, CheckSums& sums);
    void compareCluster(std::size_t cluster, const BakedFrames& baked, ClipSums& clip);
    void compareFollowers(const BakedFrames& baked, ClipSums& clip);
    void compareAmbient(std::size_t begin, std::size_t end, CheckSums& sums);
    bool comparesFollowers() const { return rows_.size() > evaluator_.firstFollower(); }
};

FrameBuffers::FrameBuffers(const Evaluator& evaluator, std::size_t stride) {
    const std::size_t count = evaluator.vertexCount();
    for (std::vector<float>* coefficients : {&evaluated, &truth, &predicted, &second, &unpacked})
        coefficients->resize(count * stride);
    if (evaluator.composed()) {
        for (std::vector<float>* coefficients : {&local, &true_local, &spanned_local})
            coefficients->resize(count * stride);
        far.resize(count * kFarCoefficients);
        if (evaluator.farTables().nearParts().count > 0) far_alone.resize(count * kFarCoefficients);
    }
    for (std::vector<Vec3>* vectors : {&positions, &normals, &tangents}) vectors->resize(count);
    for (std::vector<float>* e : {&e_evaluated, &e_truth}) e->resize(count);
}

Checker::Checker(const AssetView& asset, const VisibilityReader& truth, const CheckReferences& references)
    : asset_(asset),
      truth_(truth),
      references_(references),
      evaluator_(asset),
      spans_(asset),
      predictions_(references.predictions, "predictions"),
      second_bake_(references.second_bake, "second bake"),
      buffers_(evaluator_, std::size_t(asset.model.stride)),
      frame_error_(asset.model.clusters.size() + 1),
      rows_(bakedRows(asset, truth.header())) {
    evaluator_.setQuality(references.quality);
    // Vertices that follow points have the means of these, at rest.
    const std::size_t first = evaluator_.firstFollower(), all = evaluator_.vertexCount();
    if (first < all) evaluator_.follow(first, all, {asset.mesh.normals, asset.mesh.tangents}, spans_.mean);
    if (references.unpacked) {
        unpacked_.emplace(*references.unpacked);
        unpacked_spans_.emplace(*references.unpacked);
    }
    if (!buffers_.far_alone.empty() && trueLocal()) {
        far_alone_.emplace(evaluator_);
        far_alone_->setNearFactors(NearFactors::kWithout);
    }
    const std::size_t coefficients = evaluator_.vertexCount() * std::size_t(asset.model.stride);
    for (const std::string& name : truth.header().frames.clip_names) {
        ClipSums clip{name, true, 0, 0, std::vector<CheckSums>(frame_error_.size()), std::vector<double>(coefficients)};
        for (const ClipView& known : asset.animation.clips)
            if (known.name == name) clip.held_out = known.held_out;
        clips_.push_back(std::move(clip));
    }
    if (!trueLocal() || !truth.header().skin) return;
    std::array<std::vector<std::size_t>, 2> frames;  // of training, held out
    for (std::size_t f = 0; f < truth.header().frames.frameCount(); ++f)
        frames[clips_[truth.header().frames.clip[f]].held_out].push_back(f);
    far_.emplace(asset, truth.header(), first, frames);
}

// Turns the coefficients of one vertex of a prediction into numbers of the convention. They are moments like those of
// the truth, or the mirrored function itself, whose even coefficients in the local frame are the numbers.
void predictedCoefficients(const Convention& convention, bool mirrored, std::span<const float> prediction, Vec3 normal,
                           Vec3 tangent, std::span<float> coefficients) {
    if (!mirrored) return coefficientsFromMoments(convention, prediction, normal, tangent, coefficients);
    std::array<float, coefficientCount(kMaxOrder)> local;
    const auto count = std::size_t(coefficientCount(convention.order));
    apply(makeShRotation(convention.order, toLocalFrame(normal, tangent)), prediction.first(count),
          std::span(local).first(count));
    std::size_t j = 0;
    for (int band = 0; band < convention.order; ++band)
        for (int m = -band; m <= band; m += 2) coefficients[j++] = local[std::size_t(shIndex(band, m))];
}

double squaredDifference(std::span<const float> a, std::span<const float> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (double(a[i]) - b[i]) * (double(a[i]) - b[i]);
    return sum;
}

// Computes the truth of one vertex, and what needs nothing else: SH truncation, bake noise and distance to the
// predictions.
void Checker::compareVertex(std::size_t v, const BakedFrames& baked, CheckSums& sums) {
    const Convention& convention = asset_.model.convention;
    const std::size_t stride = std::size_t(asset_.model.stride), size = std::size_t(convention.size());
    const std::size_t point = rows_[v];
    FrameBuffers& b = buffers_;
    const auto ofPoint = [&](const VisibilityReader& reader, const VisibilityFrame& frame) {
        const std::size_t n = reader.header().coefficientCount();
        return std::span(frame.coefficients).subspan(point * n, n);
    };
    const std::span<float> y = std::span(b.truth).subspan(v * stride, size);
    const std::span<const float> moments = ofPoint(truth_, baked.truth);
    coefficientsFromMoments(convention, moments, b.normals[v], b.tangents[v], y);
    double squares = 0;
    for (float number : y) squares += double(number) * number;
    sums.truth_squares += squares;
    sums.sh_outside += binaryEnergy(convention, moments[0]) - squares;
    if (!baked.second.coefficients.empty()) {
        const std::span<float> other = std::span(b.second).subspan(v * stride, size);
        coefficientsFromMoments(convention, ofPoint(*references_.second_bake, baked.second), b.normals[v],
                                b.tangents[v], other);
        sums.noise += squaredDifference(other, y) / 2;
    }
    if (references_.predictions) {
        const std::span<float> p = std::span(b.predicted).subspan(v * stride, size);
        predictedCoefficients(convention, references_.predictions->header().quantity == "mirrored_visibility",
                              ofPoint(*references_.predictions, baked.predicted), b.normals[v], b.tangents[v], p);
        sums.prediction += squaredDifference(std::span(b.evaluated).subspan(v * stride, size), p);
    }
}

// Returns the truth's local moments where they are what the local part of the asset stands for, else null.
const LocalMoments* Checker::trueLocal() const {
    const std::optional<LocalMoments>& local = truth_.header().local;
    if (!evaluator_.composed() || !local) return nullptr;
    const ModelView& model = asset_.model;
    const bool fits = local->order >= model.convention.order && local->steps == model.composition->local_steps;
    return fits ? &*local : nullptr;
}

// Finds the local visibility of one cluster: the model's, and the truth's if it has that, before and after it is moved
// into the span of the model's components.
void Checker::findLocal(std::size_t cluster, const BakedFrames& baked) {
    const ClusterView& view = asset_.model.clusters[cluster];
    const std::size_t stride = std::size_t(asset_.model.stride), size = std::size_t(asset_.model.convention.size());
    FrameBuffers& b = buffers_;
    (unpacked_ ? *unpacked_ : evaluator_).evaluateLocal(cluster, b.local);
    if (far_alone_) far_alone_->evaluateFar(cluster, b.far_alone);
    const LocalMoments* moments = trueLocal();
    if (!moments) return;
    const std::size_t n = moments->coefficientCount();
    for (std::size_t v = view.first_vertex; v < view.first_vertex + std::size_t(view.vertex_count); ++v)
        coefficientsFromMoments(asset_.model.convention,
                                std::span(baked.truth.local_coefficients).subspan(rows_[v] * n, n), b.normals[v],
                                b.tangents[v], std::span(b.true_local).subspan(v * stride, size));
    if (unpacked_)
        unpacked_spans_->project(references_.unpacked->model.clusters[cluster], cluster, b.true_local, b.spanned_local);
    else
        spans_.project(view, cluster, b.true_local, b.spanned_local);
}

// Adds the errors of local visibility x far parts without the residual, by the model and by the truth. Their numbers
// are moved to where E lies in [0, 1], as those of the model are. The local numbers of the truth have what near parts
// hide, those of the model have not: the former are multiplied by far parts alone. So the model's components do not
// span the truth's local numbers then, and what they leave means nothing.
void Checker::compareComposition(std::size_t cluster, CheckSums& sums) {
    const ClusterView& view = asset_.model.clusters[cluster];
    const Convention& convention = asset_.model.convention;
    const std::size_t stride = std::size_t(asset_.model.stride), size = std::size_t(convention.size());
    const FrameBuffers& b = buffers_;
    using Coefficients = std::array<float, coefficientCount(kMaxOrder)>;
    Coefficients weight_buffer;
    const std::span<float> weights = std::span(weight_buffer).first(size);
    ambientWeights(convention, weights);
    float norm2 = 0;
    for (float w : weights) norm2 += w * w;
    const std::vector<float>& far_alone = far_alone_ ? b.far_alone : b.far;
    for (std::size_t v = view.first_vertex; v < view.first_vertex + std::size_t(view.vertex_count); ++v) {
        const auto composed = [&](const std::vector<float>& local, const std::vector<float>& of_all,
                                  Coefficients& buffer) {
            const std::span<const float> far = std::span(of_all).subspan(v * kFarCoefficients, kFarCoefficients);
            const std::span<float> to = std::span(buffer).first(size);
            multiplyMirrored(convention.order, std::span(local).subspan(v * stride, size), convention.order, far,
                             kFieldOrder, to);
            clampAmbient(weights, norm2, to);
            return std::span<const float>(to);
        };
        const std::span<const float> y = std::span(b.truth).subspan(v * stride, size);
        Coefficients of_model, of_truth, of_span;
        const std::span<const float> model = composed(b.local, b.far, of_model);
        sums.without_residual += squaredDifference(model, y);
        if (!trueLocal()) continue;
        const std::span<const float> truth = composed(b.true_local, far_alone, of_truth);
        sums.split += squaredDifference(truth, y);
        sums.local += squaredDifference(truth, model);
        if (far_alone_) continue;
        const std::span<const float> spanned = composed(b.spanned_local, b.far, of_span);
        sums.local_outside += squaredDifference(spanned, truth);
        sums.local_regression += squaredDifference(model, spanned);
    }
}

// Adds the errors of E of vertices [begin, end), whose numbers and truth are known.
void Checker::compareAmbient(std::size_t begin, std::size_t end, CheckSums& sums) {
    FrameBuffers& b = buffers_;
    const std::size_t stride = std::size_t(asset_.model.stride), count = end - begin;
    const std::span<float> e = std::span(b.e_evaluated).subspan(begin, count),
                           e_truth = std::span(b.e_truth).subspan(begin, count);
    ambient(asset_, std::span<const float>(b.evaluated).subspan(begin * stride, count * stride), e);
    ambient(asset_, std::span<const float>(b.truth).subspan(begin * stride, count * stride), e_truth);
    for (std::size_t v = 0; v < count; ++v) sums.ambient += std::abs(double(e[v]) - e_truth[v]);
}

// Adds the errors of vertices that follow points, once all clusters are evaluated and skinned. They have no components,
// and the points that they follow have already what packing and dropping cost.
void Checker::compareFollowers(const BakedFrames& baked, ClipSums& clip) {
    const std::size_t begin = evaluator_.firstFollower(), end = evaluator_.vertexCount();
    const std::size_t stride = std::size_t(asset_.model.stride);
    FrameBuffers& b = buffers_;
    evaluator_.skin(begin, end, b.positions, b.normals, b.tangents);
    evaluator_.follow(begin, end, {b.normals, b.tangents}, b.evaluated);
    CheckSums sums;
    for (std::size_t v = begin; v < end; ++v) compareVertex(v, baked, sums);
    const auto part = [&](const std::vector<float>& coefficients) {
        return std::span<const float>(coefficients).subspan(begin * stride);
    };
    const std::span<const float> y = part(b.truth);
    for (std::size_t i = 0; i < y.size(); ++i) clip.truth_sum[begin * stride + i] += y[i];
    sums.error = frame_error_.back() = squaredDifference(part(b.evaluated), y);
    compareAmbient(begin, end, sums);
    clip.of_cluster.back().add(sums);
}

// Evaluates one cluster and adds its errors to the sums of the clip.
void Checker::compareCluster(std::size_t cluster, const BakedFrames& baked, ClipSums& clip) {
    const ClusterView& view = asset_.model.clusters[cluster];
    const std::size_t begin = view.first_vertex, end = begin + view.vertex_count;
    const std::size_t stride = std::size_t(asset_.model.stride);
    FrameBuffers& b = buffers_;
    const bool composed = evaluator_.composed();
    if (composed) {
        evaluator_.evaluateFar(cluster, b.far);
        evaluator_.composeCluster(cluster, b.far, b.evaluated);
    } else {
        evaluator_.evaluateCluster(cluster, b.evaluated);
    }
    evaluator_.skin(begin, end, b.positions, b.normals, b.tangents);
    CheckSums sums;
    for (std::size_t v = begin; v < end; ++v) compareVertex(v, baked, sums);
    const auto part = [&](const std::vector<float>& coefficients) {
        return std::span<const float>(coefficients).subspan(begin * stride, (end - begin) * stride);
    };
    const std::span<const float> y = part(b.truth);
    for (std::size_t i = 0; i < y.size(); ++i) clip.truth_sum[begin * stride + i] += y[i];
    sums.error = frame_error_[cluster] = squaredDifference(part(b.evaluated), y);
    if (composed) {
        findLocal(cluster, baked);
        compareComposition(cluster, sums);
    } else {
        sums.outside = spans_.squaredDistance(view, cluster, b.truth);
    }
    if (unpacked_) {
        if (composed)
            unpacked_->composeCluster(cluster, b.far, b.unpacked);  // the far parts are the same
        else
            unpacked_->evaluateCluster(cluster, b.unpacked);
        sums.unpacked = squaredDifference(part(b.unpacked), y);
        if (!composed)
            sums.unpacked_outside =
                unpacked_spans_->squaredDistance(references_.unpacked->model.clusters[cluster], cluster, b.truth);
        sums.packing = squaredDifference(part(b.unpacked), part(b.evaluated));
    }
    compareAmbient(begin, end, sums);
    clip.of_cluster[cluster].add(sums);
}

void Checker::addFrame(std::size_t frame, int threads) {
    const FrameList& frames = truth_.header().frames;
    ClipSums& clip = clips_[frames.clip[frame]];
    const double time = frames.time[frame];
    BakedFrames baked{truth_.readFrame(frame), predictions_.read(clip.name, time), {}};
    if (second_bake_.has(clip.name, time)) {
        baked.second = second_bake_.read(clip.name, time);
        checkSamePose(baked.truth, baked.second, clip.name, time);
        ++clip.second_frames;
    }
    poseAs(evaluator_, baked.truth);
    if (unpacked_) poseAs(*unpacked_, baked.truth);
    if (far_alone_) poseAs(*far_alone_, baked.truth);
    parallelFor(asset_.model.clusters.size(), threads, [&](std::size_t c) { compareCluster(c, baked, clip); });
    if (comparesFollowers()) compareFollowers(baked, clip);
    if (far_ && far_->takes(frame)) {
        const FrameBuffers& b = buffers_;
        clip.far.add(far_->compare(evaluator_, {b.positions, b.normals, b.tangents, b.truth, b.true_local}, threads));
        ++clip.far_frames;
    }
    for (std::size_t v = 0; v < rows_.size(); ++v)
        clip.tail.add(std::abs(double(buffers_.e_evaluated[v]) - buffers_.e_truth[v]));
    if (references_.worst)
        references_.worst->addFrame(frame, std::span(buffers_.e_evaluated).first(rows_.size()),
                                    std::span(buffers_.e_truth).first(rows_.size()));
    ++clip.frames;
    double error = 0;
    for (double squares : frame_error_) error += squares;
    const double rms_v = std::sqrt(error / double(rows_.size()) / (4 * std::numbers::pi));
    frames_.push_back({clip.name, time, clip.held_out, rms_v, evaluator_.outOfRange()});
}

CheckResult Checker::result() const {
    const bool spanned = !comparesFollowers();
    const CheckMeasured measured{evaluator_.composed(),
                                 spanned && trueLocal(),
                                 spanned && references_.unpacked,
                                 rows_.size(),
                                 spanned,
                                 !far_alone_};
    CheckResult result = figuresOf(clips_, spans_.mean, measured);
    result.frames = frames_;
    if (far_) result.far_vertices = far_->vertexCount();
    return result;
}

}  // namespace

double rangeCorrelation(const CheckResult& result) {
    std::vector<double> distance, error;
    for (const FrameCheck& frame : result.frames) {
        if (!frame.held_out) continue;
        distance.push_back(frame.out_of_range);
        error.push_back(frame.rms_v);
    }
    return rankCorrelation(distance, error);
}

CheckResult checkAsset(const AssetView& asset, const VisibilityReader& truth, const CheckReferences& references,
                       int threads, const std::function<void(std::size_t)>& progress) {
    checkFits(asset, truth.header(), references);
    Checker checker(asset, truth, references);
    for (std::size_t f = 0; f < truth.header().frames.frameCount(); ++f) {
        throwIfInterrupted();
        checker.addFrame(f, threads);
        progress(f + 1);
    }
    return checker.result();
}

}  // namespace penumbra
