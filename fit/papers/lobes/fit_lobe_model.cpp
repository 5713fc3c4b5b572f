// Fits lobes to every vertex and frame of a bake, and a linear map of the joint angles to the lobes of every vertex.
//
// Vertices are independent once the ridge is chosen, which takes a sample of them. So they are read and fitted in
// blocks, and the size of a block never changes the result.

#include "fit/papers/lobes/fit_lobe_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "fit/clusters/tangent_frames.h"
#include "fit/visibility/split_frames.h"
#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "formats/stage/same_character.h"

namespace penumbra {

namespace {

constexpr std::size_t kLobeBlockBytes = std::size_t(32) << 20;  // of numbers in memory at a time

// Adds the errors of some vertices' predictions in all frames.
void addErrors(const MatrixF& truth, const Matrix& predicted, std::span<const std::size_t> train,
               std::span<const float> ambient, FrameErrors& errors, FrameSquares& squares) {
    const std::vector<double> mean = meanOfRows(truth, train);
    for (std::size_t f = 0; f < truth.rows; ++f)
        for (std::size_t first = 0; first < truth.columns; first += ambient.size()) {
            double e = 0;
            for (std::size_t i = 0; i < ambient.size(); ++i) {
                const double number = double(truth(f, first + i)), error = predicted(f, first + i) - number,
                             about_mean = number - mean[first + i];
                e += double(ambient[i]) * error;
                errors.squared[f] += error * error;
                errors.variance[f] += about_mean * about_mean;
                squares.truth[f] += number * number;
            }
            errors.ambient[f] += std::abs(e);
        }
}

// Copies what the model keeps of the bake, and gives every vertex a tangent.
LobeModel startModel(const VisibilityHeader& header, const PoseTable& poses, const LobeFitOptions& options) {
    LobeModel model;
    model.order = options.order;
    model.lobes = std::size_t(options.lobes);
    model.mesh = header.mesh;
    model.rest_normals = header.rest_normals;
    model.skin = *header.skin;
    model.input_names = header.input_names;
    const VertexClusters clusters = clustersOf(model.mesh, poses, std::size_t(options.clusters), options.threads);
    model.cluster_of_vertex = clusters.cluster_of_vertex;
    model.joint_of_cluster = clusters.joint;
    model.rest_tangents = restTangents(model.mesh, model.rest_normals, clusters, options.threads);
    model.input_variance = options.input_variance;
    model.holdout_clips = options.holdout;
    return model;
}

// What the errors of all vertices add up to.
struct LobeSums {
    FrameErrors errors;
    FrameSquares squares;
    double left = 0, whole = 0;  // by the lobes before any regression

    explicit LobeSums(std::size_t frames) : errors(frames), squares{{}, std::vector<double>(frames)} {}
};

// Fits the vertices [first, first + count) and adds them to the model.
void fitBlock(const LobeSource& source, const LobeProblem& problem, const Matrix& inputs, std::size_t first,
              std::size_t count, LobeModel& model, LobeSums& sums) {
    std::vector<std::uint32_t> vertices(count);
    std::iota(vertices.begin(), vertices.end(), std::uint32_t(first));
    const MatrixF coefficients = readLobeCoefficients(source, vertices, kVisibilityForm);
    const LobeMaps maps = fitLobeMaps(problem, coefficients, inputs, source.threads);
    const std::vector<float> ambient = kVisibilityForm.ambient_weights({BelowHorizon::kBlocked, problem.order});
    addErrors(coefficients,
              predictLobes(problem.order, problem.lobes, maps, inputs, indices(inputs.rows), source.threads),
              problem.train, ambient, sums.errors, sums.squares);
    sums.left += maps.error;
    sums.whole += maps.squares;
    model.axes.insert(model.axes.end(), maps.axes.begin(), maps.axes.end());
    model.weights.insert(model.weights.end(), maps.weights.begin(), maps.weights.end());
}

LobeFitReport reportOf(LobeSums& sums, const Split& split, std::size_t vertices) {
    LobeFitReport report;
    report.train_frames = split.train.size();
    report.held_out_frames = split.held_out.size();
    report.fitted = sums.whole > 0 ? std::sqrt(sums.left / sums.whole) : 0;
    report.train = figuresOf(sums.errors, split.train, vertices);
    report.held_out = figuresOf(sums.errors, split.held_out, vertices);
    sums.squares.error = sums.errors.squared;
    report.train_spread = spreadOver(sums.squares, split.train);
    report.held_out_spread = spreadOver(sums.squares, split.held_out);
    return report;
}

}  // namespace

void checkLobeFit(const VisibilityHeader& header, const std::string& file, const LobeFitOptions& options) {
    if (header.quantity != "hemisphere_visibility")
        throw InvalidInput(file + ": quantity '" + header.quantity + "': a fit needs baked hemisphere_visibility");
    if (!header.skin) throw BadOption("model", file + " has no skeleton; lobes are linear in joint angles");
    if (options.order > header.order)
        throw BadOption("convention", "B" + std::to_string(options.order) + " needs moments of order " +
                                          std::to_string(options.order) + "; the file has order " +
                                          std::to_string(header.order));
    if (header.pose_size == 0) throw InvalidInput(file + ": /frames/pose: empty, but zh-lobes are read from it");
    if (std::size_t(options.clusters) > header.mesh.vertexCount())
        throw BadOption("clusters", std::to_string(options.clusters) + " is more than the " +
                                        std::to_string(header.mesh.vertexCount()) + " vertices");
    splitFrames(header.frames, options.holdout, options.train_frames);
}

LobeModelFit fitLobeModel(const VisibilityReader& reader, const LobeFitOptions& options, const FitObserver& observer) {
    const auto phase = [&](const char* name) {
        throwIfInterrupted();
        if (observer.phase) observer.phase(name);
    };
    const VisibilityHeader& header = reader.header();
    const std::size_t vertices = header.mesh.vertexCount(), frames = header.frames.frameCount();
    const Split split = splitFrames(header.frames, options.holdout, options.train_frames);
    // 1. Poses, their components, and the local frames.
    phase("poses");
    const PoseTable poses = readPoses(reader, PoseRequest{split.train, 0, 0, options.threads});
    phase("clusters");
    LobeModelFit fit{startModel(header, poses, options), {}};
    LobeModel& model = fit.model;
    const LobeSource source{
        reader,         poses,         {&model.rest_tangents, &model.cluster_of_vertex, model.joint_of_cluster},
        split.train,    options.order, options.input_variance,
        options.threads};
    const PoseComponents components = poseComponents(poses, split.train, options.input_variance);
    model.pose_mean = components.mean;
    model.pose_basis = components.basis;
    const Matrix inputs = componentsOfFrames(components, poses);
    // 2. The ridge, chosen with a sample of the vertices.
    phase("ridge");
    model.ridge =
        chooseLobeRidge(source, readLobeCoefficients(source, sampleVertices(vertices), kVisibilityForm), options.lobes);
    // 3. All vertices.
    phase("fit");
    const LobeProblem problem{options.order, options.lobes, model.ridge, split.train};
    const std::size_t block =
        std::max<std::size_t>(1, kLobeBlockBytes / (frames * problem.coefficients() * sizeof(double)));
    LobeSums sums(frames);
    for (std::size_t first = 0; first < vertices; first += block) {
        fitBlock(source, problem, inputs, first, std::min(block, vertices - first), model, sums);
        if (observer.progress) observer.progress(double(std::min(first + block, vertices)) / double(vertices));
    }
    fit.report = reportOf(sums, split, vertices);
    model.clip_errors = errorsByClip(sums.errors, header.frames, options.holdout, vertices);
    return fit;
}

std::vector<float> predictLobeValues(const LobeModel& model, std::span<const float> pose, int threads) {
    const std::size_t n = std::size_t(model.order) * std::size_t(model.order), vertices = model.mesh.vertexCount(),
                      size = (model.inputs() + 1) * model.valuesOfVertex();
    const std::vector<double> inputs = PoseComponents{model.pose_mean, model.pose_basis}.of(pose);
    std::vector<float> coefficients(vertices * n);
    constexpr std::size_t kBlock = 256;
    parallelFor((vertices + kBlock - 1) / kBlock, threads, [&](std::size_t block) {
        std::vector<double> one(n);
        for (std::size_t v = block * kBlock; v < std::min((block + 1) * kBlock, vertices); ++v) {
            evaluateLobes(model.order, std::span(model.axes).subspan(v * model.lobes, model.lobes),
                          std::span(model.weights).subspan(v * size, size), inputs, one);
            for (std::size_t i = 0; i < n; ++i) coefficients[v * n + i] = float(one[i]);
        }
    });
    return coefficients;
}

void checkCharacter(const LobeModel& model, const VisibilityHeader& header, const std::string& file) {
    checkSameCharacter({model.mesh, model.skin, model.input_names, model.pose_mean.size()}, header, file);
}

void predictFile(const LobeModel& model, const VisibilityReader& poses, const PredictionOutput& to) {
    const Convention convention{BelowHorizon::kBlocked, model.order};
    const LocalFrames frames{&model.rest_tangents, &model.cluster_of_vertex, model.joint_of_cluster};
    writePredictions(poses, model.order, predictedQuantity(convention), to, [&](const VisibilityFrame& frame) {
        return toModelFrame(convention, frames, frame.bones, frame.normals,
                            predictLobeValues(model, frame.pose, to.threads), to.threads);
    });
}

}  // namespace penumbra
