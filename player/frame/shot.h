#pragma once
// Resolves a render's names: which frame of which asset, under which light, of which material, seen from where.
#include "formats/asset/asset_file.h"
#include "player/frame/render_options.h"
#include "player/frame/visibility_factors.h"
#include "runtime/shade/shading_set.h"

namespace penumbra {

struct Shot {
    const AssetView* asset = nullptr;  // with mesh and model
    std::size_t frame = 0;             // index in asset->animation
    const AssetView* truth = nullptr;  // baked frames; may be null
    std::size_t truth_frame = 0;
    // Only for Channel::kShaded:
    bool shaded = false;
    ShadingChoice shading;
    bool suns = false;  // true if the light's suns are shaded as suns
    Bounces bounces = Bounces::kBoth;
    bool surface = false;                                    // pictures are seen where the asset has them
    std::vector<std::size_t> material_of_slot;               // one for each slot of ShadingSet
    std::vector<std::pair<std::size_t, double>> parameters;  // values for materials whose parameter can change
    std::size_t light = 0;
    Mat3 light_rotation;
    // Drawings beside the character:
    std::optional<std::size_t> lobe;  // a vertex
    FactorChoice lobe_of;
    std::vector<std::size_t> boxes;  // boxes of the fields of these parts
};

// Resolves all names. `truth` may be null. Throws BadOption for an unknown name (it lists the known ones), for a
// frame beyond the clip's last, and for a truth that is needed but not given. Throws InvalidInput for an asset
// without what the channel needs, and for a truth of another mesh or animation. The views must outlive the shot.
Shot resolveShot(const RenderOptions& options, const AssetView& asset, const AssetView* truth);

// Throws Unsupported for a deforming mesh without the positions of its frames.
void requireFrames(const AssetView& asset);

// Resolves all except the frames, which stay 0.
Shot resolveLook(const RenderOptions& options, const AssetView& asset, const AssetView* truth);

// Returns a set with the shot's materials and light on; shot.shaded must be set. The asset must outlive it.
ShadingSet shadingOf(const Shot& shot);

}  // namespace penumbra
