#pragma once
// Tells when the window measures its automatic exposure anew.
//
// An exposure that followed every frame would pump as a clip plays or the camera turns, and would hide that one pose is
// darker than another. So it is measured when the light, its turn, the switches of its suns and of light that
// bounces, a material or the ground changes, on the next frame that shows shaded colours, and stays until one of them
// changes again. It follows every frame of a light that becomes another.
#include <vector>

#include "player/view/view_scene.h"

namespace penumbra {

// The choices that the exposure depends on.
struct ExposedLook {
    LightKey light;
    double light_yaw = 0, light_pitch = 0;  // degrees
    bool ground = false, suns = false;
    std::vector<std::vector<std::size_t>> materials;  // of every character, of its slots
    Bounces bounces = Bounces::kBoth;
    bool operator==(const ExposedLook&) const = default;
};
ExposedLook exposedLook(const Scene& scene, const ViewState& state);

// Tells whether the picture has shaded colours, rather than differences, another channel or a component.
bool showsShadedColors(const Scene& scene, const ViewState& state);

// E and D, and the slider, fix an exposure. These bounds are those of automatic ones.
void fixExposure(ViewState& state, float exposure);

}  // namespace penumbra
