#include "fit/papers/lobes/lobe_maps.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "fit/numerics/cross_validation.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

// Weights to choose from (LobeProblem::ridge). Without any, two lobes come near each other with large coefficients of
// opposite sign, whose sum no linear model hits (NOTES.md).
constexpr std::array kRidges = {0.01, 0.03, 0.1, 0.3, 1.0, 3.0};

// Frames that a model learns from, frames that it is tested on, and the inputs of all frames, [F, I], which know of the
// former alone.
struct Trial {
    std::vector<std::size_t> train, tested;
    Matrix inputs;
};

// Returns one trial for each fold of the training frames, which is tested on a model of the others.
std::vector<Trial> trialsOf(const LobeSource& source) {
    const std::span<const std::size_t> train = source.train;
    const std::vector<int> folds = makeFolds(source.reader.header().frames, train);
    std::vector<Trial> trials(folds.empty() ? 0 : std::size_t(*std::ranges::max_element(folds)) + 1);
    for (std::size_t t = 0; t < trials.size(); ++t) {
        for (std::size_t f = 0; f < train.size(); ++f)
            (folds[f] == int(t) ? trials[t].tested : trials[t].train).push_back(train[f]);
        if (trials[t].train.empty()) continue;
        trials[t].inputs =
            componentsOfFrames(poseComponents(source.poses, trials[t].train, source.input_variance), source.poses);
    }
    std::erase_if(trials, [](const Trial& trial) { return trial.train.empty(); });
    return trials;
}

// Returns the squared error of a vertex' lobes in the frames that a trial is tested on.
double testedError(const Trial& trial, const LobeProblem& problem, const VertexLobes& lobes, const MatrixF& visibility,
                   std::size_t vertex) {
    const std::size_t n = problem.coefficients();
    const std::vector<float> map = fitPoseMap(trial.inputs, lobes.values, trial.train);
    std::vector<double> predicted(n);
    double error = 0;
    for (const std::size_t f : trial.tested) {
        evaluateLobes(problem.order, lobes.axes, map, trial.inputs.row(f), predicted);
        for (std::size_t i = 0; i < n; ++i) {
            const double difference = predicted[i] - double(visibility(f, vertex * n + i));
            error += difference * difference;
        }
    }
    return error;
}

}  // namespace

std::vector<std::uint32_t> sampleVertices(std::size_t vertices, std::size_t most) {
    const std::size_t step = std::max<std::size_t>(1, (vertices + most - 1) / most);
    std::vector<std::uint32_t> sampled;
    for (std::size_t v = 0; v < vertices; v += step) sampled.push_back(std::uint32_t(v));
    return sampled;
}

MatrixF readLobeCoefficients(const LobeSource& source, const std::vector<std::uint32_t>& vertices,
                             const NumberForm& form) {
    ClusterCoefficientsRequest request;
    request.convention = {BelowHorizon::kBlocked, source.order};
    request.frames = source.frames;
    request.vertices_of_cluster = std::span(&vertices, 1);
    request.form = &form;
    request.threads = source.threads;
    return std::move(readClusterCoefficients(source.reader, source.poses, request).front());
}

LobeMaps fitLobeMaps(const LobeProblem& problem, const MatrixF& visibility, const Matrix& inputs, int threads) {
    const std::size_t vertices = visibility.columns / problem.coefficients(), lobes = std::size_t(problem.lobes),
                      size = (inputs.columns + 1) * problem.valuesOfVertex();
    LobeMaps maps;
    maps.axes.resize(vertices * lobes);
    maps.weights.resize(vertices * size);
    std::vector<double> error(vertices), squares(vertices);
    parallelFor(vertices, threads, [&](std::size_t v) {
        throwIfInterrupted();
        const VertexLobes one = fitVertexLobes(problem, visibility, v);
        std::ranges::copy(one.axes, maps.axes.begin() + std::ptrdiff_t(v * lobes));
        std::ranges::copy(fitPoseMap(inputs, one.values, problem.train),
                          maps.weights.begin() + std::ptrdiff_t(v * size));
        error[v] = one.error;
        squares[v] = one.squares;
    });
    for (std::size_t v = 0; v < vertices; ++v) maps.error += error[v], maps.squares += squares[v];
    return maps;
}

void evaluateLobes(int order, std::span<const Vec3> axes, std::span<const float> weights,
                   std::span<const double> inputs, std::span<double> out) {
    std::array<double, std::size_t(kMaxVisibilityLobes) * (2 + kMaxOrder)> buffer;
    const std::span<double> values = std::span(buffer).first(axes.size() * (2 + std::size_t(order)));
    applyPoseMap(weights, inputs, values);
    lobesToVisibility(order, axes, values, out);
}

Matrix predictLobes(int order, int lobes, const LobeMaps& maps, const Matrix& inputs,
                    std::span<const std::size_t> frames, int threads) {
    const std::size_t n = std::size_t(order) * std::size_t(order), count = std::size_t(lobes),
                      vertices = maps.axes.size() / count, size = maps.weights.size() / vertices;
    Matrix predicted(frames.size(), vertices * n);
    parallelFor(vertices, threads, [&](std::size_t v) {
        for (std::size_t r = 0; r < frames.size(); ++r)
            evaluateLobes(order, std::span(maps.axes).subspan(v * count, count),
                          std::span(maps.weights).subspan(v * size, size), inputs.row(frames[r]),
                          predicted.row(r).subspan(v * n, n));
    });
    return predicted;
}

double chooseLobeRidge(const LobeSource& source, const MatrixF& visibility, int lobes) {
    const std::vector<Trial> trials = trialsOf(source);
    double best = kRidges.front(), least = INFINITY;
    for (const double ridge : kRidges) {
        const LobeProblem problem{source.order, lobes, ridge, source.train};
        std::vector<double> errors(visibility.columns / problem.coefficients());
        parallelFor(errors.size(), source.threads, [&](std::size_t v) {
            throwIfInterrupted();
            const VertexLobes one = fitVertexLobes(problem, visibility, v);
            for (const Trial& trial : trials) errors[v] += testedError(trial, problem, one, visibility, v);
        });
        double error = 0;
        for (const double e : errors) error += e;
        if (error < least) best = ridge, least = error;
    }
    return best;
}

FrameSpread spreadOver(const FrameSquares& squares, std::span<const std::size_t> frames) {
    std::vector<double> errors;
    for (const std::size_t f : frames)
        errors.push_back(squares.truth[f] > 0 ? std::sqrt(squares.error[f] / squares.truth[f]) : 0);
    FrameSpread spread;
    for (const double e : errors) spread.mean += e / double(errors.size());
    for (const double e : errors) spread.deviation += (e - spread.mean) * (e - spread.mean) / double(errors.size());
    spread.deviation = std::sqrt(spread.deviation);
    return spread;
}

}  // namespace penumbra
