#pragma once
// The targets that read assets share this: their corpus, made by the packer, and a mutator that falls back to it.
// Include this once in a target.
#include <cstdint>
#include <cstring>

#include "pack/pack_asset.h"
#include "tests/synthetic_cloth.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace penumbra {

// Makes tiny assets, one for each kind of model and of features.
inline const std::vector<std::vector<std::byte>>& tinyAssets() {
    static const std::vector<std::vector<std::byte>> all = [] {
        std::vector<std::vector<std::byte>> made;
        const std::vector<LightFile> lights = {synthetic::light(2, 0.3)};
        BrdfFile brdf;
        brdf.name = "plain";
        brdf.slice_order = brdf.view_order = 1;
        brdf.even_index = {0};
        brdf.slices = {1, 1, 1};
        for (const ModelKind kind : kModelKinds)
            for (const FeatureKind features : synthetic::kSkinnedFeatures) {
                const Model model = synthetic::tubeModel({.rings = 2,
                                                          .segments = 3,
                                                          .joints = 2,
                                                          .clusters = 1,
                                                          .components = 1,
                                                          .inputs = 1,
                                                          .frames = 2,
                                                          .features = features,
                                                          .kind = kind});
                made.push_back(packAsset(model, std::vector<BrdfFile>{brdf}, lights, {}, "{}", 1).bytes);
            }
        for (const FeatureKind features : {FeatureKind::kRelativeBones, FeatureKind::kDihedrals}) {
            const Model cloth = synthetic::clothModel({.rows = 2, .columns = 3, .frames = 2, .features = features});
            made.push_back(packAsset(cloth, std::vector<BrdfFile>{brdf}, lights, {}, "{}", 1).bytes);
        }
        return made;
    }();
    return all;
}

}  // namespace penumbra

// Replaces an input that is too short for an asset by a tiny valid one, so that a run needs no corpus.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned int seed) {
    const auto& assets = penumbra::tinyAssets();
    const std::vector<std::byte>& tiny = assets[seed % assets.size()];
    if (size < 64 && max_size >= tiny.size()) {
        std::memcpy(data, tiny.data(), tiny.size());
        size = tiny.size();
    }
    return LLVMFuzzerMutate(data, size, max_size);
}
