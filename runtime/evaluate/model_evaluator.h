#pragma once
// Evaluates the model of one cluster at run time, whatever its kind (linear, quadratic, neural, additive): features of
// the pose in, scores out. formats/stage/model_file.h has the formulas. The stored numbers are decoded once and laid
// out so that inner loops run over independent sums. fit/models/ trains what is evaluated here.
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"

namespace penumbra {

class ModelEvaluator {
public:
    ModelEvaluator(const ModelView& model, const ClusterView& cluster);

    std::size_t components() const { return bias_.size(); }
    std::size_t scratchSize() const { return inputs_ + units_; }
    // Computes the scores. `features` are the raw features of the cluster's joint, or the pose. Returns the square of
    // how far they are out of the training range. Allocates nothing.
    float evaluate(std::span<const float> features, std::span<float> scratch, std::span<float> scores) const;

private:
    // The inputs that come from one bone, or from one joint of the pose.
    struct Group {
        std::size_t feature = 0;  // its first raw feature
        Vec3 rest;                // (center_j - center) / feature_scale
        Mat3 spread;
        bool absolute = false;                  // the joint stands for a number, so it has a position alone
        std::size_t first_unit = 0, units = 0;  // first_unit: after sorting by group
    };
    ModelKind kind_;
    bool bones_;  // groups are bones, not numbers of the pose
    std::size_t group_size_, inputs_, units_;
    std::vector<float> basis_, offset_;            // [N, I], [I]: x = basis^T raw - offset
    std::vector<float> input_least_, input_most_;  // [I], with the margin
    std::vector<Group> groups_;
    std::vector<float> group_weight_, group_min_, group_max_;  // [G], [G, D]
    std::vector<float> hidden_;                                // neural: [I + 1, H]; additive: [D, H]
    std::vector<float> weights_;                               // [H, K]
    std::vector<float> bias_;                                  // [K]

    void readGroups(const ModelView& model, const ClusterView& cluster);
    void readUnits(const ClusterView& cluster);
    void pcaInputs(std::span<const float> features, std::span<float> x) const;
    float clampedInputs(const Group& group, std::size_t index, std::span<const float> features, float* x) const;
    float additiveUnits(std::span<const float> features, std::span<float> units) const;
    void quadraticUnits(std::span<const float> x, std::span<float> units) const;
    void neuralUnits(std::span<const float> x, std::span<float> units) const;
};

}  // namespace penumbra
