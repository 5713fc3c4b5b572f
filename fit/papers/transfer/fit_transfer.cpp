// Fits the global linear models of transfer.
//
// Problem: predict the transfer of all V vertices, n coefficients each, from the A joint angles of a pose.
//
// Naive: one least squares problem with n V columns. It has n V A unknowns, 85 MB for the paper's first character, and
// all transfer of all frames lies in memory.
//
// Here: as the paper does, one map X^c a coefficient. The reduced models project the angles on k principal components
// and the vertices on m, where the rows that the second PCA sees are the V numbers of one coefficient in one frame. The
// same basis thus serves all coefficients. Transfer is read some vertices at a time, in a pass for each product.
//
// See docs/formulas.md, section 14.

#include "fit/papers/transfer/fit_transfer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fit/numerics/cross_validation.h"
#include "fit/numerics/eigen_map.h"
#include "fit/numerics/leading_components.h"
#include "fit/numerics/ridge_path.h"
#include "fit/papers/transfer/predict_transfer.h"
#include "fit/papers/transfer/transfer_source.h"
#include "fit/visibility/split_frames.h"
#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

using Eigen::Index;
using Rows = EigenRows<float>;

constexpr float kMinRange = 1e-5f;  // radians; an angle that changes by less is constant

// Reads all poses, of which the model keeps a copy for playback, and chooses the angles that change over the training
// frames.
Matrix readAngles(const VisibilityReader& reader, const std::string& file, const std::vector<std::size_t>& train,
                  TransferModel& model) {
    const auto pose_size = std::size_t(reader.header().pose_size);
    for (std::size_t f = 0; f < reader.header().frames.frameCount(); ++f) {
        throwIfInterrupted();
        const VisibilityFrame frame = reader.readPose(f);
        model.pose.insert(model.pose.end(), frame.pose.begin(), frame.pose.end());
        model.bones.insert(model.bones.end(), frame.bones.begin(), frame.bones.end());
    }
    MatrixF poses(train.size(), pose_size);
    for (std::size_t i = 0; i < train.size(); ++i)
        std::copy_n(model.pose.begin() + std::ptrdiff_t(train[i] * pose_size), pose_size, poses.row(i).begin());
    for (std::size_t c = 0; c < pose_size; ++c)
        if (asEigen(poses).col(Index(c)).maxCoeff() - asEigen(poses).col(Index(c)).minCoeff() > kMinRange)
            model.angles.push_back(std::uint32_t(c));
    if (model.angles.empty())
        throw InvalidInput(file + ": /frames/pose: all joint angles are constant over the " +
                           std::to_string(train.size()) + " training frames");
    Matrix angles(train.size(), model.angles.size());
    for (std::size_t i = 0; i < angles.rows; ++i)
        for (std::size_t c = 0; c < angles.columns; ++c) angles(i, c) = poses(i, model.angles[c]);
    return angles;
}

// The mean transfer of the training frames, and the Gram matrix of what is left: rows of one frame are the outputs of
// the regression.
struct OutputMoments {
    std::vector<float> mean;  // [V, n]
    Matrix gram;              // [frames, frames]
};

constexpr Index kGramTile = 64;

// Takes the mean over frames off every column of a coefficient's rows. Returns these means, [n, columns].
Rows centerFrames(MatrixF& block, std::size_t frames) {
    const std::size_t n = block.rows / frames;
    Rows mean(Index(n), Index(block.columns));
    for (std::size_t c = 0; c < n; ++c) {
        auto rows = asEigen(block).middleRows(Index(c * frames), Index(frames));
        mean.row(Index(c)) = rows.cast<double>().colwise().mean().cast<float>();
        rows.rowwise() -= mean.row(Index(c)).eval();
    }
    return mean;
}

// Adds the products of all pairs of frames.
void addFrameGram(const MatrixF& block, int threads, Matrix& gram) {
    const auto frames = Index(gram.rows);
    parallelFor(std::size_t((frames + kGramTile - 1) / kGramTile), threads, [&](std::size_t tile) {
        const Index first = Index(tile) * kGramTile, count = std::min(kGramTile, frames - first);
        for (Index at = 0; at < Index(block.rows); at += frames) {
            const auto rows = asEigen(block).middleRows(at, frames);
            const Rows product = rows.middleRows(first, count) * rows.topRows(first + count).transpose();
            asEigen(gram).block(first, 0, count, first + count) += product.cast<double>();
        }
    });
}

OutputMoments outputMoments(const TransferSource& source, int threads) {
    OutputMoments moments{{}, {source.frames(), source.frames()}};
    for (std::size_t b = 0; b < source.blockCount(); ++b) {
        throwIfInterrupted();
        MatrixF block = source.readBlock(b);
        const Rows mean = centerFrames(block, source.frames());
        for (Index v = 0; v < mean.cols(); ++v)
            for (Index c = 0; c < mean.rows(); ++c) moments.mean.push_back(mean(c, v));
        addFrameGram(block, threads, moments.gram);
    }
    auto gram = asEigen(moments.gram);
    for (Index i = 0; i < gram.rows(); ++i)
        for (Index j = 0; j < i; ++j) gram(j, i) = gram(i, j);
    return moments;
}

// What the choice of alpha needs beside the options.
struct RidgeProblem {
    const Matrix& angles;
    const Matrix& gram;  // of the centered outputs
    std::vector<int> folds;
    std::size_t components;  // of the angles
};

// Chooses alpha, and reports the cross-validated errors of the choice.
void chooseAlpha(const RidgeProblem& problem, const RidgeSvd& path, const TransferFitOptions& options,
                 TransferModel& model, TransferFitReport& report) {
    std::vector<double> alphas = alphaGrid(path.sigma[0]);
    if (options.prior) alphas = {*options.prior};
    const std::vector<double> loo = leaveOneOutErrors(path, problem.gram, alphas),
                              blocks =
                                  foldErrors(problem.angles, problem.gram, problem.folds, problem.components, alphas);
    const std::size_t best = strongestOfBest(options.cross_validation == CrossValidation::kBlocks ? blocks : loo);
    double variance = 0;
    for (std::size_t i = 0; i < problem.gram.rows; ++i) variance += problem.gram(i, i);
    const auto relative = [&](double error) { return variance > 0 ? std::sqrt(std::max(error, 0.0) / variance) : 0; };
    model.alpha = alphas[best];
    report.largest_singular_value = path.sigma[0];
    report.leave_one_out_error = relative(loo[best]);
    report.blocked_error = relative(blocks[best]);
}

// --- The full linear model ------------------------------------------------------------------------------------------

// X^c = v (s / (s^2 + alpha^2)) u^T B^c, and the bias that makes the mean of the inputs give the mean of B^c.
void setLinearWeights(const TransferSource& source, const RidgeSvd& path, int threads, TransferModel& model) {
    const auto n = Index(source.coefficients()), a = Index(model.angles.size()), frames = Index(source.frames()),
               vertices = Index(model.mesh.vertexCount());
    const Rows solve = (asEigen(path.v) * asEigen(weightsOperator(path, model.alpha))).cast<float>();
    const Eigen::RowVectorXf mean_angles = Eigen::Map<const Eigen::RowVectorXd>(path.mean.data(), a).cast<float>();
    model.weights.resize(std::size_t(n * (a + 1) * vertices));
    for (std::size_t b = 0; b < source.blockCount(); ++b) {
        throwIfInterrupted();
        MatrixF block = source.readBlock(b);
        const Rows mean = centerFrames(block, source.frames());
        const auto first = Index(source.firstVertex(b));
        parallelFor(std::size_t(n), threads, [&](std::size_t c) {
            Eigen::Map<Rows> map(model.weights.data() + Index(c) * (a + 1) * vertices, a + 1, vertices);
            const Rows x = solve * asEigen(block).middleRows(Index(c) * frames, frames);
            map.block(0, first, a, x.cols()) = x;
            map.row(a).segment(first, x.cols()) = mean.row(Index(c)) - mean_angles * x;
        });
    }
}

// --- The reduced models ---------------------------------------------------------------------------------------------

// The scores of the training frames, [frames, n m]: one row has those of all coefficients. Returns their mean.
Eigen::RowVectorXd centeredScores(const Matrix& stacked, std::size_t frames, Matrix& scores) {
    const std::size_t n = stacked.rows / frames, m = stacked.columns;
    scores = Matrix(frames, n * m);
    for (std::size_t c = 0; c < n; ++c)
        for (std::size_t i = 0; i < frames; ++i)
            std::copy_n(stacked.row(c * frames + i).begin(), m, scores.row(i).begin() + std::ptrdiff_t(c * m));
    const Eigen::RowVectorXd mean = asEigen(scores).colwise().mean();
    asEigen(scores).rowwise() -= mean;
    return mean;
}

void setPcaWeights(const RidgeSvd& path, const Matrix& scores, const Eigen::RowVectorXd& mean, TransferModel& model) {
    const auto n = Index(model.coefficients()), k = Index(path.sigma.size()), m = Index(model.outputs());
    const Rows x = (asEigen(weightsOperator(path, model.alpha)) * asEigen(scores)).cast<float>();  // [k, n m]
    // The mean of the angles goes into the bias too.
    const Eigen::RowVectorXd center =
        Eigen::Map<const Eigen::RowVectorXd>(path.mean.data(), Index(path.mean.size())) * asEigen(path.v);
    const Eigen::RowVectorXf bias = (mean - center * x.cast<double>()).cast<float>();
    model.weights.resize(std::size_t(n * (k + 1) * m));
    for (Index c = 0; c < n; ++c) {
        Eigen::Map<Rows> map(model.weights.data() + c * (k + 1) * m, k + 1, m);
        map.topRows(k) = x.middleCols(c * m, m);
        map.row(k) = bias.segment(c * m, m);
    }
}

// Sets the basis of the vertices, and returns the scores of the stacked rows.
Matrix reduceOutputs(const TransferSource& source, const TransferFitOptions& options, TransferModel& model,
                     TransferFitReport& report) {
    const ColumnBlocks blocks = source.blocks();
    const LeadingSpace space = leadingSpace(blocks, options.vertex_components, options.threads);
    LeadingComponents components = componentsIn(space, blocks, options.threads);
    double kept = 0;
    for (const double energy : space.energies) kept += energy;
    report.vertex_variance = space.total > 0 ? kept / space.total : 1;
    model.basis = std::move(components.basis.values);
    model.mean = std::move(components.mean);
    return std::move(components.scores);
}

double keptVariance(const Matrix& angles, const RidgeSvd& path) {
    const Eigen::RowVectorXd mean = asEigen(angles).colwise().mean();
    double kept = 0;
    for (const double sigma : path.sigma) kept += sigma * sigma;
    return kept / (asEigen(angles).rowwise() - mean).squaredNorm();
}

// --- Errors ---------------------------------------------------------------------------------------------------------

void measureErrors(const VisibilityReader& reader, const TransferSource& source, const OutputMoments& moments,
                   const TransferFitOptions& options, const FitObserver& observer, TransferFit& fit) {
    const FrameList& frames = reader.header().frames;
    const HemisphereNorm norm(options.order);
    std::vector<TransferSums> of_clip(frames.clip_names.size());
    TransferSums train, held_out;
    for (std::size_t f = 0; f < frames.frameCount(); ++f) {
        throwIfInterrupted();
        const VisibilityFrame frame = reader.readFrame(f);
        const TransferSums sums = compareTransfer(norm, predictTransfer(fit.model, frame.pose, options.threads),
                                                  source.ofFrame(frame), moments.mean, frame.normals, options.threads);
        of_clip[frames.clip[f]].add(sums);
        (isHeldOut(options.holdout, frames, f) ? held_out : train).add(sums);
        if (observer.progress) observer.progress(double(f + 1) / double(frames.frameCount()));
    }
    fit.report.train = errorsOf(train);
    fit.report.held_out = errorsOf(held_out);
    for (std::size_t c = 0; c < of_clip.size(); ++c) {
        const std::string& name = frames.clip_names[c];
        fit.report.clips.push_back({name, isHeldOut(options.holdout, name),
                                    of_clip[c].count / std::max<std::size_t>(reader.header().mesh.vertexCount(), 1),
                                    errorsOf(of_clip[c])});
    }
}

void describe(const VisibilityHeader& header, const TransferFitOptions& options, TransferModel& model) {
    model.order = options.order;
    model.kind = options.model;
    model.mesh = header.mesh;
    model.rest_normals = header.rest_normals;
    model.skin = *header.skin;
    model.frames = header.frames;
    model.pose_size = header.pose_size;
    model.input_names = header.input_names;
    model.holdout_clips = options.holdout;
}

void checkComponents(const std::string& file, const TransferFitOptions& options, std::size_t frames, std::size_t angles,
                     std::size_t vertices) {
    const auto refuse = [&](std::size_t count, const std::string& what) {
        throw BadOption("components", file + " has " + std::to_string(count) + " " + what);
    };
    if (options.pose_components > angles) refuse(angles, "joint angles that change");
    if (options.pose_components >= frames)
        refuse(frames, "training frames, and " + std::to_string(options.pose_components) +
                           " components of the angles need one more than that");
    if (options.vertex_components > vertices) refuse(vertices, "vertices");
    const std::size_t rows = frames * std::size_t(options.order) * std::size_t(options.order);
    if (options.vertex_components >= rows)
        refuse(rows, "rows of one frame and coefficient, and " + std::to_string(options.vertex_components) +
                         " components of the vertices need one more than that");
}

}  // namespace

void checkTransferFit(const VisibilityHeader& header, const std::string& file, const TransferFitOptions& options) {
    const bool transfer = header.quantity == kDiffuseTransfer;
    if (!transfer && header.quantity != kHemisphereVisibility)
        throw InvalidInput(file + ": quantity '" + header.quantity +
                           "': needs baked diffuse_transfer or hemisphere_visibility");
    const int needed = options.order + (transfer ? 0 : 1);
    if (header.order < needed)
        throw BadOption("order", std::to_string(options.order) + " needs " + header.quantity + " of order " +
                                     std::to_string(needed) + "; " + file + " has order " +
                                     std::to_string(header.order));
    if (!header.skin || header.pose_size == 0)
        throw InvalidInput(file + ": /frames/pose: these models need the joint angles of a skeleton");
    const std::size_t frames = splitFrames(header.frames, options.holdout).train.size();
    if (frames < 2) throw InvalidInput(file + ": one training frame; a fit needs at least two");
    if (options.model == TransferModelKind::kPca)
        checkComponents(file, options, frames, std::size_t(header.pose_size), header.mesh.vertexCount());
}

TransferFit fitTransfer(const VisibilityReader& reader, const std::string& file, const TransferFitOptions& options,
                        const FitObserver& observer) {
    checkTransferFit(reader.header(), file, options);
    const auto phase = [&](const char* name) {
        if (observer.phase) observer.phase(name);
    };
    const Split split = splitFrames(reader.header().frames, options.holdout);
    const bool pca = options.model == TransferModelKind::kPca;
    TransferFit fit;
    describe(reader.header(), options, fit.model);
    fit.report.train_frames = split.train.size();
    fit.report.held_out_frames = split.held_out.size();
    // 1. The angles, and their principal components.
    phase("read");
    const Matrix angles = readAngles(reader, file, split.train, fit.model);
    fit.report.constant_angles = std::size_t(reader.header().pose_size) - angles.columns;
    if (pca) checkComponents(file, options, split.train.size(), angles.columns, fit.model.mesh.vertexCount());
    const std::size_t most = pca ? options.pose_components : std::numeric_limits<std::size_t>::max();
    const RidgeSvd path = makeRidgeSvd(angles, most);
    if (pca && path.sigma.size() < most)
        throw BadOption("components", "the joint angles of " + file + " have only " +
                                          std::to_string(path.sigma.size()) + " principal components");
    fit.report.pose_variance = keptVariance(angles, path);
    // 2. The moments of the transfer over the training frames.
    phase("transfer");
    const TransferSource source(reader, options.order, split.train, options.indirect_channel);
    const OutputMoments moments = outputMoments(source, options.threads);
    const std::vector<int> folds = makeFolds(reader.header().frames, split.train);
    // 3. Alpha and the maps.
    if (pca) {
        phase("pca");
        Matrix scores;
        const Matrix stacked = reduceOutputs(source, options, fit.model, fit.report);
        const Eigen::RowVectorXd mean = centeredScores(stacked, split.train.size(), scores);
        Matrix gram(scores.rows, scores.rows);
        asEigen(gram) = asEigen(scores) * asEigen(scores).transpose();
        phase("regression");
        fit.model.pose_basis.resize(path.v.values.size());
        std::copy(path.v.values.begin(), path.v.values.end(), fit.model.pose_basis.begin());
        chooseAlpha({angles, gram, folds, most}, path, options, fit.model, fit.report);
        setPcaWeights(path, scores, mean, fit.model);
    } else {
        phase("regression");
        chooseAlpha({angles, moments.gram, folds, most}, path, options, fit.model, fit.report);
        setLinearWeights(source, path, options.threads, fit.model);
    }
    // 4. Errors of training frames and of held-out ones.
    phase("errors");
    measureErrors(reader, source, moments, options, observer, fit);
    return fit;
}

}  // namespace penumbra
