#pragma once
// The parameter of materials that may change, under a slider.
#include "player/view/view_scene.h"

namespace penumbra {

// Returns the name and the range of a material's parameter; nothing for a material that stays as it is.
std::optional<ChangingParameter> shownRange(const Scene& scene, std::size_t material);

// Returns the parameter of such a material: as the user has set it, or as its file has it.
double shownParameter(const Scene& scene, const ViewState& state, std::size_t material);

// Sets the parameter of a material, within its range. Another material keeps what it has.
void chooseParameter(const Scene& scene, ViewState& state, std::size_t material, double value);

// Gives the materials that are on their parameters. Where nothing has changed it does nothing.
void setParameters(const Scene& scene, const ViewState& state, ShadingSet& shading);

}  // namespace penumbra
