#include "fit/models/regressor.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "fit/models/trainers.h"
#include "fit/numerics/eigen_map.h"

namespace penumbra {

namespace {

constexpr double kMinGroupWeight = 0.003;  // relative to the largest group weight

// Keeps an input within its range over training frames, widened at both ends.
float clampedInput(float x, float least, float most) {
    const float margin = kRangeMargin * (most - least);
    return std::clamp(x, least - margin, most + margin);
}

// Returns the inputs of all groups, clamped to their ranges, [G, D]. Adds the weighted squares of what was cut off to
// `out_of_range`.
std::vector<float> groupInputs(const FeatureRecipe& recipe, const ClusterModel& cluster, std::span<const double> raw,
                               double& out_of_range) {
    const std::size_t size = groupInputs(recipe.kind);
    std::vector<float> inputs;
    std::vector<double> x(size);
    for (std::size_t g = 0; g < cluster.groups.size(); ++g) {
        readGroup(recipe, {cluster.joint, cluster.center}, cluster.groups[g], raw, x);
        for (std::size_t i = 0; i < size; ++i) {
            const float inside =
                std::clamp(float(x[i]), cluster.group_min[g * size + i], cluster.group_max[g * size + i]);
            out_of_range += double(cluster.group_weight[g]) * (x[i] - inside) * (x[i] - inside);
            inputs.push_back(inside);
        }
    }
    return inputs;
}

// Appends all products of two inputs, in the order of quadraticInputs().
std::vector<float> withProducts(std::vector<float> x) {
    const std::size_t inputs = x.size();
    for (std::size_t i = 0; i < inputs; ++i)
        for (std::size_t j = i; j < inputs; ++j) x.push_back(x[i] * x[j]);
    return x;
}

// Returns the tanh neurons' activations.
std::vector<float> neurons(const ClusterModel& cluster, std::span<const float> x) {
    std::vector<float> units;
    for (std::size_t h = 0; h < cluster.units(); ++h) {
        const float* row = cluster.hidden.data() + h * (x.size() + 1);
        float sum = row[x.size()];
        for (std::size_t i = 0; i < x.size(); ++i) sum += row[i] * x[i];
        units.push_back(std::tanh(sum));
    }
    return units;
}

// Returns the radial units of the additive model. Their factor sqrt(w_g) stands in the weights.
std::vector<float> additiveUnits(const ClusterModel& cluster, std::span<const float> inputs, std::size_t size) {
    std::vector<float> units;
    for (std::size_t h = 0; h < cluster.unit_group.size(); ++h) {
        const float* x = inputs.data() + cluster.unit_group[h] * size;
        float squared = 0;
        for (std::size_t i = 0; i < size; ++i) {
            const float d = x[i] - cluster.hidden[h * size + i];
            squared += d * d;
        }
        units.push_back(std::exp(-0.5f * squared));
    }
    return units;
}

}  // namespace

std::vector<float> pcaInputs(const ClusterModel& cluster, std::span<const double> raw) {
    std::vector<float> x;
    for (std::size_t i = 0; i < cluster.input_min.size(); ++i) {
        const float* row = cluster.input_basis.data() + i * raw.size();
        double sum = 0;
        for (std::size_t c = 0; c < raw.size(); ++c) sum += double(row[c]) * (raw[c] - double(cluster.feature_mean[c]));
        x.push_back(clampedInput(float(sum), cluster.input_min[i], cluster.input_max[i]));
    }
    return x;
}

RegressionErrors trainRegressor(ModelKind kind, const RegressionProblem& problem, ClusterModel& model) {
    assert(problem.prior || kind == ModelKind::kNeural || kind == ModelKind::kAdditive);
    switch (kind) {
        case ModelKind::kLinear:
            return trainRidge(problem, 1, model);
        case ModelKind::kQuadratic:
            return trainRidge(problem, 2, model);
        case ModelKind::kNeural:
            return trainNeural(problem, model);
        case ModelKind::kAdditive:
            return trainAdditive(problem, model);
    }
    return {};
}

void setGroups(const RegressionProblem& problem, ClusterModel& model) {
    const std::size_t size = groupInputs(problem.recipe.kind);
    const std::vector<double> all(problem.group_weights.begin(), problem.group_weights.end());
    const double largest = *std::max_element(all.begin(), all.end());
    std::vector<double> x(size);
    for (std::size_t g = 0; g < all.size(); ++g) {
        if (all[g] <= 0 || all[g] < kMinGroupWeight * largest) continue;
        std::vector<double> least(size, INFINITY), most(size, -INFINITY);
        for (std::size_t r : problem.train) {
            readGroup(problem.recipe, problem.place, g, problem.raw.row(r), x);
            for (std::size_t i = 0; i < size; ++i)
                least[i] = std::min(least[i], x[i]), most[i] = std::max(most[i], x[i]);
        }
        model.groups.push_back(std::uint32_t(g));
        model.group_weight.push_back(float(all[g]));
        model.group_min.insert(model.group_min.end(), least.begin(), least.end());
        model.group_max.insert(model.group_max.end(), most.begin(), most.end());
    }
}

ScoredPose scoreCluster(ModelKind kind, const FeatureRecipe& recipe, const ClusterModel& cluster,
                        std::span<const double> raw) {
    ScoredPose pose;
    // 1. The group inputs tell how far the pose is out of range, with every kind of model.
    const std::vector<float> groups = groupInputs(recipe, cluster, raw, pose.out_of_range);
    // 2. Compute the units of the model.
    std::vector<float> units;
    switch (kind) {
        case ModelKind::kLinear:
            units = pcaInputs(cluster, raw);
            break;
        case ModelKind::kQuadratic:
            units = withProducts(pcaInputs(cluster, raw));
            break;
        case ModelKind::kNeural:
            units = neurons(cluster, pcaInputs(cluster, raw));
            break;
        case ModelKind::kAdditive:
            units = additiveUnits(cluster, groups, groupInputs(recipe.kind));
            break;
    }
    // 3. Each score is a weighted sum of the units.
    for (std::size_t k = 0; k < cluster.components(); ++k) {
        double sum = cluster.bias[k];
        for (std::size_t h = 0; h < units.size(); ++h)
            sum += double(cluster.weights[k * units.size() + h]) * double(units[h]);
        pose.scores.push_back(float(sum));
    }
    return pose;
}

std::vector<float> sumOfComponents(const ClusterModel& cluster, std::span<const float> scores) {
    std::vector<float> sum = cluster.mean;
    for (std::size_t k = 0; k < scores.size(); ++k)
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += scores[k] * cluster.basis[k * sum.size() + i];
    return sum;
}

Matrix keptScores(const RegressionProblem& problem) {
    Matrix y(problem.train.size(), problem.components);
    const auto known = Eigen::Index(std::min(problem.components, problem.outputs.energies.size()));
    asEigen(y).leftCols(known) = asEigen(problem.outputs.scores).leftCols(known);
    return y;
}

}  // namespace penumbra
