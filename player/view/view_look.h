#pragma once
// The current light and materials of the vertices: the chosen light or a blend on the way to it, its suns, the
// parameters of materials that may change, and the automatic exposure.
//
// An exposure that followed every frame would pump as a clip plays or the camera turns, and would hide that one pose is
// darker than another. So it is measured when the light, its turn, the switches of its suns and of light that
// bounces, a material or the ground changes, on the next frame that shows shaded colours, and stays until one of them
// changes again. It follows every frame of a light that becomes another.
#include <span>
#include <string_view>
#include <vector>

#include "player/view/view_scene.h"

namespace penumbra {

// Returns the lights of the files, without the last one, whose place a blend takes.
inline std::span<const LightView> lightsOf(const AssetView& asset) {
    return std::span(asset.lights).first(asset.lights.empty() ? 0 : asset.lights.size() - 1);
}

// Goes on by `seconds` towards the light that `state` has chosen. Lights in other forms than the exact rotation switch
// at once, as only SH can be mixed. So do those under which shadows of others join in another way than as a product.
void advanceLight(Scene& scene, const ViewState& state, double seconds);

// Return the light of the last advanceLight(); without a blend the chosen light. There must be a light. What is
// returned is valid until the next advanceLight().
LightView shownLight(const Scene& scene, const ViewState& state);
SkyPicture shownSky(const Scene& scene, const ViewState& state);
LightKey shownLightKey(const Scene& scene, const ViewState& state);
// Tells whether the light has suns, also where they have faded at the moment.
bool lightHasSuns(const Scene& scene, const ViewState& state);
// Makes what shades an asset of the scene, with its pictures where they are shown.
std::unique_ptr<ShadingSet> makeShading(const Scene& scene, const AssetView& asset, const ShadingChoice& choice);
// Tells whether a character shows its pictures now. Its values then have all terms (ShadingSet::terms()). Differences
// and shadows that do not join as a product are those of its material without pictures.
bool showsPictures(const Character& character, const ViewState& state);
// Gives the light to a character's ShadingSet.
void setShownLight(const Scene& scene, const ViewState& state, ShadingSet& set);

// Says why suns cannot shine, for example "the light has no suns"; empty where they can.
std::string_view whyNoSuns(const Scene& scene, const ViewState& state);
// Tells whether they shine: the user wants them, nothing is in their way, and the picture has shaded colours.
bool showsSuns(const Scene& scene, const ViewState& state);

// Returns the name and the range of a material's parameter; nothing for a material that stays as it is.
std::optional<ChangingParameter> shownRange(const Scene& scene, std::size_t material);

// Returns the parameter of such a material: as the user has set it, or as its file has it.
double shownParameter(const Scene& scene, const ViewState& state, std::size_t material);

// Sets the parameter of a material, within its range. Another material keeps what it has.
void chooseParameter(const Scene& scene, ViewState& state, std::size_t material, double value);

// Gives the materials that are on their parameters. Where nothing has changed it does nothing.
void setParameters(const Scene& scene, const ViewState& state, ShadingSet& shading);

// The choices that the exposure depends on.
struct ExposedLook {
    LightKey light;
    double light_yaw = 0, light_pitch = 0;  // degrees
    bool ground = false, suns = false;
    std::vector<std::vector<std::size_t>> materials;  // materials of each slot of every character
    Bounces bounces = Bounces::kBoth;
    bool operator==(const ExposedLook&) const = default;
};
ExposedLook exposedLook(const Scene& scene, const ViewState& state);

// Tells whether the picture has shaded colours, rather than differences, another channel or a component.
bool showsShadedColors(const Scene& scene, const ViewState& state);

// Sets an exposure by hand (E, D, the slider), within the bounds of formats/image/exposure.h.
void fixExposure(ViewState& state, float exposure);

}  // namespace penumbra
