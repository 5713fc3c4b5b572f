#include "fit/papers/compare/compare_grid.h"

#include <algorithm>
#include <cstdio>

#include "fit/papers/compare/cosine_product.h"
#include "fit/papers/compare/paper_forms.h"
#include "fit/visibility/predict.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

using std::chrono::steady_clock;

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

// Returns the median time of a prediction over frames spread over the file.
double evaluationMilliseconds(const Model& model, const PoseTable& poses) {
    constexpr std::size_t kFrames = 9;
    const Predictor predictor(model);
    std::vector<double> times;
    for (std::size_t i = 0; i < kFrames; ++i) {
        throwIfInterrupted();
        const std::size_t f = i * (poses.frameCount() - 1) / (kFrames - 1);
        const steady_clock::time_point start = steady_clock::now();
        predictor.predict(poses.bonesOf(f), poses.poseOf(f));
        times.push_back(1000 * secondsSince(start));
    }
    return median(times);
}

// Tells whether the fit is one of figure 8 that predicts visibility, and the file has the moments to measure against.
bool takesCosineProduct(const FitOptions& options, int file_order) {
    return options.form == &kUnclampedForm && options.convention.below == BelowHorizon::kOpen &&
           options.convention.order < file_order;
}

}  // namespace

FitOptions referenceFit(const CompareOptions& options, ModelKind model, FeatureKind features) {
    FitOptions fit;
    fit.model = model;
    fit.features = features;
    fit.clusters = options.referenceClusters();
    fit.parts = options.parts;
    fit.output_variance = options.referenceVariance();
    fit.convention = options.referenceConvention();
    fit.holdout = options.holdout;
    fit.threads = options.threads;
    return fit;
}

FitOptions mirroredAdditiveFit(const CompareOptions& options, int file_order) {
    FitOptions fit = referenceFit(options, ModelKind::kAdditive, FeatureKind::kRelativeBones);
    const auto mirrored = std::find_if(options.conventions.begin(), options.conventions.end(),
                                       [](const Convention& c) { return c.below == BelowHorizon::kMirrored; });
    fit.convention = mirrored != options.conventions.end()
                         ? *mirrored
                         : Convention{BelowHorizon::kMirrored, std::min(Convention().order, file_order)};
    return fit;
}

FitOptions composedFit(const CompareOptions& options, int file_order) {
    FitOptions fit = mirroredAdditiveFit(options, file_order);
    fit.fields = options.fields;
    return fit;
}

Convention paperConvention(const CompareOptions& options, int file_order) {
    return {BelowHorizon::kOpen, std::min(options.referenceConvention().order, std::max(file_order - 1, 1))};
}

bool compressesWithoutPrior(ModelKind model) { return model == ModelKind::kNeural || model == ModelKind::kAdditive; }

std::vector<FitOptions> makeGrid(const CompareOptions& options, int file_order) {
    std::vector<FitOptions> grid;
    const auto add = [&](FitOptions fit, const std::function<void(FitOptions&)>& change) {
        change(fit);
        if (std::none_of(grid.begin(), grid.end(), [&](const FitOptions& other) { return sameFit(fit, other); }))
            grid.push_back(fit);
    };
    for (ModelKind model : options.models)
        for (FeatureKind features : options.features) {
            const FitOptions reference = referenceFit(options, model, features);
            // 1. The reference, and fits that differ from it in one thing.
            add(reference, [](FitOptions&) {});
            if (compressesWithoutPrior(model)) add(reference, [](FitOptions& fit) { fit.prior = false; });
            for (int clusters : options.clusters) add(reference, [=](FitOptions& fit) { fit.clusters = clusters; });
            for (double share : options.output_variances)
                add(reference, [=](FitOptions& fit) { fit.output_variance = share; });
            for (Convention convention : options.conventions)
                add(reference, [=](FitOptions& fit) { fit.convention = convention; });
            // 2. Fits as in figures 8 and 9 of Nowrouzezahrai 2009.
            FitOptions paper = reference;
            paper.convention = paperConvention(options, file_order);
            paper.form = &kUnclampedForm;
            add(paper, [](FitOptions&) {});
            if (paper.convention.order < file_order) add(paper, [](FitOptions& fit) { fit.form = &kCosineForm; });
            add(paper, [](FitOptions& fit) { fit.form = &kModelFrameForm; });
        }
    if (options.fields.empty()) return grid;
    // 3. The composed model, and what it is compared with.
    add(mirroredAdditiveFit(options, file_order), [](FitOptions&) {});
    add(composedFit(options, file_order), [](FitOptions&) {});
    return grid;
}

bool sameFit(const FitOptions& a, const FitOptions& b) {
    return a.model == b.model && a.features == b.features && a.clusters == b.clusters &&
           a.output_variance == b.output_variance && a.convention == b.convention && a.form == b.form &&
           a.prior == b.prior && a.fields.empty() == b.fields.empty();
}

std::string wordsOf(FeatureKind features) {
    std::string words = nameOf(features);
    std::ranges::replace(words, '-', ' ');
    return words;
}

std::string labelOf(ModelKind model, FeatureKind features) {
    return std::string(nameOf(model)) + ", " + wordsOf(features);
}

std::string labelOf(const FitOptions& fit) {
    if (fit.fields.empty()) return labelOf(fit.model, fit.features);
    return std::string("composed, ") + nameOf(fit.model) + ", " + fit.convention.name();
}

std::string describe(const FitOptions& fit) {
    char numbers[64];
    std::snprintf(numbers, sizeof numbers, ", %d cluster%s, %g, ", fit.clusters, fit.clusters == 1 ? "" : "s",
                  fit.output_variance);
    return (fit.fields.empty() ? "" : "composed, ") + labelOf(fit.model, fit.features) + numbers +
           fit.convention.name() + (fit.form == &kCosineForm ? ", cosine-weighted" : "") +
           (fit.form == &kModelFrameForm ? ", model frame" : "") + (fit.form->clamp ? "" : ", not clamped") +
           (fit.prior ? "" : ", no prior");
}

double secondsSince(steady_clock::time_point start) {
    return std::chrono::duration<double>(steady_clock::now() - start).count();
}

std::size_t numberCount(const Model& model) {
    std::size_t count = 0;
    for (const ClusterModel& cluster : model.clusters) count += cluster.numberCount();
    if (model.composition)
        for (const ClusterModel& cluster : model.composition->residual) count += cluster.numberCount();
    return count;
}

CompareFit runFit(const CompareInput& input, const FitOptions& options, const JointSweep* sweep,
                  const std::function<void(double)>& progress) {
    const steady_clock::time_point start = steady_clock::now();
    const FitResult result = fitVisibility(input.reader, input.poses, input.file, options, {{}, progress});
    CompareFit fit;
    fit.fit_seconds = secondsSince(start);
    fit.options = options;
    fit.report = result.report;
    fit.clip_errors = result.model.clip_errors;
    fit.clusters = result.model.clusters.size();
    for (const ClusterModel& cluster : result.model.clusters) {
        fit.inputs += double(cluster.inputs()) / double(fit.clusters);
        fit.components += double(cluster.components()) / double(fit.clusters);
        fit.units += double(cluster.units()) / double(fit.clusters);
    }
    const double field_bytes = result.model.composition ? double(result.model.composition->fields.byteCount()) : 0.0;
    fit.bytes_per_vertex =
        (4 * double(numberCount(result.model)) + field_bytes) / double(result.model.mesh.vertexCount());
    fit.evaluate_milliseconds = evaluationMilliseconds(result.model, input.poses);
    if (takesCosineProduct(options, input.reader.header().order))
        fit.cosine_product_error = cosineProductError(input, result.model, options.threads);
    if (sweep) fit.turn_ambient = sweepAmbient(input, *sweep, result.model);
    return fit;
}

}  // namespace penumbra
