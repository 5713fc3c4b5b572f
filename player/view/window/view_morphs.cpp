// The sliders of morph targets.
#include <imgui.h>

#include <algorithm>

#include "player/view/playback/morph_weights.h"
#include "player/view/window/view_panels.h"

namespace penumbra {

void morphPanel(const Scene& scene, ViewState& state) {
    const Character& character = *scene.characters[state.selected];
    const std::span<const std::string_view> names = morphNames(character.asset);
    const std::span<const float> weights = character.posed.evaluator->rest().weights();
    if (weights.size() != names.size()) return;
    std::optional<WeightEdit>& edit = state.inspect.weight_edit;
    if (ImGui::SmallButton("as the clip has them")) edit.reset();
    for (std::size_t m = 0; m < names.size(); ++m) {
        float weight = weights[m];
        ImGui::PushID(int(m));
        ImGui::SetNextItemWidth(0.5f * ImGui::GetContentRegionAvail().x);
        const bool changed =
            ImGui::SliderFloat(std::string(names[m]).c_str(), &weight, std::min(0.0f, weight), std::max(1.0f, weight));
        ImGui::PopID();
        if (!changed) continue;
        if (!edit || edit->character != state.selected)
            edit = WeightEdit{state.selected, {weights.begin(), weights.end()}};
        edit->weights[m] = weight;
    }
}

}  // namespace penumbra
