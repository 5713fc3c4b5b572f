#include "player/view/view_material.h"

#include <algorithm>

namespace penumbra {

namespace {

const MaterialView& materialOf(const Scene& scene, std::size_t material) {
    return scene.characters.front()->asset.materials[material];  // all characters have the materials of every file
}

}  // namespace

const BrdfParameter* shownRange(const Scene& scene, std::size_t material) {
    const MaterialView& live = materialOf(scene, material);
    return live.isLive() ? &parametersOf(live.lobes[0].model)[0] : nullptr;
}

double shownParameter(const Scene& scene, const ViewState& state, std::size_t material) {
    const auto chosen = state.parameters.find(material);
    if (chosen != state.parameters.end()) return chosen->second;
    return double(materialOf(scene, material).lobes[0].parameters[0]);
}

void chooseParameter(const Scene& scene, ViewState& state, std::size_t material, double value) {
    const BrdfParameter* const range = shownRange(scene, material);
    if (range) state.parameters[material] = std::clamp(value, range->least, range->most);
}

void setParameters(const Scene& scene, const ViewState& state, ShadingSet& shading) {
    for (const std::uint16_t material : shading.materialOfSlot()) {
        if (!shading.isLive(material)) continue;
        const double wished = shownParameter(scene, state, material);
        if (shading.lobesOf(material)[0].parameters[0] != float(wished)) shading.setParameter(material, wished);
    }
}

}  // namespace penumbra
