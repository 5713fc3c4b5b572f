#include "fit/papers/lobes/pose_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "fit/models/linear_model.h"
#include "fit/models/regressor.h"
#include "fit/numerics/pca.h"

namespace penumbra {

namespace {

constexpr double kPrior = 1e-3;  // alpha^2 of the regression, of the mean sum of squares of an input

}  // namespace

std::vector<double> PoseComponents::of(std::span<const float> pose) const {
    assert(pose.size() == mean.size());
    std::vector<double> inputs(count());
    for (std::size_t i = 0; i < inputs.size(); ++i)
        for (std::size_t c = 0; c < mean.size(); ++c)
            inputs[i] += (double(pose[c]) - double(mean[c])) * double(basis[i * mean.size() + c]);
    return inputs;
}

PoseComponents poseComponents(const PoseTable& poses, std::span<const std::size_t> train, double share) {
    Matrix pose(poses.frameCount(), poses.pose_size);
    std::copy(poses.pose.begin(), poses.pose.end(), pose.values.begin());
    const std::vector<double> mean = meanOfRows(pose, train);
    const Matrix rows = centeredRows(pose, train, mean);
    const Pca pca = principalComponents(rows);
    const Matrix basis = basisOf(pca, rows, componentsFor(pca, share));
    return {{mean.begin(), mean.end()}, {basis.values.begin(), basis.values.end()}};
}

Matrix componentsOfFrames(const PoseComponents& components, const PoseTable& poses) {
    Matrix inputs(poses.frameCount(), components.count());
    for (std::size_t f = 0; f < inputs.rows; ++f)
        std::ranges::copy(components.of(poses.poseOf(f)), inputs.row(f).begin());
    return inputs;
}

std::vector<float> fitPoseMap(const Matrix& inputs, const Matrix& outputs, std::span<const std::size_t> train) {
    const Matrix rows = selectRows(inputs, train);
    double energy = 0;
    for (const double x : rows.values) energy += x * x;
    const double alpha = std::sqrt(kPrior * energy / double(std::max<std::size_t>(1, rows.columns)));
    const Ridge ridge = fitRidge(rows, selectRows(outputs, train), std::max(alpha, 1e-12));
    std::vector<float> map(ridge.weights.values.begin(), ridge.weights.values.end());
    map.insert(map.end(), ridge.intercept.begin(), ridge.intercept.end());
    return map;
}

void applyPoseMap(std::span<const float> map, std::span<const double> inputs, std::span<double> out) {
    assert(map.size() == (inputs.size() + 1) * out.size());
    const std::span<const float> bias = map.last(out.size());
    std::ranges::copy(bias, out.begin());
    for (std::size_t i = 0; i < inputs.size(); ++i)
        for (std::size_t k = 0; k < out.size(); ++k) out[k] += inputs[i] * double(map[i * out.size() + k]);
}

}  // namespace penumbra
