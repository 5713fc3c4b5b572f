#include "pack/packing_error.h"

#include <cmath>

#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "player/runtime/evaluator.h"

namespace penumbra {

double PackingSums::relative() const { return signal > 0 ? std::sqrt(difference / signal) : 0; }

namespace {

void addCluster(const ClusterView& exact, std::size_t stride, std::span<const float> a, std::span<const float> b,
                PackingSums& sums) {
    const auto* mean = reinterpret_cast<const float*>(exact.mean.data);
    const std::size_t first = exact.first_vertex * stride;
    for (std::size_t i = 0; i < exact.mean.count; ++i) {
        const double difference = double(a[first + i]) - b[first + i], signal = double(b[first + i]) - mean[i];
        sums.difference += difference * difference;
        sums.signal += signal * signal;
    }
}

}  // namespace

PackingSums comparePacked(const AssetView& packed, const AssetView& exact, int threads) {
    Evaluator evaluate_packed(packed), evaluate_exact(exact);
    const std::size_t stride = std::size_t(exact.model.stride), clusters = evaluate_exact.clusterCount();
    std::vector<float> a(evaluate_exact.vertexCount() * stride), b(a.size());
    std::vector<PackingSums> of_cluster(clusters);
    const AnimationView& animation = exact.animation;
    for (const ClipView& clip : animation.clips) {
        if (clip.held_out) continue;
        for (std::size_t f = clip.first_frame; f < clip.first_frame + std::size_t(clip.frame_count); ++f) {
            throwIfInterrupted();
            evaluate_packed.setPose(animation.bonesOf(f), animation.poseOf(f));
            evaluate_exact.setPose(animation.bonesOf(f), animation.poseOf(f));
            parallelFor(clusters, threads, [&](std::size_t c) {
                evaluate_packed.evaluateCluster(c, a);
                evaluate_exact.evaluateCluster(c, b);
                addCluster(exact.model.clusters[c], stride, a, b, of_cluster[c]);
            });
        }
    }
    PackingSums total;
    for (const PackingSums& sums : of_cluster) {
        total.difference += sums.difference;
        total.signal += sums.signal;
    }
    return total;
}

}  // namespace penumbra
