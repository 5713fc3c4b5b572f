#include "fit/compare/lobe_models.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "fit/light/light_lobes.h"
#include "fit/models/linear_model.h"
#include "fit/numerics/cross_validation.h"
#include "fit/numerics/pca.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "sh/brdf/phong_matrix.h"
#include "sh/zonal.h"

namespace penumbra {

namespace {

constexpr double kInputVariance = 0.9;  // paper 002 and 000
constexpr double kRidge = 1e-3;         // of the mean variance of an input
// Weights of the squares of a lobe's coefficients to choose from. Without any, two lobes come near each other with
// large coefficients of opposite sign, whose sum no linear model hits (NOTES.md).
constexpr std::array kLobeRidges = {1e-4, 1e-3, 1e-2, 1e-1};

// Numbers of the sampled vertices. F counts frames, V vertices, n numbers of a vertex.
struct ChosenVertices {
    int order = 0;
    std::size_t vertices = 0;
    Matrix visibility, cosine;  // [F, V n]
};

// Frames that a model learns from, frames that it is tested on, and the inputs of all frames, [F, I], which know of the
// former alone.
struct Trial {
    std::vector<std::size_t> train, tested;
    Matrix inputs;
};

// Returns the principal components of the joint angles of training frames, of all frames.
Matrix inputsOf(const PoseTable& poses, const std::vector<std::size_t>& train) {
    Matrix pose(poses.frameCount(), poses.pose_size);
    std::copy(poses.pose.begin(), poses.pose.end(), pose.values.begin());
    const std::vector<double> mean = meanOfRows(pose, train);
    Matrix rows(train.size(), pose.columns);
    for (std::size_t r = 0; r < rows.rows; ++r)
        for (std::size_t c = 0; c < rows.columns; ++c) rows(r, c) = pose(train[r], c) - mean[c];
    const Pca pca = principalComponents(rows);
    const Matrix basis = basisOf(pca, rows, componentsFor(pca, kInputVariance));
    Matrix inputs(pose.rows, basis.rows);
    for (std::size_t f = 0; f < pose.rows; ++f)
        for (std::size_t i = 0; i < basis.rows; ++i)
            for (std::size_t c = 0; c < pose.columns; ++c) inputs(f, i) += (pose(f, c) - mean[c]) * basis(i, c);
    return inputs;
}

// Reads the numbers of some vertices in all frames, [F, V n], in the order of the clusters.
Matrix readNumbers(const CompareInput& input, const CompareCharacter& character, const CompareOptions& options,
                   std::span<const std::vector<std::uint32_t>> sampled, const Convention& convention, Target target) {
    ClusterNumbersRequest request;
    request.convention = convention;
    request.frames = {&character.rest_tangents, &character.clusters.cluster_of_vertex, character.clusters.joint};
    request.vertices_of_cluster = sampled;
    request.target = target;
    request.threads = options.threads;
    const std::vector<MatrixF> numbers = readClusterNumbers(input.reader, input.poses, request);
    std::size_t columns = 0;
    for (const MatrixF& cluster : numbers) columns += cluster.columns;
    Matrix all(input.poses.frameCount(), columns);
    std::size_t first = 0;
    for (const MatrixF& cluster : numbers) {
        for (std::size_t f = 0; f < all.rows; ++f)
            for (std::size_t c = 0; c < cluster.columns; ++c) all(f, first + c) = double(cluster(f, c));
        first += cluster.columns;
    }
    return all;
}

ChosenVertices readSample(const CompareInput& input, const CompareCharacter& character, const CompareOptions& options) {
    ChosenVertices sample;
    sample.order = std::min(4, input.reader.header().order - 1);  // the cosine takes one band more
    const std::size_t all = input.reader.header().mesh.vertexCount(),
                      step = std::max<std::size_t>(1, (all + kLobeVertices - 1) / kLobeVertices);
    std::vector<std::vector<std::uint32_t>> sampled(character.clusters.vertices.size());
    for (std::size_t c = 0; c < sampled.size(); ++c)
        for (const std::uint32_t v : character.clusters.vertices[c])
            if (v % step == 0) sampled[c].push_back(v), ++sample.vertices;
    const Convention convention{BelowHorizon::kBlocked, sample.order};
    sample.visibility = readNumbers(input, character, options, sampled, convention, Target::kVisibility);
    sample.cosine = readNumbers(input, character, options, sampled, convention, Target::kCosineWeighted);
    return sample;
}

Matrix rowsOf(const Matrix& all, const std::vector<std::size_t>& rows) {
    Matrix out(rows.size(), all.columns);
    for (std::size_t r = 0; r < rows.size(); ++r)
        std::copy_n(all.row(rows[r]).begin(), all.columns, out.row(r).begin());
    return out;
}

// Trains on the training frames, and returns the predictions of the tested ones.
Matrix regress(const Trial& trial, const Matrix& outputs) {
    const Matrix train = rowsOf(trial.inputs, trial.train);
    double energy = 0;
    for (const double x : train.values) energy += x * x;
    const double alpha = std::sqrt(kRidge * energy / double(std::max<std::size_t>(1, train.columns)));
    const Ridge ridge = fitRidge(train, rowsOf(outputs, trial.train), std::max(alpha, 1e-12));
    return predict(ridge, rowsOf(trial.inputs, trial.tested));
}

HeldOutErrors errorsOf(const Matrix& predicted, const Matrix& all, const std::vector<std::size_t>& frames) {
    std::vector<double> errors;
    for (std::size_t r = 0; r < frames.size(); ++r) {
        double error = 0, whole = 0;
        for (std::size_t c = 0; c < all.columns; ++c) {
            const double truth = all(frames[r], c), difference = predicted(r, c) - truth;
            error += difference * difference;
            whole += truth * truth;
        }
        errors.push_back(whole > 0 ? std::sqrt(error / whole) : 0);
    }
    HeldOutErrors result;
    for (const double e : errors) result.mean += e / double(errors.size());
    for (const double e : errors) result.deviation += (e - result.mean) * (e - result.mean) / double(errors.size());
    result.deviation = std::sqrt(result.deviation);
    return result;
}

// Multiplies visibility by the cosine: M^1 of paper 003 for every vertex.
Matrix withCosine(const Matrix& visibility, int order) {
    const std::size_t n = std::size_t(coefficientCount(order));
    const std::vector<double> m = phongMatrix(1, order);
    Matrix out(visibility.rows, visibility.columns);
    for (std::size_t f = 0; f < out.rows; ++f)
        for (std::size_t first = 0; first < out.columns; first += n)
            for (std::size_t i = 0; i < n; ++i)
                for (std::size_t j = 0; j < n; ++j) out(f, first + i) += m[i * n + j] * visibility(f, first + j);
    return out;
}

// A lobe as numbers that are continuous near the axis of the vertex' mean: the direction in the tangent plane there (by
// the angle from it), then the zonal coefficients.
struct LobeChart {
    Vec3d axis, x, y;

    explicit LobeChart(Vec3d a) : axis(a) {
        x = normalized(cross(std::abs(a.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}, a));
        y = cross(a, x);
    }
    std::array<double, 2> of(Vec3d direction) const {
        const double u = dot(direction, x), v = dot(direction, y), sine = std::hypot(u, v),
                     angle = std::atan2(sine, dot(direction, axis));
        return sine > 0 ? std::array{u / sine * angle, v / sine * angle} : std::array{angle, 0.0};
    }
    Vec3d at(double u, double v) const {
        const double angle = std::hypot(u, v);
        return angle > 0 ? axis * std::cos(angle) + (x * u + y * v) * (std::sin(angle) / angle) : axis;
    }
};

std::vector<double> grey(std::span<const double> numbers) {
    std::vector<double> sh;
    for (const double number : numbers) sh.insert(sh.end(), 3, number);
    return sh;
}

// The lobes of one vertex in all frames as numbers, [F, lobes (2 + order)].
struct VertexLobes {
    std::vector<LobeChart> charts;
    Matrix numbers;
    double error = 0, whole = 0;  // squares of what the lobes leave, and of the visibility
};

VertexLobes fitVertex(const ChosenVertices& sample, std::size_t vertex, int count, double ridge,
                      const std::vector<std::size_t>& train) {
    const std::size_t n = std::size_t(coefficientCount(sample.order)), each = 2 + std::size_t(sample.order);
    // 1. The axes of the mean.
    std::vector<double> mean(n);
    for (const std::size_t f : train)
        for (std::size_t i = 0; i < n; ++i) mean[i] += sample.visibility(f, vertex * n + i) / double(train.size());
    const std::vector<Vec3d> axes =
        fitLobesFrom(sample.order, grey(mean), fitLobes(sample.order, grey(mean), count, LobeFit::kJoint).directions,
                     ridge)
            .directions;
    VertexLobes lobes;
    for (const Vec3d axis : axes) lobes.charts.emplace_back(axis);
    // 2. From there, those of every frame.
    lobes.numbers = Matrix(sample.visibility.rows, axes.size() * each);
    for (std::size_t f = 0; f < sample.visibility.rows; ++f) {
        const std::span<const double> v = sample.visibility.row(f).subspan(vertex * n, n);
        const LightLobesFit fit = fitLobesFrom(sample.order, grey(v), axes, ridge);
        double whole = 0;
        for (const double number : v) whole += number * number;
        lobes.error += fit.residual * fit.residual * whole;
        lobes.whole += whole;
        for (std::size_t d = 0; d < axes.size(); ++d) {
            const std::array<double, 2> place = lobes.charts[d].of(fit.directions[d]);
            lobes.numbers(f, d * each) = place[0];
            lobes.numbers(f, d * each + 1) = place[1];
            for (std::size_t l = 0; l < std::size_t(sample.order); ++l)
                lobes.numbers(f, d * each + 2 + l) = fit.coefficients[(d * std::size_t(sample.order) + l) * 3];
        }
    }
    return lobes;
}

// Adds the SH of predicted lobes to those of a vertex.
void addLobes(const std::vector<LobeChart>& charts, std::span<const double> numbers, int order, std::span<double> sh) {
    std::vector<double> one(sh.size());
    const std::size_t each = 2 + std::size_t(order);
    for (std::size_t d = 0; d < charts.size(); ++d) {
        const std::span<const double> lobe = numbers.subspan(d * each, each);
        rotateZonal(lobe.subspan(2), charts[d].at(lobe[0], lobe[1]), one);
        for (std::size_t i = 0; i < sh.size(); ++i) sh[i] += one[i];
    }
}

// The lobes of all vertices in all frames.
struct FittedLobes {
    double ridge = 0, error = 0;  // error: relative, before any regression
    std::vector<VertexLobes> vertices;
};

FittedLobes fitAll(const ChosenVertices& sample, const std::vector<std::size_t>& train, int count, double ridge,
                   int threads) {
    FittedLobes lobes{ridge, 0, std::vector<VertexLobes>(sample.vertices)};
    parallelFor(sample.vertices, threads, [&](std::size_t v) {
        throwIfInterrupted();
        lobes.vertices[v] = fitVertex(sample, v, count, ridge, train);
    });
    double error = 0, whole = 0;
    for (const VertexLobes& one : lobes.vertices) error += one.error, whole += one.whole;
    lobes.error = whole > 0 ? std::sqrt(error / whole) : 0;
    return lobes;
}

// Returns the visibility of predicted lobes, [tested frames, V n].
Matrix predictLobes(const ChosenVertices& sample, const FittedLobes& lobes, const Trial& trial, int threads) {
    const std::size_t n = std::size_t(coefficientCount(sample.order));
    Matrix predicted(trial.tested.size(), sample.vertices * n);
    parallelFor(sample.vertices, threads, [&](std::size_t v) {
        const Matrix numbers = regress(trial, lobes.vertices[v].numbers);
        for (std::size_t r = 0; r < numbers.rows; ++r)
            addLobes(lobes.vertices[v].charts, numbers.row(r), sample.order, predicted.row(r).subspan(v * n, n));
    });
    return predicted;
}

// Returns one trial for each fold of the training frames, which is tested on a model of the others.
std::vector<Trial> trialsOf(const CompareInput& input, const std::vector<std::size_t>& train) {
    const std::vector<int> folds = makeFolds(input.reader.header().frames, train);
    std::vector<Trial> trials(folds.empty() ? 0 : std::size_t(*std::ranges::max_element(folds)) + 1);
    for (std::size_t t = 0; t < trials.size(); ++t) {
        for (std::size_t f = 0; f < train.size(); ++f)
            (folds[f] == int(t) ? trials[t].tested : trials[t].train).push_back(train[f]);
        if (!trials[t].train.empty()) trials[t].inputs = inputsOf(input.poses, trials[t].train);
    }
    std::erase_if(trials, [](const Trial& trial) { return trial.train.empty(); });
    return trials;
}

double squaredError(const ChosenVertices& sample, const Matrix& predicted, const std::vector<std::size_t>& frames) {
    double error = 0;
    for (std::size_t r = 0; r < predicted.rows; ++r)
        for (std::size_t c = 0; c < predicted.columns; ++c) {
            const double difference = predicted(r, c) - sample.visibility(frames[r], c);
            error += difference * difference;
        }
    return error;
}

// Returns the lobes of the ridge whose models have the smallest error on folds that they have not seen. The lobes are
// those of each frame alone, so a fold's enter no model but by the axes of the mean from which all fits start.
FittedLobes chooseLobes(const ChosenVertices& sample, const std::vector<Trial>& trials,
                        const std::vector<std::size_t>& train, int count, int threads) {
    FittedLobes best;
    double least = INFINITY;
    for (const double ridge : kLobeRidges) {
        FittedLobes lobes = fitAll(sample, train, count, ridge, threads);
        double error = 0;
        for (const Trial& trial : trials)
            error += squaredError(sample, predictLobes(sample, lobes, trial, threads), trial.tested);
        if (error < least) best = std::move(lobes), least = error;
    }
    return best;
}

}  // namespace

LobeComparison compareLobes(const CompareInput& input, const CompareCharacter& character, const CompareOptions& options,
                            const std::function<void(double)>& progress) {
    const ChosenVertices sample = readSample(input, character, options);
    const Trial held_out{character.train, character.held_out, inputsOf(input.poses, character.train)};
    const std::vector<Trial> trials = trialsOf(input, character.train);
    LobeComparison comparison{sample.vertices, held_out.inputs.columns, sample.order, {}};
    const auto add = [&](std::string name, double fitted, double ridge, const Matrix& predicted) {
        comparison.models.push_back({std::move(name), fitted, ridge,
                                     errorsOf(predicted, sample.visibility, character.held_out),
                                     errorsOf(withCosine(predicted, sample.order), sample.cosine, character.held_out)});
    };
    add("SH", 0, 0, regress(held_out, sample.visibility));
    comparison.models.push_back({"SH x cosine",
                                 0,
                                 0,
                                 {NAN, NAN},
                                 errorsOf(regress(held_out, sample.cosine), sample.cosine, character.held_out)});
    for (std::size_t i = 0; i < options.lobes.size(); ++i) {
        if (progress) progress(double(i) / double(options.lobes.size()));
        const int count = options.lobes[i];
        const FittedLobes lobes = chooseLobes(sample, trials, character.train, count, options.threads);
        add(std::to_string(count) + (count == 1 ? " lobe" : " lobes"), lobes.error, lobes.ridge,
            predictLobes(sample, lobes, held_out, options.threads));
    }
    return comparison;
}

}  // namespace penumbra
