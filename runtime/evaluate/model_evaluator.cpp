#include "runtime/evaluate/model_evaluator.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>

#include "sh/pose_inputs.h"

namespace penumbra {

namespace {

std::vector<float> decoded(const NumbersView& numbers) {
    std::vector<float> out(numbers.count);
    decode(numbers, out);
    return out;
}

// Transposes [rows, columns] to [columns, rows], with the rows in the given order.
std::vector<float> transposedRows(std::span<const float> m, std::span<const std::size_t> rows, std::size_t columns) {
    std::vector<float> out(m.size());
    for (std::size_t r = 0; r < rows.size(); ++r)
        for (std::size_t c = 0; c < columns; ++c) out[c * rows.size() + r] = m[rows[r] * columns + c];
    return out;
}

std::vector<std::size_t> counting(std::size_t n) {
    std::vector<std::size_t> order(n);
    std::iota(order.begin(), order.end(), std::size_t{0});
    return order;
}

}  // namespace

ModelEvaluator::ModelEvaluator(const ModelView& model, const ClusterView& cluster)
    : kind_(model.kind),
      bones_(model.features == FeatureKind::kRelativeBones),
      group_size_(groupInputs(model.features)),
      inputs_(cluster.inputs()),
      units_(cluster.units),
      bias_(cluster.bias.begin(), cluster.bias.end()) {
    const std::size_t features = cluster.feature_mean.size();
    const std::vector<float> basis = decoded(cluster.input_basis);
    basis_ = transposedRows(basis, counting(inputs_), features);
    for (std::size_t i = 0; i < inputs_; ++i) {
        double sum = 0;  // in double, because the mean of a feature is large against its changes
        for (std::size_t n = 0; n < features; ++n) sum += double(basis[i * features + n]) * cluster.feature_mean[n];
        offset_.push_back(float(sum));
        const float margin = kRangeMargin * (cluster.input_max[i] - cluster.input_min[i]);
        input_least_.push_back(cluster.input_min[i] - margin);
        input_most_.push_back(cluster.input_max[i] + margin);
    }
    readGroups(model, cluster);
    readUnits(cluster);
}

void ModelEvaluator::readGroups(const ModelView& model, const ClusterView& cluster) {
    group_weight_.assign(cluster.group_weight.begin(), cluster.group_weight.end());
    group_min_ = decoded(cluster.group_min);
    group_max_ = decoded(cluster.group_max);
    for (std::uint16_t joint : cluster.groups) {
        Group& group = groups_.emplace_back();
        if (!bones_) {
            group.feature = group_size_ * joint;
            continue;
        }
        group.feature = 12 * std::size_t(joint - (int(joint) > cluster.joint ? 1 : 0));
        group.rest = (model.joint_centers[joint] - cluster.center) * (1 / model.feature_scale);
        group.spread = model.joint_spreads[joint];
        for (const InputJointView& input : model.input_joints)
            if (input.joint == int(joint)) group.absolute = input.absolute();
    }
}

// Sorts the units of an additive model by their group, so that a group's units stand together.
void ModelEvaluator::readUnits(const ClusterView& cluster) {
    std::vector<std::size_t> order = counting(units_);
    if (kind_ == ModelKind::kAdditive) {
        std::stable_sort(order.begin(), order.end(),
                         [&](std::size_t a, std::size_t b) { return cluster.unit_group[a] < cluster.unit_group[b]; });
        for (std::size_t h = 0; h < units_; ++h) {
            Group& group = groups_[cluster.unit_group[order[h]]];
            if (group.units++ == 0) group.first_unit = h;
        }
    }
    const std::vector<float> hidden = decoded(cluster.hidden), weights = decoded(cluster.weights);
    if (units_ > 0) hidden_ = transposedRows(hidden, order, hidden.size() / units_);
    weights_.resize(weights.size());
    for (std::size_t h = 0; h < units_; ++h)
        for (std::size_t k = 0; k < components(); ++k) weights_[h * components() + k] = weights[k * units_ + order[h]];
}

// Projects the features on the cluster's input PCA, and clamps to the training range.
void ModelEvaluator::pcaInputs(std::span<const float> features, std::span<float> x) const {
    for (std::size_t i = 0; i < inputs_; ++i) x[i] = -offset_[i];
    const float* row = basis_.data();
    for (float feature : features) {
        for (std::size_t i = 0; i < inputs_; ++i) x[i] += feature * row[i];
        row += inputs_;
    }
    for (std::size_t i = 0; i < inputs_; ++i) x[i] = std::clamp(x[i], input_least_[i], input_most_[i]);
}

// Computes a group's inputs and clamps them to the training range. Returns the square of what the clamp cut off.
float ModelEvaluator::clampedInputs(const Group& group, std::size_t index, std::span<const float> features,
                                    float* x) const {
    const float* raw = features.data() + group.feature;
    const std::size_t size = group_size_;
    if (group.absolute)
        std::fill(std::copy_n(raw, 3, x), x + size, 0.0f);
    else if (bones_)
        boneInputs(group.rest + Vec3{raw[0], raw[1], raw[2]},
                   Mat3{{raw[3], raw[4], raw[5], raw[6], raw[7], raw[8], raw[9], raw[10], raw[11]}}, group.spread, x);
    else
        std::copy_n(raw, size, x);
    const float *least = group_min_.data() + index * size, *most = group_max_.data() + index * size;
    float squared = 0;
    for (std::size_t i = 0; i < size; ++i) {
        const float inside = std::clamp(x[i], least[i], most[i]);
        squared += (x[i] - inside) * (x[i] - inside);
        x[i] = inside;
    }
    return squared;
}

// Returns the square of the distance out of range. An additive model has its units in the groups, so it evaluates
// them on the way: exp(-d^2 / 2) of the distance d from the unit's center (docs/formulas.md, section 4).
float ModelEvaluator::additiveUnits(std::span<const float> features, std::span<float> units) const {
    std::array<float, kBoneInputs> x;
    float out_of_range = 0;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        const Group& group = groups_[g];
        out_of_range += group_weight_[g] * clampedInputs(group, g, features, x.data());
        if (group.units == 0) continue;
        float* squared = units.data() + group.first_unit;
        std::fill_n(squared, group.units, 0.0f);
        const std::size_t size = hidden_.size() / units_;
        for (std::size_t i = 0; i < size; ++i) {
            const float* center = hidden_.data() + i * units_ + group.first_unit;
            for (std::size_t h = 0; h < group.units; ++h) {
                const float d = x[i] - center[h];
                squared[h] += d * d;
            }
        }
        for (std::size_t h = 0; h < group.units; ++h) squared[h] = std::exp(-0.5f * squared[h]);
    }
    return out_of_range;
}

// The units of the quadratic model are all x and all products x_i x_j, i <= j.
void ModelEvaluator::quadraticUnits(std::span<const float> x, std::span<float> units) const {
    std::size_t at = 0;
    for (float value : x) units[at++] = value;
    for (std::size_t i = 0; i < x.size(); ++i)
        for (std::size_t j = i; j < x.size(); ++j) units[at++] = x[i] * x[j];
}

// The units of the neural model are tanh(d . x + d0); the last row of `hidden_` has the d0.
void ModelEvaluator::neuralUnits(std::span<const float> x, std::span<float> units) const {
    const float* row = hidden_.data();
    std::copy_n(row + inputs_ * units_, units_, units.begin());
    for (std::size_t i = 0; i < inputs_; ++i, row += units_)
        for (std::size_t h = 0; h < units_; ++h) units[h] += x[i] * row[h];
    for (float& unit : units) unit = std::tanh(unit);
}

float ModelEvaluator::evaluate(std::span<const float> features, std::span<float> scratch,
                               std::span<float> scores) const {
    assert(scratch.size() >= scratchSize() && scores.size() == components());
    const std::span<float> x = scratch.first(inputs_), units = scratch.subspan(inputs_, units_);
    // 1. Group inputs first: they tell the distance from training with every model.
    const float out_of_range = additiveUnits(features, units);
    if (kind_ != ModelKind::kAdditive) pcaInputs(features, x);
    if (kind_ == ModelKind::kLinear) std::copy(x.begin(), x.end(), units.begin());
    if (kind_ == ModelKind::kQuadratic) quadraticUnits(x, units);
    if (kind_ == ModelKind::kNeural) neuralUnits(x, units);
    // 2. The scores are linear in the units, row by row, so that the inner loop runs over independent sums.
    std::copy(bias_.begin(), bias_.end(), scores.begin());
    const float* row = weights_.data();
    for (float unit : units) {
        for (std::size_t k = 0; k < scores.size(); ++k) scores[k] += unit * row[k];
        row += scores.size();
    }
    return out_of_range;
}

}  // namespace penumbra
