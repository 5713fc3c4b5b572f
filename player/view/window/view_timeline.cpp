#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "player/frame/truth_frames.h"
#include "player/view/window/view_widgets.h"

namespace penumbra {
namespace {

// Figures below these fill their strip only in part: they are rounding, the margin of training ranges, or errors that
// nobody sees.
constexpr float kSmallRange = 0.05f;   // about radians
constexpr float kSmallError = 0.004f;  // error of ambient visibility

constexpr ImU32 kBed = IM_COL32(30, 34, 40, 255), kInk = IM_COL32(230, 230, 230, 255);
constexpr ImU32 kRangeColor = IM_COL32(235, 140, 40, 255), kErrorColor = IM_COL32(214, 72, 96, 255);

// A row in which every frame has a cell of the same width, from where it is to where the next one is.
struct Row {
    ImVec2 corner, size;
    std::size_t frames;
    float left(double number) const { return corner.x + size.x * float(number / double(frames)); }
    double numberAt(float x) const { return std::clamp(double((x - corner.x) / size.x), 0.0, 1.0) * double(frames); }
    std::size_t frameAt(float x) const { return std::min(std::size_t(numberAt(x)), frames - 1); }
};

// Begins a row with its name at the left, which says more while the pointer rests on it.
Row beginRow(const char* name, const char* tip, std::size_t frames, float height) {
    const float column = std::min(7.5f * ImGui::GetFontSize(), 0.36f * ImGui::GetContentRegionAvail().x);
    const float left = ImGui::GetCursorPosX();
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(name);
    if (ImGui::IsItemHovered()) tooltip(tip);
    ImGui::SameLine(left + column);
    const Row row{ImGui::GetCursorScreenPos(), ImVec2(ImGui::GetContentRegionAvail().x, height), frames};
    ImGui::InvisibleButton(name, row.size);
    ImGui::GetWindowDrawList()->AddRectFilled(row.corner, ImVec2(row.corner.x + row.size.x, row.corner.y + height),
                                              kBed);
    return row;
}

void playheadLine(const Row& row, double number) {
    const float x = row.left(number);
    ImGui::GetWindowDrawList()->AddLine(ImVec2(x, row.corner.y), ImVec2(x, row.corner.y + row.size.y), kInk, 2);
}

// Draws ticks at whole frames, as far apart as their numbers need.
void frameNumbers(const Row& row) {
    const float room = 3.5f * ImGui::GetFontSize();
    std::size_t step = 1;
    for (std::size_t i = 0; row.size.x * float(step) / float(row.frames) < room && step < row.frames; ++i)
        step *= i % 3 == 1 ? 5 : 2;  // 1, 2, 10, 20, 40, 200: round enough
    ImDrawList& list = *ImGui::GetWindowDrawList();
    for (std::size_t frame = 0; frame < row.frames; frame += step) {
        const float x = row.left(double(frame));
        list.AddLine(ImVec2(x, row.corner.y), ImVec2(x, row.corner.y + row.size.y), IM_COL32(90, 96, 105, 255));
        const std::string number = std::to_string(frame);
        if (x + 3 + ImGui::CalcTextSize(number.c_str()).x <= row.corner.x + row.size.x)
            list.AddText(ImVec2(x + 3, row.corner.y + 2), IM_COL32(190, 195, 202, 255), number.c_str());
    }
}

void jumpTo(const Scene& scene, ViewState& state, double number) {
    state.playhead.playing = false;
    showClipTime(state, positionSeconds(scene.characters[state.selected]->asset.animation, selectedClip(state, scene),
                                        snapsToFrames(state) ? std::floor(number) : number));
}

void scrubBar(const Scene& scene, ViewState& state, std::size_t frames, double shown) {
    const Row row = beginRow("frame", "Drag or click to go to a frame", frames, 1.5f * ImGui::GetFontSize());
    if (ImGui::IsItemActive()) jumpTo(scene, state, row.numberAt(ImGui::GetIO().MousePos.x));
    ImGui::GetWindowDrawList()->AddRectFilled(ImVec2(row.left(std::floor(shown)), row.corner.y),
                                              ImVec2(row.left(std::floor(shown) + 1), row.corner.y + row.size.y),
                                              IM_COL32(66, 110, 170, 255));
    frameNumbers(row);
    playheadLine(row, shown);
}

// A strip shows this figure of each frame that is known.
struct Figure {
    const char *name, *tip;
    ImU32 color;
    float small;
    std::size_t known;
    std::function<float(std::size_t)> value;
    std::function<std::string(std::size_t)> text;  // under the pointer
    std::string missing = {};                      // why no frame has one
};

// A strip has this range of figures: from one that all frames reach to the largest. A clip whose figures are
// alike shows them low, and not as a slab.
struct StripRange {
    float low = 0, high = 0;
};

StripRange rangeOf(const Figure& figure) {
    StripRange range;
    if (figure.known == 0) return {0, figure.small};
    range.low = range.high = figure.value(0);
    for (std::size_t i = 1; i < figure.known; ++i) {
        range.low = std::min(range.low, figure.value(i));
        range.high = std::max(range.high, figure.value(i));
    }
    range.low *= 0.8f;
    range.high = std::max(range.high, range.low + figure.small);
    return range;
}

// Draws a column for each frame, or for each pixel where there are more frames than pixels, with the largest of its
// frames.
void columns(const Row& row, const Figure& figure, const StripRange& range) {
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const std::size_t count = std::min(row.frames, std::size_t(std::max(1.0f, row.size.x)));
    for (std::size_t c = 0; c < count; ++c) {
        const std::size_t begin = c * row.frames / count, end = std::min((c + 1) * row.frames / count, figure.known);
        float value = 0;
        for (std::size_t frame = begin; frame < end; ++frame) value = std::max(value, figure.value(frame));
        const float part = (value - range.low) / (range.high - range.low), below = row.corner.y + row.size.y;
        if (part > 0)
            list.AddRectFilled(ImVec2(row.left(double(begin)), below - row.size.y * part),
                               ImVec2(row.left(double((c + 1) * row.frames / count)), below), figure.color);
    }
}

// Writes a note at the right end, where the last frames will be.
void noteAtEnd(const Row& row, const std::string& note) {
    const ImVec2 size = ImGui::CalcTextSize(note.c_str());
    const float right = row.corner.x + row.size.x, left = right - size.x - 8;
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(ImVec2(left, row.corner.y), ImVec2(right, row.corner.y + row.size.y), kBed);
    list.AddText(ImVec2(left + 4, row.corner.y + 0.5f * (row.size.y - size.y)), kInk, note.c_str());
}

void strip(const Scene& scene, ViewState& state, const Figure& figure, std::size_t frames, double shown) {
    const Row row = beginRow(figure.name, figure.tip, frames, 1.5f * ImGui::GetFontSize());
    std::size_t worst = 0;
    for (std::size_t i = 0; i < figure.known; ++i)
        if (figure.value(i) > figure.value(worst)) worst = i;
    columns(row, figure, rangeOf(figure));
    playheadLine(row, shown);
    if (!figure.missing.empty())
        noteAtEnd(row, figure.missing);
    else if (figure.known < frames)
        noteAtEnd(row, std::to_string(100 * figure.known / frames) + "%");
    if (!ImGui::IsItemHovered() && !ImGui::IsItemActive()) return;
    const std::size_t frame = row.frameAt(ImGui::GetIO().MousePos.x);
    if (ImGui::IsItemActive()) jumpTo(scene, state, double(frame));
    if (frame < figure.known)
        ImGui::SetTooltip("frame %zu: %s\nlargest of the clip: %.3g, in frame %zu", frame, figure.text(frame).c_str(),
                          double(figure.value(worst)), worst);
}

std::string format(const char* text, auto... values) {
    char out[96];
    std::snprintf(out, sizeof out, text, values...);
    return out;
}

void strips(const Scene& scene, ViewState& state, std::size_t frames, double shown) {
    const Character& character = *scene.characters[state.selected];
    const std::vector<float>& range = character.timeline.figures.out_of_range;
    strip(
        scene, state,
        {"out of range",
         "How far each frame's pose is from the poses that the model was trained on, about in radians. Shift + W goes "
         "to the farthest one.",
         kRangeColor, kSmallRange, range.size(), [&](std::size_t i) { return range[i]; },
         [&](std::size_t i) { return format("out of the training poses by %.3f rad", double(range[i])); }},
        frames, shown);
    if (!character.truth) return;
    const bool has_truth = hasTruthOf(character.asset, *character.truth, selectedClip(state, scene));
    const std::vector<FrameError>& errors = character.timeline.figures.errors;
    strip(scene, state,
          {"error",
           "The mean error of each frame's ambient visibility against the baked truth. W goes to the largest one.",
           kErrorColor, kSmallError, errors.size(), [&](std::size_t i) { return errors[i].mean; },
           [&](std::size_t i) {
               if (!errors[i].has_truth) return std::string("not in the baked truth");
               return format("|E - truth| mean %.4f, worst vertex %.3f", double(errors[i].mean),
                             double(errors[i].most));
           },
           has_truth ? "" : "no baked truth of this clip"},
          frames, shown);
}

// A button that goes on in the line, unless the window is too narrow for it. Returns whether it was clicked.
bool buttonIfRoom(const char* name, const char* tip) {
    ImGui::SameLine(0, ImGui::GetFontSize());
    const float width = ImGui::CalcTextSize(name).x + 2 * ImGui::GetStyle().FramePadding.x;
    if (width > ImGui::GetContentRegionAvail().x) {
        ImGui::NewLine();
        return false;
    }
    const bool clicked = ImGui::Button(name);
    if (ImGui::IsItemHovered()) tooltip(tip);
    return clicked;
}

// Goes on in a line with a text, unless the window is too narrow for all of it. Returns whether it was written.
bool textIfRoom(const std::string& text, ImU32 color) {
    ImGui::SameLine(0, ImGui::GetFontSize());
    const bool room = ImGui::CalcTextSize(text.c_str()).x <= ImGui::GetContentRegionAvail().x;
    if (room)
        ImGui::TextColored(ImColor(color), "%s", text.c_str());
    else
        ImGui::NewLine();
    return room;
}

// Shows where the errors of a clip with truth are the largest, and how large they are now.
void worstPlaces(const Scene& scene, ViewState& state, std::size_t frame) {
    if (buttonIfRoom("worst frame", "Goes to the frame whose mean error is the largest (W)"))
        showWorst(state, scene, Worst::kError);
    if (buttonIfRoom("worst point",
                     "Shows errors (3), and picks the vertex whose error is the largest in this frame")) {
        chooseChannel(state, scene, Channel::kError);
        state.window.worst_point = true;
    }
    const ClipFigures& figures = scene.characters[state.selected]->timeline.figures;
    if (figures.clip != state.characters[state.selected].clip || frame >= figures.errors.size()) return;
    const FrameError& error = figures.errors[frame];
    if (error.has_truth) textIfRoom(format("error %.4f, max %.3f", double(error.mean), double(error.most)), kInk);
}

}  // namespace

void buildTimeline(const Scene& scene, ViewState& state) {
    const AnimationView& animation = scene.characters[state.selected]->asset.animation;
    const ClipView& clip = selectedClip(state, scene);
    if (ImGui::Button(state.playhead.playing ? "Pause" : "Play", ImVec2(ImGui::GetFontSize() * 5, 0)))
        state.playhead.playing = !state.playhead.playing;
    ImGui::SameLine();
    drawControls(ControlPanel::kTime, scene, state,
                 std::min(9 * ImGui::GetFontSize(), 0.28f * ImGui::GetWindowWidth()));
    const ClipPosition position = shownPosition(state, scene, state.selected);
    const double shown = double(position.frame) + position.part;
    const std::string frame = format("frame %.*f of %u", snapsToFrames(state) ? 0 : 2, shown, clip.frame_count);
    if (!textIfRoom(frame, kInk)) textIfRoom(format("%.*f of %u", 0, std::floor(shown), clip.frame_count), kInk);
    const Character& character = *scene.characters[state.selected];
    if (character.truth && hasTruthOf(character.asset, *character.truth, clip))
        worstPlaces(scene, state, position.frame);
    textIfRoom(format("%.2f s of %.2f s", clipTime(state), clipSeconds(animation, clip)), kInk);
    scrubBar(scene, state, clip.frame_count, shown);
    strips(scene, state, clip.frame_count, shown);
}

}  // namespace penumbra
