#pragma once
// A render's names resolved: which frame of which asset, under which light, of which material, seen from where.
#include "formats/asset_file.h"
#include "player/render_options.h"

namespace penumbra {

struct Shot {
    const AssetView* asset = nullptr;  // with mesh and model
    std::size_t frame = 0;             // of asset->animation
    const AssetView* truth = nullptr;  // baked frames, may be null
    std::size_t truth_frame = 0;
    const MaterialView* material = nullptr;  // set for Channel::kShaded
    const LightView* light = nullptr;        // likewise
};

// `truth` may be null. UsageError: an unknown name (the message lists the known ones), a frame beyond the clip's last,
// a truth that is needed and not given. InvalidInput: an asset without what the channel needs, a truth of another mesh
// or animation. The views must outlive the shot.
Shot resolveShot(const RenderOptions& options, const AssetView& asset, const AssetView* truth);

}  // namespace penumbra
