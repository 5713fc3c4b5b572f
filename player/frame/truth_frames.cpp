#include "player/frame/truth_frames.h"

#include <cmath>

#include "formats/common/errors.h"
#include "player/papers/transfer/transfer_model.h"

namespace penumbra {

constexpr double kSameTime = 1e-6;  // seconds

void checkTruth(const AssetView& asset, const AssetView& truth) {
    if (!truth.has_truth) throw InvalidInput(truth.name + ": holds no baked frames; make it with penumbra-pack truth");
    if (truth.mesh.positions.size() != asset.mesh.positions.size())
        throw InvalidInput(truth.name + ": has " + std::to_string(truth.mesh.positions.size()) +
                           " vertices and the asset " + std::to_string(asset.mesh.positions.size()));
    if (truth.mesh.two_sided != asset.mesh.two_sided)
        throw InvalidInput(truth.name + (truth.mesh.two_sided ? ": is" : ": is not") + " two-sided, unlike the asset");
    const int needed = bandsOfTruth(asset, truth);
    if (truth.truth.order < needed)
        throw InvalidInput(truth.name + ": SH order " + std::to_string(truth.truth.order) + " is below " +
                           std::to_string(needed) + ", which the model needs");
}

std::optional<std::size_t> findTruthFrame(const AssetView& asset, const AssetView& truth, std::size_t frame) {
    for (const ClipView& clip : asset.animation.clips) {
        if (frame < clip.first_frame || frame >= clip.first_frame + clip.frame_count) continue;
        for (const ClipView& baked : truth.animation.clips) {
            const std::size_t number = frame - clip.first_frame;
            if (baked.name != clip.name || number >= baked.frame_count) continue;
            const std::size_t found = baked.first_frame + number;
            if (std::abs(truth.animation.times[found] - asset.animation.times[frame]) <= kSameTime) return found;
        }
    }
    return std::nullopt;
}

bool hasTruthOf(const AssetView& asset, const AssetView& truth, const ClipView& clip) {
    for (std::size_t number = 0; number < clip.frame_count; ++number)
        if (findTruthFrame(asset, truth, clip.first_frame + number)) return true;
    return false;
}

}  // namespace penumbra
