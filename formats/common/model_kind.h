#pragma once
// The kinds of model and of features that a model of visibility can have. The model file, the asset and the run time
// all use these types; formats/stage/model_file.h has the formulas.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "sh/pose_inputs.h"

namespace penumbra {

// The values are those of asset.fbs; formats/asset/asset_kinds.h checks that.
enum class FeatureKind : std::uint8_t { kJointAngles = 0, kRelativeBones = 1, kDihedrals = 2 };
enum class ModelKind : std::uint8_t { kLinear = 0, kQuadratic = 1, kNeural = 2, kAdditive = 3 };
inline constexpr std::array kModelKinds{ModelKind::kLinear, ModelKind::kQuadratic, ModelKind::kNeural,
                                        ModelKind::kAdditive};
inline constexpr std::array kFeatureKinds{FeatureKind::kJointAngles, FeatureKind::kRelativeBones,
                                          FeatureKind::kDihedrals};

// The words that files and command lines use.
constexpr const char* nameOf(ModelKind kind) {
    switch (kind) {
        case ModelKind::kLinear:
            return "linear";
        case ModelKind::kQuadratic:
            return "quadratic";
        case ModelKind::kNeural:
            return "neural";
        case ModelKind::kAdditive:
            return "additive";
    }
    return "";
}

constexpr const char* nameOf(FeatureKind features) {
    switch (features) {
        case FeatureKind::kJointAngles:
            return "joint-angles";
        case FeatureKind::kRelativeBones:
            return "relative-bones";
        case FeatureKind::kDihedrals:
            return "dihedral-angles";
    }
    return "";
}

// Returns the one of `kinds` (kModelKinds or kFeatureKinds) that has this name.
template <class Kinds>
constexpr std::optional<typename Kinds::value_type> kindNamed(const Kinds& kinds, std::string_view name) {
    for (const auto kind : kinds)
        if (name == nameOf(kind)) return kind;
    return std::nullopt;
}

// Returns how many inputs a group of an additive model has.
constexpr std::size_t groupInputs(FeatureKind features) {
    switch (features) {
        case FeatureKind::kJointAngles:
            return 3;
        case FeatureKind::kRelativeBones:
            return std::size_t(kBoneInputs);
        case FeatureKind::kDihedrals:
            return 1;
    }
    return 0;
}

// Returns how many groups the pose has: the bones, or triples of joint angles, or dihedral angles.
constexpr std::size_t groupCount(FeatureKind features, std::size_t joints, std::size_t pose_size) {
    return features == FeatureKind::kRelativeBones ? joints : pose_size / groupInputs(features);
}

// Returns how many numbers of the pose a cluster reads, before PCA. Every bone but the cluster's own gives its
// displacement (3) and its rotation (9).
constexpr std::size_t featureCount(FeatureKind features, std::size_t joints, std::size_t pose_size) {
    return features == FeatureKind::kRelativeBones ? 12 * (joints - 1) : pose_size;
}

// Returns how many units a quadratic model has: its inputs, their squares and their products.
constexpr std::size_t quadraticUnits(std::size_t inputs) { return inputs + inputs * (inputs + 1) / 2; }

}  // namespace penumbra
