#include "player/view/view_material.h"

#include <algorithm>

namespace penumbra {

namespace {

const MaterialView& materialOf(const Scene& scene, std::size_t material) {
    return scene.characters.front()->asset.materials[material];  // all characters have the materials of every file
}

}  // namespace

std::optional<ChangingParameter> shownRange(const Scene& scene, std::size_t material) {
    return changingParameter(materialOf(scene, material));
}

double shownParameter(const Scene& scene, const ViewState& state, std::size_t material) {
    const auto chosen = state.parameters.find(material);
    if (chosen != state.parameters.end()) return chosen->second;
    return double(materialOf(scene, material).lobes[0].parameters[shownRange(scene, material)->index]);
}

void chooseParameter(const Scene& scene, ViewState& state, std::size_t material, double value) {
    const std::optional<ChangingParameter> range = shownRange(scene, material);
    if (range) state.parameters[material] = std::clamp(value, range->least, range->most);
}

void setParameters(const Scene& scene, const ViewState& state, ShadingSet& shading) {
    for (const std::uint16_t material : shading.materialOfSlot()) {
        const std::optional<ChangingParameter> range = shownRange(scene, material);
        if (!range || !shading.hasMaterial(material)) continue;
        const double wished = shownParameter(scene, state, material);
        if (shading.lobesOf(material)[0].parameters[range->index] != float(wished))
            shading.setParameter(material, wished);
    }
}

}  // namespace penumbra
