#pragma once
// Holds the far parts of a composed asset to rays, on a sample of a check's vertices and frames.
#include <vector>

#include "formats/common/far_by_rays.h"
#include "formats/stage/visibility_file.h"
#include "runtime/evaluate/evaluator.h"

namespace penumbra {

// Squared errors of the true local visibility x the far parts, by fields and by rays.
struct FarSums {
    double by_fields = 0, by_rays = 0;
    std::size_t receivers = 0;

    void add(const FarSums& other) {
        by_fields += other.by_fields;
        by_rays += other.by_rays;
        receivers += other.receivers;
    }
};

// One frame of a check, in asset order.
struct FarFrame {
    std::span<const Vec3> positions, normals, tangents;  // [V]
    std::span<const float> truth, true_local;            // [V * stride] numbers of the convention
};

class FarCheck {
public:
    // `truth` has a skin and local moments. The sample is taken from the first `vertices` of the asset, and from each
    // of the lists of `frames`.
    FarCheck(const AssetView& asset, const VisibilityHeader& truth, std::size_t vertices,
             std::span<const std::vector<std::size_t>> frames);
    bool takes(std::size_t frame) const { return takes_[frame]; }
    std::size_t vertexCount() const { return vertices_.size(); }
    // The result is the same for any number of threads.
    FarSums compare(const Evaluator& posed, const FarFrame& frame, int threads) const;

private:
    const AssetView& asset_;
    PartRays rays_;
    std::vector<std::size_t> vertices_;
    std::vector<bool> takes_;

    FarSums compareVertex(const Evaluator& posed, const FarFrame& frame, std::size_t vertex) const;
};

}  // namespace penumbra
