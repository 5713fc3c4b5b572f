#pragma once
// A render's names resolved: which frame of which asset, under which light, of which material, seen from where.
#include "formats/asset/asset_file.h"
#include "player/frame/render_options.h"
#include "player/runtime/shading_set.h"

namespace penumbra {

struct Shot {
    const AssetView* asset = nullptr;  // with mesh and model
    std::size_t frame = 0;             // of asset->animation
    const AssetView* truth = nullptr;  // baked frames, may be null
    std::size_t truth_frame = 0;
    // For Channel::kShaded:
    bool shaded = false;
    ShadingChoice shading;
    std::vector<std::size_t> material_of_slot;  // as many as ShadingSet has
    std::size_t light = 0;
    Mat3 light_rotation;
};

// `truth` may be null. UsageError: an unknown name (the message lists the known ones), a frame beyond the clip's last,
// a truth that is needed and not given. InvalidInput: an asset without what the channel needs, a truth of another mesh
// or animation. The views must outlive the shot.
Shot resolveShot(const RenderOptions& options, const AssetView& asset, const AssetView* truth);

// Unsupported: a deforming mesh without the positions of its frames.
void requireFrames(const AssetView& asset);

// The same but for the frames, which stay 0.
Shot resolveLook(const RenderOptions& options, const AssetView& asset, const AssetView* truth);

// The shot's materials and light on; shot.shaded. The asset must outlive it.
ShadingSet shadingOf(const Shot& shot);

}  // namespace penumbra
