#include "player/view/window/view_panels.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "player/frame/truth_frames.h"
#include "player/view/shown_files.h"
#include "player/view/view_actions.h"
#include "player/view/view_pick.h"
#include "player/view/window/view_widgets.h"

namespace penumbra {
namespace {

constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                                    ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings;

// How many clips the list shows; it scrolls. It leaves most of a small window to the rest.
std::size_t mostClipLines() {
    const float lines = 0.3f * ImGui::GetWindowHeight() / ImGui::GetTextLineHeightWithSpacing();
    return std::size_t(std::clamp(lines, 3.0f, 8.0f));
}

std::string text(std::string_view view) { return std::string(view); }

std::string nameOfCharacter(const Scene& scene, std::size_t i) {
    if (const SceneCharacter* member = memberOf(scene, i)) return member->name;
    return std::filesystem::path(scene.characters[i]->asset.name).stem();
}

// Writes a character's name, which a click selects, and at its right what takes the character away.
void characterLine(const Scene& scene, ViewState& state, std::size_t i) {
    const std::string label = "x##leave" + std::to_string(i);
    const float width = ImGui::CalcTextSize("x").x + 2 * ImGui::GetStyle().FramePadding.x;
    const bool leaves = canLeave(scene, i);
    const float line = leaves ? ImGui::GetContentRegionAvail().x - width - ImGui::GetStyle().ItemSpacing.x : 0;
    if (listLine(nameOfCharacter(scene, i), i, i == state.selected, line)) state.selected = i;
    if (!leaves) return;
    ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - width);
    if (ImGui::SmallButton(label.c_str())) state.window.leaving = i;
    if (ImGui::IsItemHovered()) tooltip("Takes this character away");
}

// The name of a clip, and what there is to know before it is chosen.
std::string clipLine(const Character& character, const ClipView& clip) {
    std::string marks = clip.held_out ? "held out" : "";
    if (character.truth && hasTruthOf(character.asset, *character.truth, clip))
        marks += marks.empty() ? "truth" : ", truth";
    return text(clip.name) + (marks.empty() ? "" : "  (" + marks + ")");
}

void characterPanel(const Scene& scene, ViewState& state) {
    if (scene.characters.size() > 1) {
        ImGui::TextDisabled("Characters");
        for (std::size_t i = 0; i < scene.characters.size(); ++i) characterLine(scene, state, i);
    }
    const Character& character = *scene.characters[state.selected];
    ImGui::TextDisabled("Clips");
    const std::size_t count = character.asset.animation.clips.size();
    const std::size_t lines = mostClipLines();
    const bool scrolls = count > lines;
    if (scrolls) ImGui::BeginChild("clips", ImVec2(0, float(lines) * ImGui::GetTextLineHeightWithSpacing()));
    for (std::size_t i = 0; i < count; ++i) {
        const ClipView& clip = character.asset.animation.clips[i];
        if (clip.held_out) ImGui::PushStyleColor(ImGuiCol_Text, ImU32(kMarked));
        if (listLine(clipLine(character, clip), i + 1000, i == state.characters[state.selected].clip))
            chooseClip(state, i);
        if (clip.held_out) ImGui::PopStyleColor();
        if (clip.held_out && ImGui::IsItemHovered()) tooltip("The model was not trained on this clip.");
    }
    if (scrolls) ImGui::EndChild();
}

// Explains missing truth. Poses between sampled frames have none, and need no word.
void truthHint(const Character& character, const ClipView& clip) {
    if (!character.truth || *character.posed.truth_frame) return;
    if (!hasTruthOf(character.asset, *character.truth, clip))
        ImGui::TextWrapped("This clip has no baked truth.");
    else if (character.posed.pose().part == 0)
        ImGui::TextWrapped("This frame has no baked truth.");
}

void figurePanel(const Scene& scene, const ViewState& state, const ViewFigures& figures) {
    ImGui::TextDisabled("Cost of a frame, ms");
    ImGui::Text("evaluate %.2f  shade %.2f  ground %.2f", figures.update.evaluate, figures.update.shade,
                figures.update.ground);
    const char* path = figures.path == EvaluationPath::kCpu ? "CPU" : "GLSL";
    if (figures.software)
        ImGui::Text("path %s; with software GL %.1f", path, figures.frame);
    else
        ImGui::Text("path %s; GPU %.2f: evaluate %.2f, draw %.2f", path, figures.gpu, figures.paint.gpu_evaluate,
                    figures.paint.gpu_draw);
    const Character& character = *scene.characters[state.selected];
    ImGui::TextDisabled("Frame");
    ImGui::Text("out of range %.3f", character.posed.evaluator->outOfRange());
    if (character.shown.channel == Channel::kError)
        ImGui::Text("error: mean %.4f, max %.3f", character.shown.mean_error, character.shown.max_error);
    truthHint(character, character.asset.animation.clips[state.characters[state.selected].clip]);
}

// Lists the keys in the panel, beside the picture that they change.
void helpPanel(ViewState& state) {
    if (ImGui::Button("Close (F1)")) state.window.help = false;
    const float column = std::min(7.5f * ImGui::GetFontSize(), 0.45f * ImGui::GetWindowWidth());
    const auto row = [&](const std::string& key, const std::string& what, const std::string& shifted) {
        ImGui::TextUnformatted(key.c_str());
        ImGui::SameLine(column);
        ImGui::TextWrapped("%s", (what + (shifted.empty() ? "" : "\nShift: " + shifted)).c_str());
    };
    ImGui::TextDisabled("Mouse");
    row("Left drag", "orbit", "pan");
    row("Middle drag", "pan", "");
    row("Right drag", "turn the light", "");
    row("Wheel", "nearer, farther", "");
    row("Left click", "pick a vertex: its visibility", "");
    row("Alt + left", "move a character", "");
    row("Left, brush", "raise the ground (0)", "lower it");
    ImGui::TextDisabled("Keys");
    for (const Shortcut& s : shortcuts()) row(text(s.name), text(s.text), text(s.shifted));
}

void beginFixed(const char* name, float x, float y, float width, float height) {
    ImGui::SetNextWindowPos(ImVec2(x, y));
    ImGui::SetNextWindowSize(ImVec2(width, height));
    ImGui::Begin(name, nullptr, kFixed);
}

// A button of a row goes on in the line where there is room. Returns whether it was clicked.
bool rowButton(const char* name, const char* tip) {
    const float width = ImGui::CalcTextSize(name).x + 2 * ImGui::GetStyle().FramePadding.x;
    ImGui::SameLine();
    if (ImGui::GetContentRegionAvail().x < width) ImGui::NewLine();
    const bool clicked = ImGui::Button(name);
    if (ImGui::IsItemHovered()) tooltip(tip);
    return clicked;
}

void savePanel(ViewState& state) {
    ImGui::TextDisabled("Save");
    const auto begin = [&](Sequence of) {
        state.window.of = of;
        state.window.sequence = 0;
    };
    if (state.window.sequence) {
        if (ImGui::Button("Stop (Escape)")) state.window.sequence.reset();
        return;
    }
    if (ImGui::Button("picture")) {
        state.window.screenshot = true;
        state.window.screenshot_panels = false;
    }
    if (ImGui::IsItemHovered())
        tooltip("Writes the picture without panels, view_0001.png, into the folder of --screenshots (Shift + F12)");
    if (rowButton("turntable", "Writes a turn of the camera as a video of 12 s, turn_0001.y4m (Shift + F11)"))
        begin(Sequence::kTurntable);
    if (rowButton("frames", "Writes a picture of each frame of the clip (F11)")) begin(Sequence::kClip);
}

// Lists files beside what is shown.
void filesBeside(const FolderList& list, ViewState& state) {
    const bool closes = ImGui::Button("Close (F2)");
    ImGui::TextWrapped(
        "A character stands beside the others, and a scene takes the place of all. Lights, materials and baked truth "
        "come to what is shown. Files can also be dropped onto the picture.");
    filePanel(list, state);
    if (closes) state.window.browsed.reset();
}

// Everything about the scene. What belongs to a picked vertex stands before what is always there, so that a click shows
// it without scrolling.
void scenePanel(const Scene& scene, ViewState& state, const ViewFigures& figures) {
    if (ImGui::Button("Open (F2)")) browseFiles(state);
    if (rowButton("Keys (F1)", "All keys, and what the mouse does")) state.window.help = true;
    characterPanel(scene, state);
    constexpr ImGuiTreeNodeFlags kOpen = ImGuiTreeNodeFlags_DefaultOpen;
    if (state.inspect.picked && ImGui::CollapsingHeader("Vertex", kOpen)) vertexPanel(scene, *state.inspect.picked);
    if (shownFactor(scene, state) && ImGui::CollapsingHeader("Factors", kOpen)) factorPanel(scene, state);
    if (state.inspect.picked && ImGui::CollapsingHeader("Components", kOpen)) componentPanel(scene, state);
    if (!scene.characters[state.selected]->asset.mesh.morphs.empty() && ImGui::CollapsingHeader("Morph targets", kOpen))
        morphPanel(scene, state);
    if (scene.shaded()) drawControls(ControlPanel::kLook, scene, state);
    drawControls(ControlPanel::kShow, scene, state);
    savePanel(state);
    if (ImGui::CollapsingHeader("Asset")) assetPanel(*scene.characters[state.selected]);
    figurePanel(scene, state, figures);
}

}  // namespace

void buildReadingPanel(const std::string& file, float share, float unit) {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos(ImVec2(size.x / 2, size.y / 2), ImGuiCond_Always, ImVec2(0.5f, 0.5f));
    ImGui::SetNextWindowSize(ImVec2(std::min(420 * unit, size.x), 0));
    ImGui::Begin("reading", nullptr, kFixed);
    ImGui::Text("Reading %s", file.c_str());
    ImGui::ProgressBar(share);
    ImGui::End();
}

void buildFirstPanel(const FolderList& list, ViewState& state, const std::string& problem) {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    beginFixed("first", 0, 0, size.x, size.y);
    ImGui::PushTextWrapPos(0);
    ImGui::TextUnformatted("Choose a character (.pnb) or a scene (.json), or drop one here.");
    if (!problem.empty()) ImGui::TextColored(ImColor(kMarked), "%s", problem.c_str());
    filePanel(list, state);
    ImGui::PopTextWrapPos();
    ImGui::End();
}

void buildPanels(const Scene& scene, ViewState& state, const ViewFigures& figures, const Rectangle& picture,
                 float unit) {
    drawOverlays(scene, state, picture);
    drawMessage(figures.message, picture);
    if (state.window.hint) drawHint(picture);
    if (!showsPanels(state)) return;
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const PanelSizes panels = panelSizes(size.x, size.y, unit);
    // Each keeps its own place where it was scrolled to.
    beginFixed(state.window.browsed ? "files" : state.window.help ? "help" : "side", 0, 0, panels.side, size.y);
    ImGui::PushTextWrapPos(0);  // lines that are too long go on below
    if (state.window.browsed)
        filesBeside(*figures.folder, state);
    else if (state.window.help)
        helpPanel(state);
    else
        scenePanel(scene, state, figures);
    ImGui::PopTextWrapPos();
    ImGui::End();
    beginFixed("timeline", panels.side, size.y - panels.timeline, size.x - panels.side, panels.timeline);
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
            state.tool.dragged = DraggedCharacter{
                under->character, double(taken.posed.to_scene.point(taken.posed.vertices.positions[under->vertex]).y)};
        }
    if (!state.tool.dragged) return io.KeyAlt && isHeld(ImGuiMouseButton_Left);  // beside everyone it does nothing
    const auto at = [&](ImVec2 pointer) {
        return pointAtHeight(state, state.tool.dragged->height, picture, double(pointer.x), double(pointer.y));
    };
    const auto now = at(io.MousePos),
               before = at(ImVec2(io.MousePos.x - io.MouseDelta.x, io.MousePos.y - io.MouseDelta.y));
    if (now && before) state.characters[state.tool.dragged->character].moved += toFloat(*now - *before);
    if (!ImGui::IsMouseDown(ImGuiMouseButton_Left)) state.tool.dragged.reset();
    return true;
}

// Shapes the ground while the left button is down. Returns whether the button is the brush's.
bool useBrush(const Scene& scene, ViewState& state, const Rectangle& picture) {
    const ImGuiIO& io = ImGui::GetIO();
    if (!state.tool.brush.on || io.KeyCtrl || !isHeld(ImGuiMouseButton_Left)) return false;
    if (ImGui::IsMouseDown(ImGuiMouseButton_Left))
        state.tool.stroke = strokeUnder(scene, state, picture, double(io.MousePos.x), double(io.MousePos.y),
                                        double(io.KeyShift ? -io.DeltaTime : io.DeltaTime));
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
        state.inspect.picked = pick(scene, state, picture, double(io.MousePos.x), double(io.MousePos.y));
    if (io.MouseWheel != 0) dolly(state.camera, double(io.MouseWheel), boundsOf(scene).radius());
}

}  // namespace penumbra
