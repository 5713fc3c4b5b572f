#include "pack/compress/packing_error.h"

#include <cmath>

#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "runtime/evaluate/evaluator.h"

namespace penumbra {

double PackingSums::relative() const { return signal > 0 ? std::sqrt(difference / signal) : 0; }

std::vector<std::size_t> packingFrames(const AssetView& asset) {
    constexpr std::size_t kMax = 100;  // of a composed model
    std::vector<std::size_t> frames;
    for (const ClipView& clip : asset.animation.clips)
        for (std::size_t f = clip.first_frame; f < clip.first_frame + std::size_t(clip.frame_count); ++f)
            if (!clip.held_out) frames.push_back(f);
    if (!asset.model.composition || frames.size() <= kMax) return frames;
    for (std::size_t i = 0; i < kMax; ++i) frames[i] = frames[i * frames.size() / kMax];
    frames.resize(kMax);
    return frames;
}

namespace {

// Sums over the frames of one cluster. `sum` adds up each number of a composed model.
struct ClusterSums {
    PackingSums squares;
    std::vector<double> sum;  // [vertex_count * stride]
};

void addCluster(const ClusterView& exact, std::size_t stride, bool composed, std::span<const float> a,
                std::span<const float> b, ClusterSums& sums) {
    const auto* mean = reinterpret_cast<const float*>(exact.mean.data);
    const std::size_t first = exact.first_vertex * stride;
    if (composed) sums.sum.resize(exact.mean.count);
    for (std::size_t i = 0; i < exact.mean.count; ++i) {
        const double difference = double(a[first + i]) - b[first + i];
        const double signal = composed ? double(b[first + i]) : double(b[first + i]) - mean[i];
        sums.squares.difference += difference * difference;
        sums.squares.signal += signal * signal;
        if (composed) sums.sum[i] += signal;
    }
}

}  // namespace

PackingSums comparePacked(const AssetView& packed, const AssetView& exact, int threads) {
    Evaluator evaluate_packed(packed), evaluate_exact(exact);
    const std::size_t stride = std::size_t(exact.model.stride), clusters = evaluate_exact.clusterCount();
    const bool composed = evaluate_exact.composed();
    std::vector<float> a(evaluate_exact.vertexCount() * stride), b(a.size());
    std::vector<float> far(composed ? evaluate_exact.vertexCount() * kFarCoefficients : 0);
    std::vector<ClusterSums> of_cluster(clusters);
    const AnimationView& animation = exact.animation;
    const std::vector<std::size_t> frames = packingFrames(exact);
    for (const std::size_t f : frames) {
        throwIfInterrupted();
        evaluate_packed.setPose(animation.bonesOf(f), animation.poseOf(f));
        evaluate_exact.setPose(animation.bonesOf(f), animation.poseOf(f));
        parallelFor(clusters, threads, [&](std::size_t c) {
            if (composed) {  // both have the same far parts
                evaluate_exact.evaluateFar(c, far);
                evaluate_packed.composeCluster(c, far, a);
                evaluate_exact.composeCluster(c, far, b);
            } else {
                evaluate_packed.evaluateCluster(c, a);
                evaluate_exact.evaluateCluster(c, b);
            }
            addCluster(exact.model.clusters[c], stride, composed, a, b, of_cluster[c]);
        });
    }
    PackingSums total;
    for (const ClusterSums& sums : of_cluster) {
        total.difference += sums.squares.difference;
        total.signal += sums.squares.signal;
        for (double sum : sums.sum) total.signal -= sum * sum / double(frames.size());
    }
    return total;
}

}  // namespace penumbra
