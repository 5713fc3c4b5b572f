// Fits and measures the linear models of transfer beside models of visibility.
//
// Problem: the paper's models predict transfer, in the model frame. Ours predict visibility, in local frames. Their own
// relative errors do not compare.
//
// Here: transfer is linear in visibility, t = integral of V cos y over the hemisphere, so every model is turned into
// transfer of the same order and compared with the same truth. The truth follows exactly from visibility of one order
// more. A difference has the same size in every frame of reference; only what it is divided by differs. In the model
// frame the variance about the mean of the training frames holds what a turn of the whole body changes. In local frames
// (the normal, and a tangent that the joint of the largest weight carries) it does not.

#include "fit/papers/compare/compare_transfer.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <tuple>

#include "fit/numerics/pca.h"
#include "fit/papers/transfer/predict_transfer.h"
#include "fit/papers/transfer/transfer_source.h"
#include "fit/visibility/predict.h"
#include "fit/visibility/split_frames.h"
#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "sh/cosine_product.h"
#include "sh/hemisphere_norm.h"
#include "sh/sh_rotation.h"
#include "sh/tangent.h"

namespace penumbra {

namespace {

using std::chrono::steady_clock;

constexpr std::size_t kTransferBlock = 256;    // vertices of a task
constexpr std::size_t kDecayComponents = 200;  // of the transfer that the eigenvalues are computed of
constexpr std::size_t kFewComponents = 100;    // of the vertices; a model of more is not fitted without prior too

// --- Models
// -----------------------------------------------------------------------------------------------------------

struct Contender : DirectModel {
    TransferRun run{};
};

TransferFitOptions fitOptions(const TransferCompareOptions& options, std::size_t model, bool regularised) {
    TransferFitOptions fit;
    fit.order = options.order;
    fit.model = model == 0 ? TransferModelKind::kLinear : TransferModelKind::kPca;
    if (model > 0) std::tie(fit.pose_components, fit.vertex_components) = options.components[model - 1];
    if (!regularised) fit.prior = 0;
    fit.holdout = options.holdout;
    fit.threads = options.threads;
    return fit;
}

std::string nameOfModel(const TransferFitOptions& fit) {
    if (fit.model == TransferModelKind::kLinear) return "L";
    return "PCA(" + std::to_string(fit.pose_components) + "," + std::to_string(fit.vertex_components) + ")";
}

// Milliseconds of the fastest of some frames.
double frameMilliseconds(const TransferModel& model) {
    const std::vector<float> pose(std::size_t(model.pose_size), 0.1f), light(3 * model.coefficients(), 0.5f);
    const LitTransfer lit = contractLight(model, light);
    std::vector<float> out(3 * model.mesh.vertexCount());
    double least = 1e9;
    for (int i = 0; i < 15; ++i) {
        const auto start = steady_clock::now();
        shadeTransfer(model, lit, pose, out);
        least = std::min(least, 1000 * secondsSince(start));
    }
    return least;
}

Contender fitPaperModel(const VisibilityReader& reader, const std::string& file, const TransferFitOptions& options,
                        bool regularised) {
    Contender made;
    made.fit = options;
    const steady_clock::time_point start = steady_clock::now();
    double fit_seconds = 0, pca_begins = 0, pca_ends = 0;
    FitObserver observer;
    observer.phase = [&](const char* name) {  // the phases are read, transfer, pca, regression and errors
        const std::string phase = name;
        if (phase == "pca") pca_begins = secondsSince(start);
        if (phase == "regression") pca_ends = secondsSince(start);
        if (phase == "errors") fit_seconds = secondsSince(start);
    };
    const auto model = std::make_shared<TransferModel>(fitTransfer(reader, file, options, observer).model);
    TransferRun& run = made.run;
    run.name = nameOfModel(options);
    run.regularised = regularised;
    run.alpha = model->alpha;
    run.bytes = paperBytes(*model);
    run.fit_seconds = fit_seconds;
    const double vertices = double(model->mesh.vertexCount());
    if (model->kind == TransferModelKind::kPca) {
        run.pca_seconds = pca_ends - pca_begins;
        run.megaops = 3 * vertices * double(model->outputs()) * 1e-6;
    } else {
        run.megaops = vertices * (3 * double(model->angles.size()) + 1) * 1e-6;
    }
    run.frame_ms = frameMilliseconds(*model);
    made.transfer = [model, threads = options.threads](const VisibilityFrame& frame) {
        return predictTransfer(*model, frame.pose, threads);
    };
    return made;
}

// Returns any rotation that takes z to the normal: a mirrored function and the cosine are turned by it alike.
Mat3 frameAbout(Vec3 normal) {
    const Vec3 axis = std::abs(normal.z) < 0.9f ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
    const Vec3 t = normalized(cross(axis, normal)), b = cross(normal, t);
    return {{t.x, b.x, normal.x, t.y, b.y, normal.y, t.z, b.z, normal.z}};
}

// Turns mirrored functions, [V, m] coefficients in the model frame, into transfer, [V, n].
std::vector<float> transferOf(std::span<const float> functions, int function_order, int order,
                              const std::vector<double>& matrix, std::span<const Vec3> normals, int threads) {
    const auto m = std::size_t(coefficientCount(function_order)), n = std::size_t(coefficientCount(order));
    std::vector<float> out(normals.size() * n);
    parallelFor((normals.size() + kTransferBlock - 1) / kTransferBlock, threads, [&](std::size_t block) {
        std::array<float, coefficientCount(kMaxOrder)> local, transfer;
        for (std::size_t v = block * kTransferBlock; v < std::min((block + 1) * kTransferBlock, normals.size()); ++v) {
            const Mat3 frame = frameAbout(normals[v]);
            applyTransposed(makeShRotation(function_order, frame), functions.subspan(v * m, m),
                            std::span(local).first(m));
            for (std::size_t i = 0; i < n; ++i) {
                double sum = 0;
                for (std::size_t j = 0; j < m; ++j) sum += matrix[i * m + j] * local[j];
                transfer[i] = float(sum);
            }
            apply(makeShRotation(order, frame), std::span<const float>(transfer).first(n),
                  std::span(out).subspan(v * n, n));
        }
    });
    return out;
}

Contender fitVisibilityModel(const VisibilityReader& reader, const std::string& file, const FitOptions& options,
                             int order) {
    Contender made;
    const auto start = steady_clock::now();
    const auto model = std::make_shared<Model>(fitVisibility(reader, file, options, {}).model);
    made.run.fit_seconds = secondsSince(start);
    made.run.of_paper = false;
    made.run.name = (model->composition ? "composed, " : "additive, ") + model->convention.name();
    made.run.bytes = numberCount(*model) * sizeof(float);
    const auto predictor = std::make_shared<Predictor>(*model);
    const VisibilityFrame first = reader.readPose(0);
    const auto clock = steady_clock::now();
    (void)predictor->predict(first.bones, first.pose);
    made.run.frame_ms = 1000 * secondsSince(clock);
    const std::vector<double> matrix = cosineMatrix(order, model->convention.order);
    made.model = model;
    made.transfer = [model, predictor, matrix, order, threads = options.threads](const VisibilityFrame& frame) {
        const Prediction found = predictor->predict(frame.bones, frame.pose);
        return transferOf(toModelFrame(*model, frame.bones, frame.normals, found.coefficients, threads),
                          model->convention.order, order, matrix, frame.normals, threads);
    };
    return made;
}

// --- The common measure
// -----------------------------------------------------------------------------------------------

// The true transfer in local frames, for the variance that relative errors are divided by.
class LocalTransfer {
public:
    LocalTransfer(const VisibilityHeader& header, int order) : order_(order) {
        const Skin& skin = *header.skin;
        const auto influences = std::size_t(skin.influences);
        for (std::size_t v = 0; v < header.rest_normals.size(); ++v) {
            joint_.push_back(skin.joints[v * influences]);  // weights descend
            tangent_.push_back(tangentOf(header.rest_normals[v], {}));
        }
    }
    std::vector<float> of(std::span<const float> transfer, const VisibilityFrame& frame, int threads) const {
        const auto n = std::size_t(coefficientCount(order_));
        const std::vector<Mat3> rotations = rotationsOf(frame.bones);
        std::vector<float> local(transfer.size());
        parallelFor((joint_.size() + kTransferBlock - 1) / kTransferBlock, threads, [&](std::size_t block) {
            for (std::size_t v = block * kTransferBlock; v < std::min((block + 1) * kTransferBlock, joint_.size());
                 ++v) {
                const Vec3 normal = frame.normals[v], t = tangentOf(normal, rotations[joint_[v]] * tangent_[v]);
                apply(makeShRotation(order_, fromRows(t, cross(normal, t), normal)), transfer.subspan(v * n, n),
                      std::span(local).subspan(v * n, n));
            }
        });
        return local;
    }

private:
    int order_;
    std::vector<std::uint16_t> joint_;
    std::vector<Vec3> tangent_;  // at rest
};

// Sums of the truth over frames, for its mean over training frames and its variance about that.
struct TruthSums {
    std::vector<double> sum;  // [V n]
    double squares = 0;
    std::size_t frames = 0;

    void add(std::span<const float> values) {
        sum.resize(values.size());
        for (std::size_t i = 0; i < values.size(); ++i) {
            sum[i] += double(values[i]);
            squares += double(values[i]) * values[i];
        }
        ++frames;
    }
    // sum |t - m|^2 = sum |t|^2 - 2 m . sum t + frames |m|^2.
    double varianceAbout(const TruthSums& training) const {
        double variance = squares;
        for (std::size_t i = 0; i < sum.size(); ++i) {
            const double mean = training.sum[i] / double(training.frames);
            variance += mean * (double(frames) * mean - 2 * sum[i]);
        }
        return variance;
    }
};

double rootRatio(double squares, double variance) { return variance > 0 ? std::sqrt(squares / variance) : 0; }

struct Measured {
    std::array<TransferSums, 2> sums;  // training, held out
};

// Measures all models on all frames. The frames are read once.
void measureAll(const VisibilityReader& reader, std::vector<Contender>& contenders, TransferComparison& comparison) {
    const TransferCompareOptions& options = comparison.options;
    const FrameList& frames = reader.header().frames;
    const TransferSource source(reader, options.order, {});
    const HemisphereNorm norm(options.order);
    const LocalTransfer local(reader.header(), options.order);
    std::array<TruthSums, 2> model_truth, local_truth;
    std::vector<Measured> measured(contenders.size());
    const std::vector<float> zeros(comparison.vertices * comparison.coefficients());
    for (std::size_t f = 0; f < frames.frameCount(); ++f) {
        throwIfInterrupted();
        const VisibilityFrame frame = reader.readFrame(f);
        const bool held_out = isHeldOut(options.holdout, frames, f);
        const std::vector<float> truth = source.ofFrame(frame);
        model_truth[held_out].add(truth);
        local_truth[held_out].add(local.of(truth, frame, options.threads));
        for (std::size_t i = 0; i < contenders.size(); ++i) {
            TransferRun& run = contenders[i].run;
            std::vector<float> predicted = contenders[i].transfer(frame);
            measured[i].sums[held_out].add(
                compareTransfer(norm, predicted, truth, zeros, frame.normals, options.threads));
            if (run.residuals && !held_out)
                for (std::size_t k = 0; k < truth.size(); ++k) run.residuals->add(double(predicted[k]) - truth[k]);
            if (f == comparison.pictured_frame && run.regularised) run.pictured = std::move(predicted);
        }
        if (f != comparison.pictured_frame) continue;
        comparison.truth = truth;
        comparison.positions = frame.positions;
        comparison.normals = frame.normals;
    }
    for (std::size_t i = 0; i < contenders.size(); ++i) {
        TransferRun& run = contenders[i].run;
        for (const bool held_out : {false, true}) {
            TransferSums sums = measured[i].sums[held_out];
            sums.variance = model_truth[held_out].varianceAbout(model_truth[0]);
            (held_out ? run.held_out : run.train) = errorsOf(sums);
            (held_out ? run.local_held_out : run.local_train) =
                rootRatio(sums.difference, local_truth[held_out].varianceAbout(local_truth[0]));
        }
        comparison.runs.push_back(std::move(run));
    }
    comparison.train_frames = model_truth[0].frames;
    comparison.held_out_frames = model_truth[1].frames;
}

// --- Eigenvalues
// ------------------------------------------------------------------------------------------------------

void findDecays(const VisibilityReader& reader, TransferComparison& comparison) {
    const TransferCompareOptions& options = comparison.options;
    const std::vector<std::size_t> train = splitFrames(reader.header().frames, options.holdout).train;
    Matrix poses(train.size(), std::size_t(reader.header().pose_size));
    std::vector<double> mean(poses.columns);
    for (std::size_t i = 0; i < train.size(); ++i) {
        const std::vector<float> pose = reader.readPose(train[i]).pose;
        for (std::size_t c = 0; c < pose.size(); ++c) mean[c] += (poses(i, c) = pose[c]) / double(train.size());
    }
    for (std::size_t i = 0; i < train.size(); ++i)
        for (std::size_t c = 0; c < poses.columns; ++c) poses(i, c) -= mean[c];
    const std::vector<double> energies = principalComponents(poses).energies;
    double total = 0;
    for (const double energy : energies) total += energy;
    comparison.pose_decay = {"joint angles", sharesOf(energies, total)};
    const TransferSource source(reader, options.order, train);
    const LeadingSpace space = leadingSpace(source.blocks(), kDecayComponents, options.threads);
    comparison.transfer_decay = {"transfer, a row a pose and coefficient", sharesOf(space.energies, space.total)};
}

}  // namespace

std::size_t middleHeldOutFrame(const FrameList& frames, const std::vector<std::string>& holdout) {
    const std::vector<std::size_t> held_out = splitFrames(frames, holdout).held_out;
    return held_out[held_out.size() / 2];
}

void Residuals::add(double residual) {
    const double at = (residual + kRange) / (2 * kRange) * double(kBins);
    count[std::size_t(std::clamp(at, 0.0, double(kBins) - 1))] += 1;
    sum += residual;
    squares += residual * residual;
    total += 1;
}

double Residuals::median() const {
    double below = 0;
    std::size_t bin = 0;
    while (bin + 1 < kBins && below + count[bin] < total / 2) below += count[bin++];
    return (double(bin) + 0.5) / double(kBins) * 2 * kRange - kRange;
}

void checkTransferComparison(const VisibilityHeader& header, const std::string& file,
                             const TransferCompareOptions& options, const BouncesBake* bounces) {
    std::vector<TransferFitOptions> fits;
    for (std::size_t model = 0; model <= options.components.size(); ++model)
        fits.push_back(fitOptions(options, model, true));
    for (const TransferFitOptions& fit : fits) checkTransferFit(header, file, fit);
    if (bounces) checkBounces(bounces->reader->header(), bounces->file, header.mesh, fits);
}

TransferComparison compareTransferModels(const VisibilityReader& reader, const std::string& file,
                                         const TransferCompareOptions& options, const BouncesBake* bounces,
                                         const std::function<void(const std::string&)>& phase) {
    const VisibilityHeader& header = reader.header();
    checkTransferComparison(header, file, options, bounces);
    TransferComparison comparison;
    comparison.options = options;
    comparison.vertices = header.mesh.vertexCount();
    comparison.angles = std::size_t(header.pose_size);
    comparison.frame_bytes = sizeof(float) * comparison.vertices * comparison.coefficients();
    comparison.pictured_frame = middleHeldOutFrame(header.frames, options.holdout);
    comparison.pictured_clip = header.frames.clip_names[header.frames.clip[comparison.pictured_frame]];
    phase("eigenvalues");
    findDecays(reader, comparison);
    std::vector<Contender> contenders;
    for (std::size_t model = 0; model <= options.components.size(); ++model)
        for (const bool regularised : {true, false}) {
            const TransferFitOptions fit = fitOptions(options, model, regularised);
            if (!regularised && model > 0 && fit.vertex_components > kFewComponents) continue;
            phase("fit: " + nameOfModel(fit) + (regularised ? "" : " without prior"));
            contenders.push_back(fitPaperModel(reader, file, fit, regularised));
            if (model == 0 && regularised) contenders.back().run.residuals.emplace();
        }
    if (header.quantity == kHemisphereVisibility) {
        phase("fit: additive");
        contenders.push_back(
            fitVisibilityModel(reader, file, mirroredAdditiveFit(options.visibility, header.order), options.order));
        if (!options.visibility.fields.empty()) {
            phase("fit: composed");
            contenders.push_back(
                fitVisibilityModel(reader, file, composedFit(options.visibility, header.order), options.order));
        }
    }
    std::vector<DirectModel> models;  // those of figure 7 have a prior
    for (const Contender& contender : contenders)
        if (contender.run.regularised)
            models.push_back({contender.run.name, contender.transfer, contender.fit, contender.model});
    phase("errors");
    measureAll(reader, contenders, comparison);
    if (bounces)
        comparison.bounces =
            compareBounces(*bounces->reader, bounces->file, models, options.order, options.threads, phase);
    return comparison;
}

}  // namespace penumbra
