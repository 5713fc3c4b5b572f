#include "player/view/view_state.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "player/frame/truth_frames.h"
#include "player/view/view_scene.h"
#include "sh/angles.h"

namespace penumbra {

namespace {

const ClipView& clipOf(const ViewState& state, const Scene& scene, std::size_t character) {
    return scene.characters[character]->asset.animation.clips[state.characters[character].clip];
}

}  // namespace

const ClipView& selectedClip(const ViewState& state, const Scene& scene) {
    return clipOf(state, scene, state.selected);
}

bool snapsToFrames(const ViewState& state) {
    const bool error = state.show.channel == Channel::kError && !state.show.component;
    return !state.smooth || error || shownCompare(state) != Compare::kModel;
}

namespace {

void showFrame(ViewState& state, const Scene& scene, std::size_t number) {
    state.playhead.playing = false;
    showClipTime(state,
                 frameSeconds(scene.characters[state.selected]->asset.animation, selectedClip(state, scene), number));
}

// Goes to the frame with the largest figure. Returns how many figures are known.
std::size_t showLargest(ViewState& state, const Scene& scene, const auto& figures, auto projection) {
    if (!figures.empty())
        showFrame(state, scene, std::size_t(std::ranges::max_element(figures, {}, projection) - figures.begin()));
    return figures.size();
}

// Returns the selected character's figures: none where they are still those of a clip that was on before.
const ClipFigures& knownFigures(const ViewState& state, const Scene& scene) {
    static const ClipFigures kNone;
    const ClipFigures& figures = scene.characters[state.selected]->timeline.figures;
    return figures.clip == state.characters[state.selected].clip ? figures : kNone;
}

}  // namespace

void showWorst(ViewState& state, const Scene& scene, Worst by) {
    const ClipFigures& figures = knownFigures(state, scene);
    state.awaited.reset();
    const Character& character = *scene.characters[state.selected];
    if (by == Worst::kError &&
        (!character.truth || !hasTruthOf(character.asset, *character.truth, selectedClip(state, scene))))
        return;
    state.playhead.playing = false;
    const std::size_t known = by == Worst::kOutOfRange
                                  ? showLargest(state, scene, figures.out_of_range, std::identity())
                                  : showLargest(state, scene, figures.errors, &FrameError::mean);
    if (known < selectedClip(state, scene).frame_count)
        state.awaited = AwaitedWorst{by, state.selected, state.characters[state.selected].clip, state.playhead.time};
}

void pickWorst(ViewState& state, const Scene& scene) {
    const Character& character = *scene.characters[state.selected];
    const std::span<const Vec3> errors = character.shown.of(Shown::kModel);  // alike in all three channels
    if (character.shown.channel != Channel::kError || !*character.posed.truth_frame || errors.empty()) return;
    const auto worst = std::ranges::max_element(errors, {}, &Vec3::x);
    state.inspect.picked = PickedVertex{state.selected, std::size_t(worst - errors.begin())};
}

namespace {

void showAwaited(ViewState& state, const Scene& scene) {
    if (!state.awaited) return;
    const Worst by = state.awaited->by;
    const AwaitedWorst here{by, state.selected, state.characters[state.selected].clip, state.playhead.time};
    const ClipFigures& figures = knownFigures(state, scene);
    const std::size_t known = by == Worst::kOutOfRange ? figures.out_of_range.size() : figures.errors.size();
    if (state.playhead.playing || *state.awaited != here)
        state.awaited.reset();
    else if (known >= selectedClip(state, scene).frame_count)
        showWorst(state, scene, by);
}

}  // namespace

ClipPosition shownPosition(const ViewState& state, const Scene& scene, std::size_t character) {
    const CharacterChoice& choice = state.characters[character];
    if (choice.still) return {};
    const ClipView& clip = clipOf(state, scene, character);
    const ClipPosition position =
        clipPosition(scene.characters[character]->asset.animation, clip, state.playhead.time + choice.start);
    if (!snapsToFrames(state)) return position;
    return {position.frame, position.frame, 0};
}

double clipTime(const ViewState& state) { return state.playhead.time + state.characters[state.selected].start; }
void showClipTime(ViewState& state, double seconds) {
    state.playhead.time = seconds - state.characters[state.selected].start;
}

void chooseClip(ViewState& state, std::size_t clip) {
    CharacterChoice& choice = state.characters[state.selected];
    choice.clip = clip;
    choice.start = 0;
    choice.still = false;
    state.playhead.time = 0;
}

void chooseMaterial(ViewState& state, std::size_t material) {
    std::vector<std::size_t>& slots = state.characters[state.selected].material_of_slot;
    if (state.slot < slots.size())
        slots[state.slot] = material;
    else
        std::fill(slots.begin(), slots.end(), material);
}

std::size_t chosenMaterial(const ViewState& state) {
    const std::vector<std::size_t>& slots = state.characters[state.selected].material_of_slot;
    return slots[state.slot < slots.size() ? state.slot : 0];
}

bool hasChannel(const Scene& scene, Channel channel) {
    if (channel == Channel::kShaded) return scene.shaded();
    if (channel == Channel::kParts) return scene.composed();
    if (channel == Channel::kBouncedAmbient) return scene.bounces();
    return channel != Channel::kError || scene.hasTruth();
}

void chooseChannel(ViewState& state, const Scene& scene, Channel channel) {
    if (!hasChannel(scene, channel)) return;
    state.show.channel = channel;
    state.show.component.reset();
}

void chooseNextFactor(ViewState& state, const Scene& scene, int step) {
    if (!state.inspect.picked) return;
    const std::vector<VisibilityFactor>& factors = *scene.characters[state.inspect.picked->character]->posed.factors;
    if (factors.empty()) return;
    const auto found = std::ranges::find(factors, state.inspect.factor, &VisibilityFactor::choice);
    const std::size_t at = found == factors.end() ? 0 : std::size_t(found - factors.begin());
    state.inspect.factor = factors[(at + factors.size() + std::size_t(step)) % factors.size()].choice;
}

bool canCompare(const ViewState& state) {
    return !state.show.component && (state.show.channel == Channel::kShaded || state.show.channel == Channel::kAmbient);
}

Compare shownCompare(const ViewState& state) { return canCompare(state) ? state.show.compare : Compare::kModel; }

void dragLight(ViewState& state, double right, double down, double height) {
    state.lighting.yaw = std::remainder(state.lighting.yaw + 180 * right / height, 360);
    state.lighting.pitch = std::remainder(state.lighting.pitch - 180 * down / height, 360);
}

// R = R_y(yaw) R_x(-pitch): +z rises towards +y, then moves towards +x.
Mat3 lightRotation(const ViewState& state) {
    const double yaw = radians(state.lighting.yaw), pitch = radians(state.lighting.pitch);
    const double sy = std::sin(yaw), cy = std::cos(yaw), sp = std::sin(pitch), cp = std::cos(pitch);
    const Mat3d about_y{{cy, 0, sy, 0, 1, 0, -sy, 0, cy}}, about_x{{1, 0, 0, 0, cp, sp, 0, -sp, cp}};
    const Mat3d r = about_y * about_x * toDouble(state.lighting.base);
    Mat3 out;
    for (std::size_t i = 0; i < 9; ++i) out.m[i] = float(r.m[i]);
    return out;
}

void advanceView(ViewState& state, const Scene& scene, double seconds) {
    showAwaited(state, scene);
    state.playhead.smooth = !snapsToFrames(state);
    advance(state.playhead, scene.characters[state.selected]->asset.animation, selectedClip(state, scene), seconds);
}

}  // namespace penumbra
