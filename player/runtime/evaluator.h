#pragma once
// Pose in, per-vertex visibility out: the library that engines link and the CPU statement of what the shaders compute.
// No GL, no files, no threads of its own: calls on different clusters or vertex ranges may run at the same time.
#include <span>
#include <vector>

#include "formats/asset_file.h"

namespace penumbra {

class Evaluator {
public:
    // `asset` (with has_model) and the bytes behind it must outlive the evaluator. Decodes the small regressors once.
    explicit Evaluator(const AssetView& asset);

    const AssetView& asset() const { return *asset_; }
    std::size_t vertexCount() const { return asset_->mesh.positions.size(); }
    std::size_t clusterCount() const { return asset_->model.clusters.size(); }

    // Features, regression: the scores y of every cluster and each cluster's rotation. `bones` has J skinning matrices;
    // `pose` P rotation vectors, or empty when the model reads bones only. Allocates nothing.
    void setPose(std::span<const Affine> bones, std::span<const float> pose);
    std::span<const float> scores(std::size_t cluster) const;  // [K]
    const Mat3& clusterRotation(std::size_t cluster) const;    // nearestRotation of the cluster joint's linear part

    // numbers[v * stride + i] for the cluster's vertices; `numbers` is the array of all vertices, V * stride floats.
    void evaluateCluster(std::size_t cluster, std::span<float> numbers) const;

    // Skinned positions, unit normals and unit tangents of vertices [begin, end); each output array is [V].
    // tangent = normalised(R_c t0 - N (N . R_c t0)); where that vanishes, any unit vector orthogonal to N.
    void skin(std::size_t begin, std::size_t end, std::span<Vec3> positions, std::span<Vec3> normals,
              std::span<Vec3> tangents) const;

private:
    const AssetView* asset_;
    struct Regressor {
        std::vector<float> combined;  // [K, N]: weights input_basis
        std::vector<float> offset;    // [K]: bias - combined feature_mean
        std::size_t first_score = 0;
    };
    std::vector<Regressor> regressors_;
    std::vector<int> cluster_of_vertex_;
    std::vector<Affine> bones_;
    std::vector<Mat3> rotations_;  // [cluster]
    std::vector<float> scores_, features_;
};

// acc[i] += w * data[i], i < n: one component of a cluster; the paths that this processor can run, slowest first, and
// tests hold each to the first. PENUMBRA_NO_SIMD leaves only the portable one.
using AddScaledI8 = void (*)(const std::int8_t* data, float w, std::size_t n, float* acc);
using AddScaledF16 = void (*)(const std::uint16_t* data, float w, std::size_t n, float* acc);
using AddScaledF32 = void (*)(const float* data, float w, std::size_t n, float* acc);
struct EvaluatorPath {
    const char* name;
    AddScaledI8 add_i8;
    AddScaledF16 add_f16;
    AddScaledF32 add_f32;
};
std::span<const EvaluatorPath> evaluatorPaths();

}  // namespace penumbra
