#include "fit/papers/compare/joint_sweep.h"

#include <algorithm>
#include <cmath>

#include "fit/papers/lobes/lobe_maps.h"
#include "fit/visibility/predict.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

constexpr std::size_t kMaxVertices = 1500, kBins = 8, kCurvePoints = 61;
constexpr double kMinTurn = 0.02;  // standard deviation in radians; joints that move less are left out

// E of up to kMaxVertices vertices, evenly spread over their indices.
struct AmbientTable {
    std::vector<std::uint32_t> vertices;
    Matrix ambient;  // [F, vertices]
};

AmbientTable readAmbient(const CompareInput& input, const CompareCharacter& character, const CompareOptions& options) {
    AmbientTable table;
    table.vertices = sampleVertices(input.reader.header().mesh.vertexCount(), kMaxVertices);
    ClusterCoefficientsRequest request = requestFor(character, options.referenceConvention(), options.threads);
    request.vertices_of_cluster = std::span(&table.vertices, 1);
    const MatrixF coefficients = std::move(readClusterCoefficients(input.reader, input.poses, request).front());
    const std::vector<float> weights = request.form->ambient_weights(request.convention);
    table.ambient = Matrix(coefficients.rows, table.vertices.size());
    for (std::size_t f = 0; f < coefficients.rows; ++f)
        for (std::size_t i = 0; i < coefficients.columns; ++i)
            table.ambient(f, i / weights.size()) += double(coefficients(f, i)) * weights[i % weights.size()];
    return table;
}

// Returns the bin of each frame: frames in the order of the angle, cut into kBins equal parts.
std::vector<std::size_t> binsOf(std::span<const double> angles) {
    std::vector<std::size_t> order = indices(angles.size()), bins(angles.size());
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return angles[a] < angles[b]; });
    for (std::size_t i = 0; i < order.size(); ++i) bins[order[i]] = i * kBins / order.size();
    return bins;
}

struct Explained {
    double between = 0, total = 0;  // weighted variance of the bins' means, and variance of all values
    double score() const { return total > 1e-12 ? between * between / total : 0; }
};

// Returns how much of the variance of the values a function of the bin explains.
Explained explainedBy(std::span<const std::size_t> bins, std::span<const double> values) {
    std::array<double, kBins> sums{}, counts{};
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        sums[bins[i]] += values[i];
        counts[bins[i]] += 1;
        sum += values[i];
        squares += values[i] * values[i];
    }
    const double n = double(values.size()), mean = sum / n;
    Explained out;
    out.total = squares / n - mean * mean;
    for (std::size_t b = 0; b < kBins; ++b)
        if (counts[b] > 0) out.between += sums[b] * sums[b] / counts[b] / n;
    out.between -= mean * mean;
    return out;
}

double deviation(std::span<const double> values) {
    double mean = 0, squares = 0;
    for (double v : values) mean += v / double(values.size());
    for (double v : values) squares += (v - mean) * (v - mean);
    return std::sqrt(squares / double(values.size()));
}

struct Choice {
    std::size_t joint = 0, column = 0;
    Explained explained;
};

// Returns the pair of joint and vertex with the largest score.
Choice choosePair(const CompareInput& input, const CompareCharacter& character, const AmbientTable& table,
                  std::span<const Vec3d> rotations) {
    const Skin& skin = input.poses.skin;
    const std::size_t joints = skin.jointCount();
    const std::vector<std::size_t>& train = character.train;
    Choice best;
    std::vector<double> angles(train.size()), values(train.size());
    for (std::size_t j = 0; j < joints; ++j) {
        throwIfInterrupted();
        if (skin.parents[j] < 0) continue;
        const Vec3d axis = principalTurn(rotations, joints, j, train);
        for (std::size_t i = 0; i < train.size(); ++i) angles[i] = dot(axis, rotations[train[i] * joints + j]);
        if (deviation(angles) < kMinTurn) continue;
        const std::vector<std::size_t> bins = binsOf(angles);
        for (std::size_t c = 0; c < table.vertices.size(); ++c) {
            for (std::size_t i = 0; i < train.size(); ++i) values[i] = table.ambient(train[i], c);
            const Explained explained = explainedBy(bins, values);
            if (explained.score() > best.explained.score()) best = {j, c, explained};
        }
    }
    return best;
}

}  // namespace

std::optional<JointSweep> findJointSweep(const CompareInput& input, const CompareCharacter& character,
                                         const CompareOptions& options) {
    if (input.poses.deforming) return std::nullopt;
    const Skin& skin = input.poses.skin;
    const std::size_t joints = skin.jointCount(), frames = input.poses.frameCount();
    // 1. Choose joint and vertex.
    const AmbientTable table = readAmbient(input, character, options);
    const std::vector<Vec3d> rotations = relativeRotations(input.poses, skin.parents);
    const Choice choice = choosePair(input, character, table, rotations);
    if (choice.explained.score() <= 0) return std::nullopt;
    // 2. Collect the baked points.
    JointSweep sweep;
    sweep.turn = makeJointTurn(input, character, int(choice.joint));
    sweep.joint_name = skin.joint_names[choice.joint];
    sweep.vertex = table.vertices[choice.column];
    sweep.explained = choice.explained.between / choice.explained.total;
    sweep.baked_held_out.assign(frames, false);
    for (std::size_t f : character.held_out) sweep.baked_held_out[f] = true;
    for (std::size_t f = 0; f < frames; ++f) {
        sweep.baked_angles.push_back(dot(sweep.turn.axis, rotations[f * joints + choice.joint]));
        sweep.baked_ambient.push_back(table.ambient(f, choice.column));
    }
    // 3. Spread the points of the curves over the range of baked angles.
    const auto [low, high] = std::minmax_element(sweep.baked_angles.begin(), sweep.baked_angles.end());
    for (std::size_t i = 0; i < kCurvePoints; ++i)
        sweep.angles.push_back(*low + (*high - *low) * double(i) / double(kCurvePoints - 1));
    return sweep;
}

std::vector<double> sweepAmbient(const CompareInput& input, const JointSweep& sweep, const Model& model) {
    const std::vector<float> weights = kVisibilityForm.ambient_weights(model.convention);
    const Predictor predictor(model);
    std::vector<double> ambient;
    for (double angle : sweep.angles) {
        throwIfInterrupted();
        const TurnedPose turned = poseAt(input, sweep.turn, angle);
        const Prediction prediction = predictor.predict(turned.bones, turned.pose);
        double sum = 0;
        for (std::size_t i = 0; i < weights.size(); ++i)
            sum += double(weights[i]) * prediction.coefficients[sweep.vertex * weights.size() + i];
        ambient.push_back(sum);
    }
    return ambient;
}

}  // namespace penumbra
