#include "player/view/view_controls.h"

#include <algorithm>
#include <array>

#include "formats/image/exposure.h"
#include "player/view/material_label.h"
#include "player/view/view_look.h"

namespace penumbra {

namespace {

using Names = std::vector<std::string>;

// A member of the state, or of a group in it.
template <auto kFirst, auto... kMembers>
auto& memberAt(auto& state) {
    return ((state.*kFirst).*....*kMembers);
}

// A choice that is an enumeration.
template <auto... kMembers>
constexpr Menu menuOf(Names (*names)(const Scene&, const ViewState&),
                      bool (*has)(const Scene&, std::size_t) = nullptr) {
    return {names, [](const ViewState& state) { return std::size_t(memberAt<kMembers...>(state)); },
            [](ViewState& state, const Scene&, std::size_t choice) {
                auto& member = memberAt<kMembers...>(state);
                member = std::remove_reference_t<decltype(member)>(choice);
            },
            has};
}
template <const auto& kNames>
Names namesOf(const Scene&, const ViewState&) {
    return {std::begin(kNames), std::end(kNames)};
}

// A slider of a number.
template <auto... kMembers>
constexpr Slider sliderOf(const SliderRange& range) {
    return {[](const Scene&, const ViewState& state) { return double(memberAt<kMembers...>(state)); },
            [](ViewState& state, const Scene&, double value) {
                auto& member = memberAt<kMembers...>(state);
                member = std::remove_reference_t<decltype(member)>(value);
            },
            range};
}

template <auto... kMembers>
constexpr Switch switchOf(const char* name) {
    return {name, [](ViewState& state) -> bool& { return memberAt<kMembers...>(state); }};
}

const Character& selectedCharacter(const Scene& scene, const ViewState& state) {
    return *scene.characters[state.selected];
}

using Text = std::string_view;
constexpr Text kForms[] = {"fitted lobes", "fixed lobes", "exact rotation"}, kReflectances[] = {"slices", "operators"},
               kBounces[] = {"direct and bounced light", "direct light", "bounced light"},
               kToneMaps[] = {"linear, cut at white", "Reinhard", "filmic"},
               kCompared[] = {"model", "baked truth", "side by side", "wipe", "difference"},
               kShadows[] = {"all shadows", "shadows on itself", "shadows on others", "no shadows"},
               kChannels[] = {"shaded",  "ambient visibility", "error against truth",        "clusters",
                              "normals", "rigid parts",        "ambient with bounced light", "PCA component"};
constexpr std::size_t kComponentChoice = std::size(kChannels) - 1;

}  // namespace

constexpr Menu kClipMenu{[](const Scene& scene, const ViewState& state) {
                             Names names;
                             for (const ClipView& clip : selectedCharacter(scene, state).asset.animation.clips)
                                 names.emplace_back(clip.name);
                             return names;
                         },
                         [](const ViewState& state) { return state.characters[state.selected].clip; },
                         [](ViewState& state, const Scene&, std::size_t clip) { chooseClip(state, clip); }};
constexpr Menu kSlotMenu{[](const Scene& scene, const ViewState& state) {
                             const auto& slots = selectedCharacter(scene, state).asset.mesh.slots;
                             Names names(slots.begin(), slots.end());
                             names.resize(state.characters[state.selected].material_of_slot.size());
                             names.push_back("all slots");
                             return names;
                         },
                         [](const ViewState& state) {
                             return std::min(state.slot, state.characters[state.selected].material_of_slot.size());
                         },
                         [](ViewState& state, const Scene&, std::size_t slot) { state.slot = slot; }};
constexpr Menu kMaterialMenu{
    [](const Scene& scene, const ViewState&) {
        Names labels;
        for (const std::string_view name : scene.material_names) labels.push_back(materialLabel(name));
        return labels;
    },
    chosenMaterial, [](ViewState& state, const Scene&, std::size_t material) { chooseMaterial(state, material); }};
constexpr Menu kLightMenu = menuOf<&ViewState::lighting, &Lighting::light>(
    [](const Scene& scene, const ViewState&) { return Names(scene.light_names.begin(), scene.light_names.end()); });
constexpr Menu kLightFormMenu =
    menuOf<&ViewState::lighting, &Lighting::shading, &ShadingChoice::light_form>(namesOf<kForms>);
constexpr Menu kReflectanceMenu =
    menuOf<&ViewState::lighting, &Lighting::shading, &ShadingChoice::reflectance>(namesOf<kReflectances>);
constexpr Menu kBounceMenu =
    menuOf<&ViewState::lighting, &Lighting::bounces>(namesOf<kBounces>, [](const Scene& scene, std::size_t choice) {
        return choice == 0 || scene.bounces() || (Bounces(choice) == Bounces::kDirect && scene.passesLight());
    });
constexpr Menu kToneMapMenu = menuOf<&ViewState::display, &DisplayTransform::tone_map>(namesOf<kToneMaps>);
constexpr Menu kChannelMenu{
    namesOf<kChannels>,
    [](const ViewState& state) { return state.show.component ? kComponentChoice : std::size_t(state.show.channel); },
    [](ViewState& state, const Scene& scene, std::size_t choice) {
        if (choice != kComponentChoice)
            chooseChannel(state, scene, Channel(choice));
        else if (scene.components() > 0)
            state.show.component = 0;
    },
    [](const Scene& scene, std::size_t choice) {
        return choice == kComponentChoice ? scene.components() > 0 : hasChannel(scene, Channel(choice));
    }};
constexpr Menu kCompareMenu = menuOf<&ViewState::show, &ShowChoice::compare>(
    namesOf<kCompared>, [](const Scene& scene, std::size_t choice) { return choice == 0 || scene.hasTruth(); });
constexpr Menu kShadowMenu = menuOf<&ViewState::show, &ShowChoice::shadows>(namesOf<kShadows>);
constexpr Menu kCastModeMenu = menuOf<&ViewState::show, &ShowChoice::cast_mode>(
    [](const Scene&, const ViewState&) {
        Names names;
        for (std::size_t mode = 0; mode < kCastModes; ++mode) names.emplace_back(nameOf(CastMode(mode)));
        return names;
    },
    [](const Scene& scene, std::size_t mode) { return hasCastMode(scene, CastMode(mode)); });

void chooseNext(const Menu& menu, ViewState& state, const Scene& scene, int step) {
    const std::size_t count = menu.names(scene, state).size();
    std::size_t choice = menu.chosen(state);
    for (std::size_t i = 0; i < count; ++i) {
        choice = (choice + count + std::size_t(step)) % count;
        if (menu.offers(scene, choice)) return menu.choose(state, scene, choice);
    }
}

bool hasCastMode(const Scene& scene, CastMode mode) {
    if (mode == CastMode::kProduct || scene.field) return mode == CastMode::kProduct;
    return scene.cast->casterCount() > 0 && (!needsSpheres(mode) || scene.sphere_cast);
}

namespace {

// Whether a slider or a switch is there.
bool hasSlots(const Scene&, const ViewState& state) {
    return state.characters[state.selected].material_of_slot.size() > 1;
}
bool hasParameter(const Scene& scene, const ViewState& state) {
    return shownRange(scene, chosenMaterial(state)).has_value();
}
bool hasTruth(const Scene& scene, const ViewState&) { return scene.hasTruth(); }
bool compares(const Scene&, const ViewState& state) { return canCompare(state); }
bool hasHeights(const Scene& scene, const ViewState&) { return scene.field != nullptr; }
bool brushes(const Scene& scene, const ViewState& state) { return scene.field && state.tool.brush.on; }
bool joinsCasts(const Scene& scene, const ViewState& state) {
    return scene.cast->casterCount() > 0 &&
           (state.show.shadows == Shadows::kBoth || state.show.shadows == Shadows::kCast);
}

std::string membraneProblem(const Scene& scene, const ViewState& state) {
    const AssetView& asset = selectedCharacter(scene, state).asset;
    const bool lacks_side = asset.materials[chosenMaterial(state)].membrane && !asset.mesh.two_sided;
    return lacks_side ? "a membrane needs a two-sided mesh" : "";
}
std::string formProblem(const Scene& scene, const ViewState& state) {
    const ShadingChoice shown = shownShading(scene, state), &wished = state.lighting.shading;
    std::string problem;
    if (shown.light_form != wished.light_form) problem = "no fitted lobes: exact rotation";
    if (shown.reflectance != wished.reflectance)
        problem += (problem.empty() ? "" : "\n") + std::string("a material has no operators: slices");
    return problem;
}
std::string sunProblem(const Scene& scene, const ViewState& state) {
    const std::string_view problem = whyNoSuns(scene, state);
    return state.lighting.suns && !problem.empty() ? std::string(problem) + ": SH" : "";
}

constexpr Slider kParameterSlider{
    [](const Scene& scene, const ViewState& state) { return shownParameter(scene, state, chosenMaterial(state)); },
    [](ViewState& state, const Scene& scene, double value) {
        chooseParameter(scene, state, chosenMaterial(state), value);
    },
    {},
    [](const Scene& scene, const ViewState& state) {
        const std::optional<ChangingParameter> range = shownRange(scene, chosenMaterial(state));
        return SliderRange{range->least, range->most, "%.4g", true, range->name};
    }};
// A short drag changes an exposure by what the eye sees. Lights of other units have all exposures.
SliderRange exposureRange(const ViewState& state) {
    constexpr double kUsual = 1000;
    const auto exposure = double(state.display.exposure);
    const bool usual = exposure >= 1 / kUsual && exposure <= kUsual;
    return usual ? SliderRange{1 / kUsual, kUsual, "x %.3g", true}
                 : SliderRange{double(kMinExposure), double(kMaxExposure), "x %.3g", true};
}

constexpr Slider kExposureSlider{[](const Scene&, const ViewState& state) { return double(state.display.exposure); },
                                 [](ViewState& state, const Scene&, double value) { fixExposure(state, float(value)); },
                                 {},
                                 [](const Scene&, const ViewState& state) { return exposureRange(state); }};
constexpr Slider kComponentSlider{
    [](const Scene&, const ViewState& state) { return double(*state.show.component); },
    [](ViewState& state, const Scene&, double value) { state.show.component = std::size_t(value + 0.5); },
    {},
    [](const Scene& scene, const ViewState&) {
        return SliderRange{0, double(scene.components() - 1), "component %.0f"};
    }};

template <auto kMember>
constexpr auto kLighting = sliderOf<&ViewState::lighting, kMember>;
template <auto kMember>
constexpr auto kBrush = sliderOf<&ViewState::tool, &PointerTool::brush, kMember>;
template <auto kMember>
constexpr auto kShown = switchOf<&ViewState::show, kMember>;

constexpr Control kControls[] = {
    {ControlPanel::kLook, "slot", "slot", "The part of the mesh that a material is chosen for (S)", &kSlotMenu,
     hasSlots, nullptr, "Material"},
    {ControlPanel::kLook, "material", "material", "What the surface is made of (M)", &kMaterialMenu, nullptr,
     membraneProblem},
    {ControlPanel::kLook, "parameter", "changes", "The number of a material that may change while it is shown",
     kParameterSlider, hasParameter},
    {ControlPanel::kLook, "light", "light", "The environment that lights everything (L)", &kLightMenu, nullptr, nullptr,
     "Light"},
    {ControlPanel::kLook, "yaw", "turn", "Turns the light about the vertical: drag with the right button (K: back)",
     kLighting<&Lighting::yaw>({-180, 180, "%.0f\xc2\xb0"})},
    {ControlPanel::kLook, "pitch", "tilt", "Tips the light over: drag with the right button (K: back)",
     kLighting<&Lighting::pitch>({-180, 180, "%.0f\xc2\xb0"})},
    {ControlPanel::kLook, "form", "form", "How the light is turned: exactly, or as lobes that were fitted to it (V)",
     &kLightFormMenu},
    {ControlPanel::kLook, "reflectance", "reflection",
     "How materials are stored: a slice for each direction of view, or operators (P)", &kReflectanceMenu, nullptr,
     formProblem},
    {ControlPanel::kLook, "suns", nullptr, "Small bright sources shine by themselves, with sharp shadows (H)",
     switchOf<&ViewState::lighting, &Lighting::suns>("suns with shadow maps"), lightHasSuns, sunProblem},
    {ControlPanel::kLook, "bounces", "bounces",
     "Light that comes from the surface itself, from others and from the ground (9)", &kBounceMenu,
     [](const Scene& scene, const ViewState&) { return scene.bounces() || scene.passesLight(); }},
    {ControlPanel::kLook, "exposure", "exposure", "Brighter (E), darker (D); Ctrl + click takes a number",
     kExposureSlider, nullptr, nullptr, "Display"},
    {ControlPanel::kLook, "automatic", nullptr,
     "Shows most of the characters and the ground neither dark nor burnt out (Shift + E)",
     switchOf<&ViewState::automatic_exposure>("automatic exposure")},
    {ControlPanel::kLook, "tone", "tone map", "How light that is brighter than the screen is shown (O)", &kToneMapMenu},
    {ControlPanel::kShow, "channel", "picture", "What the surface shows (1 to 8)", &kChannelMenu, nullptr, nullptr,
     "Show"},
    {ControlPanel::kShow, "component", "which", "The component of the model that is shown (6)", kComponentSlider,
     [](const Scene&, const ViewState& state) { return state.show.component.has_value(); }},
    {ControlPanel::kShow, "compare", "compare",
     "The model, the baked truth, or both, in shaded pictures and ambient visibility (C, T)", &kCompareMenu, hasTruth,
     nullptr, nullptr, false, compares},
    {ControlPanel::kShow, "wipe", "wipe at", "Where the model ends and the truth begins",
     sliderOf<&ViewState::show, &ShowChoice::wipe>({0, 1, "%.2f of the width"}),
     [](const Scene&, const ViewState& state) { return shownCompare(state) == Compare::kWipe; }},
    {ControlPanel::kShow, "gain", "enlarged", "Differences are drawn so many times as bright",
     sliderOf<&ViewState::show, &ShowChoice::difference_gain>({1, 64, "x %.3g", true}),
     [](const Scene&, const ViewState& state) { return shownCompare(state) == Compare::kDifference; }},
    {ControlPanel::kShow, "scale", "scale to", "The error that has the brightest colour ([ and ])",
     sliderOf<&ViewState::show, &ShowChoice::error_max>({1e-3, 1, "%.3f", true}),
     [](const Scene&, const ViewState& state) { return state.show.channel == Channel::kError; }},
    {ControlPanel::kShow, "background", nullptr, "The light's picture behind everything (B)",
     kShown<&ShowChoice::background>("background")},
    {ControlPanel::kShow, "ground", nullptr, "A ground that takes the shadows (G)",
     kShown<&ShowChoice::ground>("ground"), nullptr, nullptr, nullptr, true},
    {ControlPanel::kShow, "turn", nullptr, "The camera goes round (R)", switchOf<&ViewState::turntable>("turntable"),
     nullptr, nullptr, nullptr, true},
    {ControlPanel::kShow, "shadows", "shadows", "Whose shadows are shown (J)", &kShadowMenu},
    {ControlPanel::kShow, "join", "joined as", "How shadows of others join what everyone sees of itself",
     &kCastModeMenu, joinsCasts},
    {ControlPanel::kShow, "brush", nullptr, "Left drag raises the ground, Shift + left drag lowers it (0)",
     switchOf<&ViewState::tool, &PointerTool::brush, &GroundBrush::on>("brush"), hasHeights},
    {ControlPanel::kShow, "radius", "radius", "How wide the brush is (, and .)",
     kBrush<&GroundBrush::radius>({kMinBrush, kMaxBrush, "%.2f m", true}), brushes},
    {ControlPanel::kShow, "strength", "strength", "How fast the brush raises its middle (Shift with , and .)",
     kBrush<&GroundBrush::strength>({kMinBrush, kMaxBrush, "%.2f m a second", true}), brushes},
    {ControlPanel::kShow, "frames", nullptr, "Lines: normals blue, tangents red, their cross products green (N)",
     kShown<&ShowChoice::frames>("normals and tangents")},
    {ControlPanel::kShow, "boxes", nullptr,
     "The boxes of the parts' fields, or the spheres that characters cast by (U)",
     kShown<&ShowChoice::boxes>("boxes of fields, spheres"),
     [](const Scene& scene, const ViewState&) { return scene.hasOutlines(); }},
    {ControlPanel::kTime, "speed", nullptr, "Up: twice as fast; Down: half as fast",
     sliderOf<&ViewState::playhead, &Playhead::speed>({0.125, 8, "speed x %.2f", true})},
    {ControlPanel::kTime, "smooth", nullptr, "Poses between sampled frames are shown, too (I)",
     switchOf<&ViewState::smooth>("smooth"), nullptr, nullptr, nullptr, true},
};

}  // namespace

std::span<const Control> controls() { return kControls; }

}  // namespace penumbra
