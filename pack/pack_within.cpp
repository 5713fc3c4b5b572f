// Searches for the smallest asset within the bounds that the user gives.
//
// Problem: choose a precision of the basis and the components that stay, so that the model takes at most so many
// bytes a vertex, or loses at most such an error, where both depend on the finished file: vectors are padded, and
// rounding and dropping together make one error.
//
// Naive: try every number of components. Each attempt writes an asset and evaluates all training frames.
//
// Here: components are ranked once by what they add to predictions (compress_model.h), which predicts bytes and error
// of every choice well. The search starts at the predicted choice, measures it with the evaluator, and corrects the
// prediction a little until the bound holds. That takes few attempts. docs/formulas.md, end of section 4, tells what
// dropping costs.
#include "pack/pack_within.h"

#include <cmath>
#include <cstdio>
#include <numbers>

#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "pack/compress/compress_model.h"
#include "pack/compress/packing_error.h"
#include "runtime/evaluate/evaluator.h"

namespace penumbra {

namespace {

// The share of its squared signal that a model may lose if nobody limits its components: 3% of its signal, which adds
// 0.1% to a relative error of 0.5.
constexpr double kNegligibleEnergy = 1e-3;

// What the training frames say of each cluster, and then of each cluster of a residual.
struct Training {
    std::vector<std::vector<float>> scores;  // [F, K]
    // How much of the energy of its numbers reaches the final ones: 1, or of the local part of a composed model the
    // mean square of the far visibility that it is multiplied by.
    std::vector<double> share;
};

Training trainingOf(const AssetView& exact, int threads) {
    Evaluator evaluator(exact);
    const std::size_t clusters = evaluator.clusterCount();
    const bool residual = evaluator.composed() && !exact.model.composition->residual.empty();
    Training training{std::vector<std::vector<float>>(residual ? 2 * clusters : clusters), {}};
    training.share.assign(training.scores.size(), 1.0);
    for (const ClipView& clip : exact.animation.clips) {
        if (clip.held_out) continue;
        throwIfInterrupted();
        for (std::size_t f = clip.first_frame; f < clip.first_frame + std::size_t(clip.frame_count); ++f) {
            evaluator.setPose(exact.animation.bonesOf(f), exact.animation.poseOf(f));
            for (std::size_t c = 0; c < training.scores.size(); ++c) {
                const std::span<const float> y =
                    c < clusters ? evaluator.scores(c) : evaluator.residualScores(c - clusters);
                training.scores[c].insert(training.scores[c].end(), y.begin(), y.end());
            }
        }
    }
    // A deforming mesh has no vertices without its frames' positions, which an asset may leave out.
    if (!evaluator.composed() || evaluator.deformation()) return training;
    std::vector<float> far(evaluator.vertexCount() * kFarCoefficients);
    const std::vector<std::size_t> frames = packingFrames(exact);
    std::vector<double> squares(clusters);
    for (const std::size_t f : frames) {
        throwIfInterrupted();
        evaluator.setPose(exact.animation.bonesOf(f), exact.animation.poseOf(f));
        parallelFor(clusters, threads, [&](std::size_t c) {
            evaluator.evaluateFar(c, far);
            const ClusterView& view = exact.model.clusters[c];
            for (float x :
                 std::span(far).subspan(view.first_vertex * kFarCoefficients, view.vertex_count * kFarCoefficients))
                squares[c] += double(x) * x;
        });
    }
    for (std::size_t c = 0; c < clusters && !frames.empty(); ++c)
        training.share[c] =
            squares[c] / (4 * std::numbers::pi * double(frames.size()) * double(exact.model.clusters[c].vertex_count));
    return training;
}

// One choice of components at one precision, and what the asset would then be like.
struct Attempt {
    ComponentChoice choice;
    double model_bytes = 0;
    PackingSums sums;
};

std::string figure(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", value);
    return text;
}

class Search {
public:
    Search(const Model& model, const WriteAsset& write, int threads)
        : whole_(model), ranked_(model), write_(write), threads_(threads) {
        exact_ = write(model, AssetPrecision::kF32, {});
        for (const ClusterModel* cluster : allClusters(model)) components_ += cluster->components();
    }

    // Keeps every component as the model has it.
    Packed asItIs(AssetPrecision precision) const;
    // Ranks the components by what they add to predictions.
    void rank();
    // Call after rank(). Returns nothing when this precision cannot meet the limits; `refusal` then says why.
    std::optional<Packed> within(const PackOptions& options, AssetPrecision precision,
                                 std::optional<BadOption>& refusal) const;

private:
    const Model& whole_;
    Model ranked_;  // after rank(): components by what they add to predictions
    const WriteAsset& write_;
    int threads_;
    std::vector<std::byte> exact_;
    std::size_t components_ = 0;
    std::vector<std::vector<double>> energies_;  // after rank(): [cluster, K] of allClusters()

    Model chosen(const ComponentChoice& choice) const;
    double bytesOf(const ComponentChoice& choice, AssetPrecision precision) const;
    Attempt attempt(const ComponentChoice& choice, AssetPrecision precision) const;
    Attempt shrinkToBytes(const ComponentCosts& costs, Attempt whole, double bytes, AssetPrecision precision) const;
    Attempt shrinkToError(const ComponentCosts& costs, Attempt whole, double error, AssetPrecision precision) const;
    Packed finish(const Model& model, const Attempt& found, AssetPrecision precision) const;
};

void Search::rank() {
    const Training training = trainingOf(openAsset(exact_), threads_);
    const std::vector<ClusterModel*> clusters = allClusters(ranked_);
    energies_.resize(clusters.size());
    parallelFor(clusters.size(), threads_, [&](std::size_t c) {
        energies_[c] = turnToPrincipalAxes(*clusters[c], training.scores[c]);
        double worth = training.share[c];
        if (c >= ranked_.clusters.size()) worth *= ranked_.composition->residual_worth;
        for (double& energy : energies_[c]) energy *= worth;
    });
}

Model Search::chosen(const ComponentChoice& choice) const {
    Model model = ranked_;
    const std::vector<ClusterModel*> clusters = allClusters(model);
    for (std::size_t c = 0; c < clusters.size(); ++c) keepComponents(*clusters[c], choice.kept[c]);
    return model;
}

Attempt Search::attempt(const ComponentChoice& choice, AssetPrecision precision) const {
    const std::vector<std::byte> bytes = write_(chosen(choice), precision, {});
    const AssetView asset = openAsset(bytes);
    return {choice, double(modelBytes(asset, bytes.size())), comparePacked(asset, openAsset(exact_), threads_)};
}

double Search::bytesOf(const ComponentChoice& choice, AssetPrecision precision) const {
    const std::vector<std::byte> bytes = write_(chosen(choice), precision, {});
    return double(modelBytes(openAsset(bytes), bytes.size()));
}

// Components are not all of the bytes: vectors start at multiples of 16, and a cluster that loses its last component
// loses its units too. So how much is to be dropped is searched for.
Attempt Search::shrinkToBytes(const ComponentCosts& costs, Attempt whole, double bytes,
                              AssetPrecision precision) const {
    if (whole.model_bytes <= bytes) return whole;
    constexpr int kSteps = 10;
    double too_little = 0, enough = 2 * (whole.model_bytes - bytes);
    ComponentChoice best = dropForBytes(costs, enough);
    for (int step = 0; step < kSteps; ++step) {
        throwIfInterrupted();
        const double middle = (too_little + enough) / 2;
        ComponentChoice choice = dropForBytes(costs, middle);
        const bool fits = bytesOf(choice, precision) <= bytes;
        (fits ? enough : too_little) = middle;
        if (fits) best = std::move(choice);
    }
    return attempt(best, precision);
}

// Errors of dropping and of rounding are nearly orthogonal, so that their squares nearly add up. Smaller steps find
// the rest.
Attempt Search::shrinkToError(const ComponentCosts& costs, Attempt whole, double error,
                              AssetPrecision precision) const {
    double energy = error * error * whole.sums.signal - whole.sums.difference;
    for (int step = 0; step < 40 && energy > 0; ++step, energy *= 0.95) {
        Attempt result = attempt(dropForEnergy(costs, energy), precision);
        if (result.sums.relative() <= error) return result;
    }
    return whole;
}

std::optional<Packed> Search::within(const PackOptions& options, AssetPrecision precision,
                                     std::optional<BadOption>& refusal) const {
    const double vertices = double(whole_.mesh.vertexCount());
    ComponentCosts costs{energies_, componentBytes(openAsset(write_(ranked_, precision, {})))};
    costs.least.assign(energies_.size(), 1);
    // A residual may lose all of its components; its mean stays.
    std::fill(costs.least.begin() + std::ptrdiff_t(whole_.clusters.size()), costs.least.end(), 0);
    Attempt found = attempt(dropForBytes(costs, 0), precision);
    if (options.max_bytes_per_vertex)
        found = shrinkToBytes(costs, found, *options.max_bytes_per_vertex * vertices, precision);
    else if (options.max_error)
        found = shrinkToError(costs, found, *options.max_error, precision);
    else
        found = attempt(dropForEnergy(costs, kNegligibleEnergy * found.sums.signal), precision);
    if (options.max_bytes_per_vertex && found.model_bytes > *options.max_bytes_per_vertex * vertices)
        refusal.emplace("max_bytes_per_vertex", "with one component a cluster the model takes " +
                                                    figure(found.model_bytes / vertices) + " at precision " +
                                                    nameOf(precision) + ", the bound is " +
                                                    figure(*options.max_bytes_per_vertex));
    else if (options.max_error && found.sums.relative() > *options.max_error)
        refusal.emplace("max_error",
                        std::string("precision ") + nameOf(precision) + " gives " + figure(found.sums.relative()) +
                            (options.max_bytes_per_vertex ? " within the bytes" : " with every component") +
                            ", the bound is " + figure(*options.max_error));
    else
        return finish(chosen(found.choice), found, precision);
    return {};
}

Packed Search::finish(const Model& model, const Attempt& found, AssetPrecision precision) const {
    Packed packed;
    packed.precision = precision;
    packed.quantization_error = found.sums.relative();
    packed.dropped_error = found.sums.signal > 0 ? std::sqrt(found.choice.dropped_energy / found.sums.signal) : 0;
    for (const ClusterModel* cluster : allClusters(model)) packed.components += cluster->components();
    packed.all_components = components_;
    packed.bytes = write_(model, precision, packed.quantization_error);
    return packed;
}

Packed Search::asItIs(AssetPrecision precision) const {
    Attempt all;
    if (precision != AssetPrecision::kF32) {
        const std::vector<std::byte> bytes = write_(whole_, precision, {});
        all.sums = comparePacked(openAsset(bytes), openAsset(exact_), threads_);
    }
    return finish(whole_, all, precision);
}

}  // namespace

Packed packWithin(const Model& model, const PackOptions& options, const WriteAsset& write, int threads) {
    Search search(model, write, threads);
    if (options.precision && !options.max_error && !options.max_bytes_per_vertex)
        return search.asItIs(*options.precision);
    search.rank();
    std::vector<AssetPrecision> candidates = {options.precision.value_or(AssetPrecision::kI8)};
    if (options.max_error && !options.precision)
        candidates = {AssetPrecision::kI8, AssetPrecision::kF16, AssetPrecision::kF32};
    std::optional<BadOption> first_refusal;
    for (AssetPrecision precision : candidates) {
        std::optional<BadOption> refusal;
        if (std::optional<Packed> found = search.within(options, precision, refusal)) return std::move(*found);
        if (!first_refusal || !options.max_bytes_per_vertex) first_refusal = refusal;
    }
    throw *first_refusal;
}

}  // namespace penumbra
