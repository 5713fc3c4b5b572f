#include "player/shot.h"

#include <algorithm>
#include <cmath>

#include "formats/errors.h"

namespace penumbra {

// The element of `list` called `name`, else the only one whose name begins so ("ggx" for "ggx:alpha=0.3"), or the
// first for "".
template <class T>
static const T& findByName(const AssetView& asset, const std::vector<T>& list, const std::string& name,
                           const std::string& option) {
    if (list.empty())
        throw InvalidInput(asset.name + ": holds no " + option + "; give penumbra-pack asset one with --" + option);
    if (name.empty()) return list.front();
    const T* beginning = nullptr;
    int beginnings = 0;
    std::string known;
    for (const T& element : list) {
        if (element.name == name) return element;
        known += (known.empty() ? "" : ", ") + std::string(element.name);
        if (!element.name.starts_with(name)) continue;
        beginning = &element;
        ++beginnings;
    }
    if (beginnings == 1) return *beginning;
    throw UsageError("--" + option + ": the asset has " + (beginnings == 0 ? "no" : "more than one") + " \"" + name +
                     "\"; it has " + known);
}

static const ClipView* findClip(const AnimationView& animation, std::string_view name) {
    for (const ClipView& clip : animation.clips)
        if (clip.name == name) return &clip;
    return nullptr;
}

// The truth's frame of the same clip and number; its time must be the same too.
static std::size_t truthFrame(const AssetView& asset, const AssetView& truth, const ClipView& clip,
                              std::size_t number) {
    const ClipView* baked = findClip(truth.animation, clip.name);
    if (!baked) throw InvalidInput(truth.name + ": has no clip \"" + std::string(clip.name) + "\"");
    if (number >= baked->frame_count)
        throw InvalidInput(truth.name + ": has " + std::to_string(baked->frame_count) + " frames of clip \"" +
                           std::string(clip.name) + "\", so none of number " + std::to_string(number));
    const std::size_t frame = baked->first_frame + number;
    const double expected = asset.animation.times[clip.first_frame + number], time = truth.animation.times[frame];
    if (std::abs(time - expected) > 1e-6)
        throw InvalidInput(truth.name + ": frame " + std::to_string(number) + " is at " + std::to_string(time) +
                           " s and the asset's at " + std::to_string(expected) + " s: they were sampled differently");
    return frame;
}

static void checkTruth(const AssetView& asset, const AssetView& truth) {
    if (!truth.has_truth) throw InvalidInput(truth.name + ": holds no baked frames; make it with penumbra-pack truth");
    if (truth.mesh.positions.size() != asset.mesh.positions.size())
        throw InvalidInput(truth.name + ": has " + std::to_string(truth.mesh.positions.size()) +
                           " vertices and the asset " + std::to_string(asset.mesh.positions.size()));
    if (truth.truth.order < asset.model.convention.order)
        throw InvalidInput(truth.name + ": SH order " + std::to_string(truth.truth.order) + " is below the model's, " +
                           asset.model.convention.name());
}

Shot resolveShot(const RenderOptions& options, const AssetView& asset, const AssetView* truth) {
    if (!asset.has_mesh || !asset.has_model)
        throw InvalidInput(asset.name + ": holds no model; make one with penumbra-pack asset");
    const bool needs_truth = options.channel == Channel::kError || options.source == VisibilitySource::kTruth;
    if (needs_truth && !truth)
        throw UsageError("--channel error and --source truth need --truth X.truth.pnb (penumbra-pack truth makes it)");

    Shot shot;
    shot.asset = &asset;
    const ClipView& clip = findByName(asset, asset.animation.clips, options.clip, "clip");
    if (std::size_t(options.frame) >= clip.frame_count)
        throw UsageError("--frame must be 0.." + std::to_string(clip.frame_count - 1) + " for clip \"" +
                         std::string(clip.name) + "\", not " + std::to_string(options.frame));
    shot.frame = clip.first_frame + std::size_t(options.frame);
    if (truth) {
        checkTruth(asset, *truth);
        shot.truth = truth;
        shot.truth_frame = truthFrame(asset, *truth, clip, std::size_t(options.frame));
    }
    if (options.channel == Channel::kShaded || !options.brdf.empty())
        shot.material = &findByName(asset, asset.materials, options.brdf, "brdf");
    if (options.channel == Channel::kShaded || !options.light.empty())
        shot.light = &findByName(asset, asset.lights, options.light, "light");
    return shot;
}

}  // namespace penumbra
