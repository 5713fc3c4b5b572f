#pragma once
// Evaluates the linear models of transfer at run time: the angles of a pose in, the light that reaches each vertex out,
// or its transfer. Calls on different vertices may run at the same time.
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"
#include "runtime/papers/transfer_kernel.h"

namespace penumbra {

class TransferEvaluator {
public:
    // `asset` has transfer, and must outlive the evaluator with its bytes. Arrays of f32 are read where they lie;
    // others are decoded once. Copies share that.
    explicit TransferEvaluator(const AssetView& asset);

    // Replaces the fastest path of this processor, which is the default. Tests go through all of transferPaths().
    void usePath(const TransferPath& path) { path_ = path; }
    // `pose` has animation.pose_size numbers. Allocates nothing.
    void setPose(std::span<const float> pose);
    // Sums the maps over the coefficients of a light in the model frame, [any order squared]. Bands that the transfer
    // does not have count for nothing. The first call allocates; a light that is there already costs nothing.
    void setLight(std::span<const Vec3> sh);

    // Writes l . t of vertices [begin, end), out[v - begin]. Albedo / pi times that is the radiance. Needs setLight().
    void irradiance(std::size_t begin, std::size_t end, std::span<Vec3> out) const;
    // Writes the transfer of vertices [begin, end): numbers[v * stride + c] of all vertices, with zeros in the padding.
    void transfer(std::size_t begin, std::size_t end, std::size_t stride, std::span<float> coefficients) const;

private:
    struct Decoded {
        TransferView view;
        std::size_t vertices = 0;
        std::vector<float> weights, basis;  // empty where the asset has f32
    };
    std::shared_ptr<const Decoded> decoded_;
    std::span<const float> weights_, basis_;
    std::vector<float> inputs_;              // [k + 1], the last is 1
    std::vector<float> scores_;              // [n / 4, m, 4] of a reduced model, padded to whole fours
    std::vector<Vec3> light_;                // of setLight()
    std::array<std::vector<float>, 3> lit_;  // [k + 1, m] the maps summed over the light
    std::array<float, 3> lit_mean_{};        // factors of the mean
    std::vector<float> lit_scores_;          // [m, 3] of a reduced model
    TransferPath path_;

    void scoreLight();
};

// Computes E [V] of transfer [V * stride]: 2 / sqrt(pi) times the first coefficient.
void transferAmbient(int stride, std::span<const float> transfer, std::span<float> e);

}  // namespace penumbra
