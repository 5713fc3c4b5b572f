#include "player/view/window/view_panels.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "formats/image/exposure.h"
#include "player/frame/truth_frames.h"
#include "player/view/view_actions.h"
#include "player/view/view_brush.h"
#include "player/view/view_cast_way.h"
#include "player/view/view_exposure.h"
#include "player/view/view_light.h"
#include "player/view/view_material.h"
#include "player/view/view_pick.h"
#include "player/view/view_suns.h"
#include "player/view/window/view_inspect.h"
#include "player/view/window/view_overlays.h"
#include "player/view/window/view_timeline.h"

namespace penumbra {
namespace {

constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                                    ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings;

std::string text(std::string_view view) { return std::string(view); }

constexpr ImU32 kMarked = IM_COL32(242, 191, 77, 255);  // marks what is not as usual

// Adds a line of a list box, and returns true when it is clicked.
bool choice(const std::string& name, std::size_t id, bool chosen) {
    return ImGui::Selectable((name + "##" + std::to_string(id)).c_str(), chosen);
}

void chooseFromNames(const char* label, std::span<const std::string_view> names, std::size_t chosen, auto&& choose) {
    if (names.empty()) return;
    ImGui::SetNextItemWidth(-1);
    if (!ImGui::BeginCombo((std::string("##") + label).c_str(), text(names[chosen]).c_str())) return;
    for (std::size_t i = 0; i < names.size(); ++i)
        if (choice(text(names[i]), i, i == chosen)) choose(i);
    ImGui::EndCombo();
}

std::string nameOfCharacter(const Scene& scene, std::size_t i) {
    if (const SceneCharacter* member = memberOf(scene, i)) return member->name;
    return std::filesystem::path(scene.characters[i]->asset.name).stem();
}

void characterPanel(const Scene& scene, ViewState& state) {
    if (scene.characters.size() > 1) {
        ImGui::TextDisabled("Characters");
        for (std::size_t i = 0; i < scene.characters.size(); ++i)
            if (choice(nameOfCharacter(scene, i), i, i == state.selected)) state.selected = i;
    }
    const Character& character = *scene.characters[state.selected];
    ImGui::TextDisabled("Clips");
    for (std::size_t i = 0; i < character.asset.animation.clips.size(); ++i) {
        const ClipView& clip = character.asset.animation.clips[i];
        if (clip.held_out) ImGui::PushStyleColor(ImGuiCol_Text, kMarked);
        const std::string name = text(clip.name) + (clip.held_out ? "  (held out)" : "");
        if (choice(name, i + 1000, i == state.characters[state.selected].clip)) chooseClip(state, i);
        if (clip.held_out) ImGui::PopStyleColor();
    }
}

// Shows the forms of shading, and whether the chosen material and light have them.
void shadingChoice(const Scene& scene, ViewState& state) {
    int form = int(state.shading.light_form), reflectance = int(state.shading.reflectance);
    const float half = 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
    ImGui::SetNextItemWidth(half);
    if (ImGui::Combo("##form", &form, "fitted lobes\0fixed lobes\0exact rotation\0"))
        state.shading.light_form = LightForm(form);
    ImGui::SameLine();
    ImGui::SetNextItemWidth(half);
    if (ImGui::Combo("##reflectance", &reflectance, "slices\0operators\0"))
        state.shading.reflectance = Reflectance(reflectance);
    const ShadingChoice shown = shownShading(scene, state);
    if (shown.light_form != state.shading.light_form)
        ImGui::TextColored(ImColor(kMarked), "no fitted lobes: exact rotation");
    if (shown.reflectance != state.shading.reflectance)
        ImGui::TextColored(ImColor(kMarked), "a material has no operators: slices");
}

// Shows the switch of suns where the light has some, and what keeps them from shining.
void sunChoice(const Scene& scene, ViewState& state) {
    if (!lightHasSuns(scene, state)) return;
    ImGui::Checkbox("suns with shadow maps", &state.suns);
    const std::string_view problem = whyNoSuns(scene, state);
    if (state.suns && !problem.empty()) ImGui::TextColored(ImColor(kMarked), "%s: SH", text(problem).c_str());
}

// Shows the parameter of the chosen material, if that may change.
void parameterSlider(const Scene& scene, ViewState& state) {
    const std::size_t material = chosenMaterial(state);
    const AssetView& asset = scene.characters[state.selected]->asset;
    if (asset.materials[material].membrane && !asset.mesh.two_sided)
        ImGui::TextColored(ImColor(kMarked), "a membrane needs a two-sided mesh");
    const std::optional<ChangingParameter> range = shownRange(scene, material);
    if (!range) return;
    // Exponents spread over log(1 + s), so that 0 takes no more of the slider than it shows. Widths are logarithmic.
    const double offset = range->least > 0 ? 0 : 1, shown = shownParameter(scene, state, material);
    auto place = float(std::log(shown + offset));
    char label[64];
    std::snprintf(label, sizeof label, "%s %.4g", text(range->name).c_str(), shown);
    ImGui::SetNextItemWidth(-1);
    if (ImGui::SliderFloat("##parameter", &place, float(std::log(range->least + offset)),
                           float(std::log(range->most + offset)), label,
                           ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoInput))
        chooseParameter(scene, state, material, std::exp(double(place)) - offset);
}

// Lets the user choose between direct light, light that bounces and both, where a character has the latter.
void bounceChoice(const Scene& scene, ViewState& state) {
    if (!contentsOf(scene).bounces()) return;
    int bounces = int(state.bounces);
    ImGui::SetNextItemWidth(-1);
    if (ImGui::Combo("##bounces", &bounces, "direct and bounced light\0direct light\0bounced light\0"))
        state.bounces = Bounces(bounces);
}

void materialPanel(const Scene& scene, ViewState& state) {
    const Character& character = *scene.characters[state.selected];
    const std::vector<std::size_t>& chosen = state.characters[state.selected].material_of_slot;
    ImGui::TextDisabled("Material");
    if (chosen.size() > 1) {
        std::vector<std::string_view> slots = character.asset.mesh.slots;
        slots.push_back("all slots");
        chooseFromNames("slot", slots, std::min(state.slot, chosen.size()), [&](std::size_t i) { state.slot = i; });
    }
    chooseFromNames("material", scene.material_names, chosenMaterial(state),
                    [&](std::size_t i) { chooseMaterial(state, i); });
    if (!scene.material_names.empty()) parameterSlider(scene, state);
    ImGui::TextDisabled("Light");
    chooseFromNames("light", scene.light_names, state.light, [&](std::size_t i) { state.light = i; });
    float angles[2] = {float(state.light_yaw), float(state.light_pitch)};
    ImGui::SetNextItemWidth(-1);
    if (ImGui::DragFloat2("##turn", angles, 1, -180, 180, "%.0f\xc2\xb0", ImGuiSliderFlags_AlwaysClamp)) {
        state.light_yaw = double(angles[0]);
        state.light_pitch = double(angles[1]);
    }
    shadingChoice(scene, state);
    sunChoice(scene, state);
    bounceChoice(scene, state);
    ImGui::TextDisabled("Exposure, tone mapping");
    ImGui::SetNextItemWidth(-1);
    float exposure = state.display.exposure;
    if (ImGui::SliderFloat("##exposure", &exposure, kMinExposure, kMaxExposure, "x %.3g",
                           ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp))
        fixExposure(state, exposure);
    ImGui::Checkbox("automatic exposure", &state.automatic_exposure);
    int tone_map = int(state.display.tone_map);
    ImGui::SetNextItemWidth(-1);
    if (ImGui::Combo("##tone", &tone_map, "cut above 1\0Reinhard\0filmic\0"))
        state.display.tone_map = ToneMap(tone_map);
}

// Lets the user choose how shadows of others join.
void chooseCastMode(ViewState& state, const ViewContents& contents) {
    std::vector<CastMode> modes;
    std::vector<std::string_view> names;
    std::size_t chosen = 0;
    for (std::size_t m = 0; m < kCastModes; ++m) {
        if (!hasCastMode(contents, CastMode(m))) continue;
        if (CastMode(m) == state.cast_mode) chosen = modes.size();
        modes.push_back(CastMode(m));
        names.push_back(nameOf(CastMode(m)));
    }
    chooseFromNames("join", names, chosen, [&](std::size_t i) { state.cast_mode = modes[i]; });
}

void brushPanel(ViewState& state) {
    ImGui::Checkbox("brush", &state.brush.on);
    if (!state.brush.on) return;
    const double least = kMinBrush, most = kMaxBrush;
    ImGui::SetNextItemWidth(-1);
    ImGui::SliderScalar("##radius", ImGuiDataType_Double, &state.brush.radius, &least, &most, "radius %.2f m",
                        ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
    ImGui::SetNextItemWidth(-1);
    ImGui::SliderScalar("##strength", ImGuiDataType_Double, &state.brush.strength, &least, &most, "%.2f m a second",
                        ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
}

void channelPanel(const ViewContents& contents, ViewState& state) {
    ImGui::TextDisabled("Show");
    static constexpr std::string_view kNames[] = {"shaded",  "ambient visibility", "error against truth", "clusters",
                                                  "normals", "rigid parts",        "PCA component"};
    constexpr std::size_t kComponent = 6;
    chooseFromNames("channel", kNames, state.component ? kComponent : std::size_t(state.channel), [&](std::size_t i) {
        if (i == kComponent)
            chooseComponent(state, contents, 0);
        else
            chooseChannel(state, contents, Channel(i));
    });
    if (state.component) {
        int component = int(*state.component);
        ImGui::SetNextItemWidth(-1);
        if (ImGui::SliderInt("##component", &component, 0, int(contents.components()) - 1, "component %d",
                             ImGuiSliderFlags_AlwaysClamp))
            chooseComponent(state, contents, std::size_t(component));
    }
    if (contents.hasTruth()) {
        static constexpr std::string_view kCompared[] = {"model", "baked truth", "side by side", "wipe", "difference"};
        chooseFromNames("compare", kCompared, std::size_t(shownCompare(state)),
                        [&](std::size_t i) { chooseCompare(state, contents, Compare(i)); });
    }
    ImGui::SetNextItemWidth(-1);
    if (shownCompare(state) == Compare::kWipe) ImGui::SliderFloat("##wipe", &state.wipe, 0, 1, "wipe at %.2f");
    ImGui::SetNextItemWidth(-1);
    if (state.channel == Channel::kError)
        ImGui::SliderFloat("##scale", &state.error_max, 1e-3f, 1, "scale to %.3f", ImGuiSliderFlags_Logarithmic);
    ImGui::Checkbox("background", &state.background);
    ImGui::SameLine();
    ImGui::Checkbox("ground", &state.ground);
    ImGui::SameLine();
    ImGui::Checkbox("turn", &state.turntable);
    int shadows = int(state.shadows);
    ImGui::SetNextItemWidth(-1);
    if (ImGui::Combo("##shadows", &shadows, "all shadows\0shadows on itself\0shadows on others\0no shadows\0"))
        state.shadows = Shadows(shadows);
    if (contents.casters > 0 && shadows != int(Shadows::kSelf) && shadows != int(Shadows::kNone))
        chooseCastMode(state, contents);
    if (contents.heights) brushPanel(state);
    ImGui::Checkbox("normals and tangents", &state.frames);
    if (contents.hasOutlines()) ImGui::Checkbox("boxes of fields, spheres", &state.boxes);
}

// Explains missing truth. Poses between sampled frames have none, and need no word.
void truthHint(const Character& character, const ClipView& clip) {
    if (!character.truth || character.truth_frame) return;
    if (!hasTruthOf(character.asset, *character.truth, clip))
        ImGui::TextWrapped("This clip has no baked truth.");
    else if (character.part == 0)
        ImGui::TextWrapped("This frame has no baked truth.");
}

void figurePanel(const Scene& scene, const ViewState& state, const ViewFigures& figures) {
    ImGui::TextDisabled("Cost of a frame, ms");
    ImGui::Text("evaluate %.2f  shade %.2f", figures.update.evaluate, figures.update.shade);
    ImGui::Text("ground %.2f  upload %.2f  whole %.1f", figures.update.ground, figures.paint.upload, figures.frame);
    if (figures.software)
        ImGui::Text("path %s, software GL", figures.path == EvaluationPath::kCpu ? "CPU" : "GLSL");
    else
        ImGui::Text("path %s, GPU %.2f: %.2f + %.2f", figures.path == EvaluationPath::kCpu ? "CPU" : "GLSL",
                    figures.gpu, figures.paint.gpu_evaluate, figures.paint.gpu_draw);
    const Character& character = *scene.characters[state.selected];
    ImGui::TextDisabled("Frame");
    ImGui::Text("out of range %.3f", character.evaluator->outOfRange());
    if (character.channel == Channel::kError)
        ImGui::Text("error: mean %.4f, max %.3f", character.mean_error, character.max_error);
    truthHint(character, character.asset.animation.clips[state.characters[state.selected].clip]);
    if (!figures.message.empty()) ImGui::TextWrapped("%s", figures.message.c_str());
}

void helpWindow(ViewState& state) {
    const ImVec2 most = ImGui::GetIO().DisplaySize;  // scrolls in a small window
    ImGui::SetNextWindowSizeConstraints(ImVec2(0, 0), ImVec2(most.x - 20, most.y - 20));
    ImGui::SetNextWindowPos(ImVec2(0.5f * most.x, 0.5f * most.y), ImGuiCond_Always, ImVec2(0.5f, 0.5f));
    if (ImGui::Begin("Keys and mouse", &state.help,
                     ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoMove) &&
        ImGui::BeginTable("keys", 3, ImGuiTableFlags_RowBg)) {
        const auto row = [](const std::string& key, const std::string& what, const std::string& shifted) {
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(key.c_str());
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(what.c_str());
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(shifted.empty() ? "" : ("Shift: " + shifted).c_str());
        };
        for (const Shortcut& s : shortcuts()) row(text(s.name), text(s.text), text(s.shifted));
        row("Left drag", "orbit", "pan");
        row("Middle drag", "pan", "");
        row("Alt + left drag", "move a character on the ground", "");
        row("Left drag, brush (0)", "raise the ground", "lower it");
        row("Left click", "pick a vertex: its visibility", "");
        row("Right drag", "turn the light", "");
        row("Wheel", "nearer, farther", "");
        ImGui::EndTable();
    }
    ImGui::End();
}

void beginFixed(const char* name, float x, float y, float width, float height) {
    ImGui::SetNextWindowPos(ImVec2(x, y));
    ImGui::SetNextWindowSize(ImVec2(width, height));
    ImGui::Begin(name, nullptr, kFixed);
}

}  // namespace

void buildPanels(const Scene& scene, ViewState& state, const ViewFigures& figures, const Rectangle& picture,
                 float unit) {
    const ViewContents contents = contentsOf(scene);
    drawOverlays(scene, state, picture);
    if (state.help) helpWindow(state);
    if (!state.panels) return;
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    beginFixed("side", 0, 0, kSidePanelWidth * unit, size.y);
    characterPanel(scene, state);
    if (ImGui::CollapsingHeader("Asset")) assetPanel(*scene.characters[state.selected]);
    if (contents.shaded()) materialPanel(scene, state);
    channelPanel(contents, state);
    figurePanel(scene, state, figures);
    if (shownFactor(scene, state) && ImGui::CollapsingHeader("Factors", ImGuiTreeNodeFlags_DefaultOpen))
        factorPanel(scene, state);
    if (state.picked && ImGui::CollapsingHeader("Components", ImGuiTreeNodeFlags_DefaultOpen))
        componentPanel(scene, state);
    if (state.picked && ImGui::CollapsingHeader("Vertex", ImGuiTreeNodeFlags_DefaultOpen))
        vertexPanel(scene, *state.picked);
    ImGui::TextDisabled("F1: keys");
    ImGui::End();
    beginFixed("timeline", kSidePanelWidth * unit, size.y - kTimelineHeight * unit, size.x - kSidePanelWidth * unit,
               kTimelineHeight * unit);
    buildTimeline(scene, state);
    ImGui::End();
}

namespace {

// Returns the pointer's way with the button down since the frame before, once it has left the place where the button
// was pressed. A motion in the frame of the press does not count.
constexpr float kClick = 3;  // units that the pointer may move in a click
ImVec2 takeDrag(ImGuiMouseButton button) {
    const ImVec2 drag = ImGui::GetMouseDragDelta(button, kClick);
    if (drag.x != 0 || drag.y != 0) ImGui::ResetMouseDragDelta(button);
    return drag;
}

bool isHeld(ImGuiMouseButton button) {
    return ImGui::IsMouseDown(button) || ImGui::IsMouseReleased(button);  // the last of its way
}

// Lets the character that Alt and the left button took follow the pointer over the ground. Returns whether one does.
bool dragCharacter(const Scene& scene, ViewState& state, const Rectangle& picture) {
    const ImGuiIO& io = ImGui::GetIO();
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left) && io.KeyAlt)
        if (const auto under = pick(scene, state, picture, double(io.MousePos.x), double(io.MousePos.y))) {
            const Character& taken = *scene.characters[under->character];
            state.dragged = DraggedCharacter{under->character,
                                             double(taken.to_scene.point(taken.vertices.positions[under->vertex]).y)};
        }
    if (!state.dragged) return io.KeyAlt && isHeld(ImGuiMouseButton_Left);  // beside everyone it does nothing
    const auto at = [&](ImVec2 pointer) {
        return pointAtHeight(state, state.dragged->height, picture, double(pointer.x), double(pointer.y));
    };
    const auto now = at(io.MousePos),
               before = at(ImVec2(io.MousePos.x - io.MouseDelta.x, io.MousePos.y - io.MouseDelta.y));
    if (now && before) state.characters[state.dragged->character].moved += toFloat(*now - *before);
    if (!ImGui::IsMouseDown(ImGuiMouseButton_Left)) state.dragged.reset();
    return true;
}

// Shapes the ground while the left button is down. Returns whether the button is the brush's.
bool useBrush(const Scene& scene, ViewState& state, const Rectangle& picture) {
    const ImGuiIO& io = ImGui::GetIO();
    if (!state.brush.on || io.KeyCtrl || !isHeld(ImGuiMouseButton_Left)) return false;
    if (ImGui::IsMouseDown(ImGuiMouseButton_Left))
        state.stroke = strokeUnder(scene, state, picture, double(io.MousePos.x), double(io.MousePos.y), io.KeyShift,
                                   double(io.DeltaTime));
    return true;
}

}  // namespace

void applyMouse(const Scene& scene, ViewState& state, const Rectangle& picture) {
    const ImGuiIO& io = ImGui::GetIO();
    if (io.WantCaptureMouse || dragCharacter(scene, state, picture) || useBrush(scene, state, picture)) return;
    const bool left = isHeld(ImGuiMouseButton_Left), right = isHeld(ImGuiMouseButton_Right);
    const ImVec2 drag = takeDrag(left    ? ImGuiMouseButton_Left
                                 : right ? ImGuiMouseButton_Right
                                         : ImGuiMouseButton_Middle);
    const double across = double(drag.x), down = double(drag.y), height = picture.height;
    if (left ? io.KeyCtrl : right)
        dragLight(state, across, down, height);
    else if (left && !io.KeyShift)
        orbit(state.camera, across, down, height);
    else
        pan(state.camera, across, down, height);
    if (ImGui::IsMouseReleased(ImGuiMouseButton_Left) && !io.KeyCtrl && !io.KeyShift &&
        io.MouseDragMaxDistanceSqr[ImGuiMouseButton_Left] < kClick * kClick)
        state.picked = pick(scene, state, picture, double(io.MousePos.x), double(io.MousePos.y));
    if (io.MouseWheel != 0) dolly(state.camera, double(io.MouseWheel), boundsOf(scene).radius());
}

}  // namespace penumbra
