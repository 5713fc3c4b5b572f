#include "player/view/view_controls.h"

#include <algorithm>
#include <array>

#include "formats/image/exposure.h"
#include "player/view/view_look.h"

namespace penumbra {

namespace {

using Names = std::vector<std::string_view>;

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
               kToneMaps[] = {"cut above 1", "Reinhard", "filmic"},
               kCompared[] = {"model", "baked truth", "side by side", "wipe", "difference"},
               kShadows[] = {"all shadows", "shadows on itself", "shadows on others", "no shadows"},
               kChannels[] = {"shaded",  "ambient visibility", "error against truth",        "clusters",
                              "normals", "rigid parts",        "ambient with bounced light", "PCA component"};
constexpr std::size_t kComponentChoice = std::size(kChannels) - 1;

}  // namespace

constexpr Menu kClipMenu{[](const Scene& scene, const ViewState& state) {
                             Names names;
                             for (const ClipView& clip : selectedCharacter(scene, state).asset.animation.clips)
                                 names.push_back(clip.name);
                             return names;
                         },
                         [](const ViewState& state) { return state.characters[state.selected].clip; },
                         [](ViewState& state, const Scene&, std::size_t clip) { chooseClip(state, clip); }};
constexpr Menu kSlotMenu{[](const Scene& scene, const ViewState& state) {
                             Names names = selectedCharacter(scene, state).asset.mesh.slots;
                             names.resize(state.characters[state.selected].material_of_slot.size());
                             names.push_back("all slots");
                             return names;
                         },
                         [](const ViewState& state) {
                             return std::min(state.slot, state.characters[state.selected].material_of_slot.size());
                         },
                         [](ViewState& state, const Scene&, std::size_t slot) { state.slot = slot; }};
constexpr Menu kMaterialMenu{
    [](const Scene& scene, const ViewState&) { return scene.material_names; }, chosenMaterial,
    [](ViewState& state, const Scene&, std::size_t material) { chooseMaterial(state, material); }};
constexpr Menu kLightMenu = menuOf<&ViewState::lighting, &Lighting::light>(
    [](const Scene& scene, const ViewState&) { return scene.light_names; });
constexpr Menu kLightFormMenu =
    menuOf<&ViewState::lighting, &Lighting::shading, &ShadingChoice::light_form>(namesOf<kForms>);
constexpr Menu kReflectanceMenu =
    menuOf<&ViewState::lighting, &Lighting::shading, &ShadingChoice::reflectance>(namesOf<kReflectances>);
constexpr Menu kBounceMenu = menuOf<&ViewState::lighting, &Lighting::bounces>(
    namesOf<kBounces>, [](const Scene& scene, std::size_t choice) { return choice == 0 || scene.bounces(); });
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
        for (std::size_t mode = 0; mode < kCastModes; ++mode) names.push_back(nameOf(CastMode(mode)));
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
bool compares(const Scene& scene, const ViewState& state) {
    return scene.hasTruth() && shownCompare(state) == state.show.compare;
}
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
constexpr Slider kExposureSlider{[](const Scene&, const ViewState& state) { return double(state.display.exposure); },
                                 [](ViewState& state, const Scene&, double value) { fixExposure(state, float(value)); },
                                 {double(kMinExposure), double(kMaxExposure), "x %.3g", true}};
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
    {ControlPanel::kLook, "slot", &kSlotMenu, hasSlots, nullptr, "Material"},
    {ControlPanel::kLook, "material", &kMaterialMenu, nullptr, membraneProblem},
    {ControlPanel::kLook, "parameter", kParameterSlider, hasParameter},
    {ControlPanel::kLook, "light", &kLightMenu, nullptr, nullptr, "Light"},
    {ControlPanel::kLook, "yaw", kLighting<&Lighting::yaw>({-180, 180, "yaw %.0f\xc2\xb0"}), nullptr, nullptr, nullptr,
     2},
    {ControlPanel::kLook, "pitch", kLighting<&Lighting::pitch>({-180, 180, "pitch %.0f\xc2\xb0"}), nullptr, nullptr,
     nullptr, 2, true},
    {ControlPanel::kLook, "form", &kLightFormMenu, nullptr, nullptr, nullptr, 2},
    {ControlPanel::kLook, "reflectance", &kReflectanceMenu, nullptr, formProblem, nullptr, 2, true},
    {ControlPanel::kLook, "suns", switchOf<&ViewState::lighting, &Lighting::suns>("suns with shadow maps"),
     lightHasSuns, sunProblem},
    {ControlPanel::kLook, "bounces", &kBounceMenu,
     [](const Scene& scene, const ViewState&) { return scene.bounces(); }},
    {ControlPanel::kLook, "exposure", kExposureSlider, nullptr, nullptr, "Exposure, tone mapping"},
    {ControlPanel::kLook, "automatic", switchOf<&ViewState::automatic_exposure>("automatic exposure")},
    {ControlPanel::kLook, "tone", &kToneMapMenu},
    {ControlPanel::kShow, "channel", &kChannelMenu, nullptr, nullptr, "Show"},
    {ControlPanel::kShow, "component", kComponentSlider,
     [](const Scene&, const ViewState& state) { return state.show.component.has_value(); }},
    {ControlPanel::kShow, "compare", &kCompareMenu, compares},
    {ControlPanel::kShow, "wipe", sliderOf<&ViewState::show, &ShowChoice::wipe>({0, 1, "wipe at %.2f"}),
     [](const Scene&, const ViewState& state) { return shownCompare(state) == Compare::kWipe; }},
    {ControlPanel::kShow, "scale", sliderOf<&ViewState::show, &ShowChoice::error_max>({1e-3, 1, "scale to %.3f", true}),
     [](const Scene&, const ViewState& state) { return state.show.channel == Channel::kError; }},
    {ControlPanel::kShow, "background", kShown<&ShowChoice::background>("background")},
    {ControlPanel::kShow, "ground", kShown<&ShowChoice::ground>("ground"), nullptr, nullptr, nullptr, 1, true},
    {ControlPanel::kShow, "turn", switchOf<&ViewState::turntable>("turn"), nullptr, nullptr, nullptr, 1, true},
    {ControlPanel::kShow, "shadows", &kShadowMenu},
    {ControlPanel::kShow, "join", &kCastModeMenu, joinsCasts},
    {ControlPanel::kShow, "brush", switchOf<&ViewState::tool, &PointerTool::brush, &GroundBrush::on>("brush"),
     hasHeights},
    {ControlPanel::kShow, "radius", kBrush<&GroundBrush::radius>({kMinBrush, kMaxBrush, "radius %.2f m", true}),
     brushes},
    {ControlPanel::kShow, "strength", kBrush<&GroundBrush::strength>({kMinBrush, kMaxBrush, "%.2f m a second", true}),
     brushes},
    {ControlPanel::kShow, "frames", kShown<&ShowChoice::frames>("normals and tangents")},
    {ControlPanel::kShow, "boxes", kShown<&ShowChoice::boxes>("boxes of fields, spheres"),
     [](const Scene& scene, const ViewState&) { return scene.hasOutlines(); }},
    {ControlPanel::kTime, "speed", sliderOf<&ViewState::playhead, &Playhead::speed>({0.125, 8, "speed x %.2f", true})},
    {ControlPanel::kTime, "smooth", switchOf<&ViewState::smooth>("smooth"), nullptr, nullptr, nullptr, 1, true},
};

}  // namespace

std::span<const Control> controls() { return kControls; }

}  // namespace penumbra
