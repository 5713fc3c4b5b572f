#include "player/view/view_state.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "sh/angles.h"

namespace penumbra {

bool ViewContents::hasTruth() const {
    return std::any_of(characters.begin(), characters.end(), [](const CharacterContents& c) { return c.has_truth; });
}

bool ViewContents::bounces() const {
    return std::any_of(characters.begin(), characters.end(), [](const CharacterContents& c) { return c.bounces; });
}

bool ViewContents::composed() const {
    return std::any_of(characters.begin(), characters.end(), [](const CharacterContents& c) { return c.composed; });
}

bool ViewContents::hasOutlines() const {
    return composed() || std::ranges::any_of(characters, &CharacterContents::spheres);
}

std::size_t ViewContents::components() const {
    std::size_t most = 0;
    for (const CharacterContents& character : characters) most = std::max(most, character.components);
    return most;
}

namespace {

const ClipView& clipOf(const ViewState& state, const ViewContents& contents, std::size_t character) {
    return contents.characters[character].animation->clips[state.characters[character].clip];
}

}  // namespace

const ClipView& selectedClip(const ViewState& state, const ViewContents& contents) {
    return clipOf(state, contents, state.selected);
}

bool snapsToFrames(const ViewState& state) {
    const bool error = state.channel == Channel::kError && !state.component;
    return !state.smooth || error || shownCompare(state) != Compare::kModel;
}

namespace {

void showFrame(ViewState& state, const ViewContents& contents, std::size_t number) {
    state.playhead.playing = false;
    showClipTime(state,
                 frameSeconds(*contents.characters[state.selected].animation, selectedClip(state, contents), number));
}

// Goes to the frame with the largest figure. Where the figures are still those of a clip that was on before, it does
// nothing. Returns how many figures are known.
template <class Figures, class Projection>
std::size_t showLargest(ViewState& state, const ViewContents& contents, const Figures& figures, Projection projection) {
    if (figures.empty() || contents.characters[state.selected].strip_clip != state.characters[state.selected].clip)
        return 0;
    showFrame(state, contents, std::size_t(std::ranges::max_element(figures, {}, projection) - figures.begin()));
    return figures.size();
}

void showWorst(ViewState& state, const ViewContents& contents, bool out_of_range) {
    const CharacterContents& character = contents.characters[state.selected];
    state.awaited.reset();
    if (!out_of_range && !character.has_truth) return;
    state.playhead.playing = false;
    const std::size_t known = out_of_range ? showLargest(state, contents, character.out_of_range, std::identity())
                                           : showLargest(state, contents, character.errors, &FrameError::mean);
    if (known < selectedClip(state, contents).frame_count)
        state.awaited =
            AwaitedWorst{out_of_range, state.selected, state.characters[state.selected].clip, state.playhead.time};
}

}  // namespace

void showWorstError(ViewState& state, const ViewContents& contents) { showWorst(state, contents, false); }
void showWorstRange(ViewState& state, const ViewContents& contents) { showWorst(state, contents, true); }

namespace {

void showAwaited(ViewState& state, const ViewContents& contents) {
    if (!state.awaited) return;
    const bool out_of_range = state.awaited->out_of_range;
    const AwaitedWorst here{out_of_range, state.selected, state.characters[state.selected].clip, state.playhead.time};
    const CharacterContents& character = contents.characters[state.selected];
    const std::size_t known = out_of_range ? character.out_of_range.size() : character.errors.size();
    if (state.playhead.playing || *state.awaited != here)
        state.awaited.reset();
    else if (known >= selectedClip(state, contents).frame_count)
        showWorst(state, contents, out_of_range);
}

}  // namespace

ClipPosition shownPosition(const ViewState& state, const ViewContents& contents, std::size_t character) {
    const CharacterChoice& choice = state.characters[character];
    if (choice.still) return {};
    const ClipView& clip = clipOf(state, contents, character);
    const ClipPosition position =
        clipPosition(*contents.characters[character].animation, clip, state.playhead.time + choice.start);
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

void chooseChannel(ViewState& state, const ViewContents& contents, Channel channel) {
    if (channel == Channel::kShaded && !contents.shaded()) return;
    if (channel == Channel::kError && !contents.hasTruth()) return;
    if (channel == Channel::kParts && !contents.composed()) return;
    if (channel == Channel::kBouncedAmbient && !contents.bounces()) return;
    state.channel = channel;
    state.component.reset();
}

void chooseComponent(ViewState& state, const ViewContents& contents, std::size_t component) {
    if (component < contents.components()) state.component = component;
}

void chooseCompare(ViewState& state, const ViewContents& contents, Compare compare) {
    if (compare == Compare::kModel || contents.hasTruth()) state.compare = compare;
}

void chooseNextFactor(ViewState& state, const ViewContents& contents, bool back) {
    if (!state.picked) return;
    const std::span<const VisibilityFactor> factors = contents.characters[state.picked->character].factors;
    if (factors.empty()) return;
    const auto found = std::ranges::find(factors, state.factor, &VisibilityFactor::choice);
    const std::size_t at = found == factors.end() ? 0 : std::size_t(found - factors.begin());
    state.factor = factors[(at + (back ? factors.size() - 1 : 1)) % factors.size()].choice;
}

Compare shownCompare(const ViewState& state) {
    const bool compares = !state.component && (state.channel == Channel::kShaded || state.channel == Channel::kAmbient);
    return compares ? state.compare : Compare::kModel;
}

void dragLight(ViewState& state, double right, double down, double height) {
    state.light_yaw = std::remainder(state.light_yaw + 180 * right / height, 360);
    state.light_pitch = std::remainder(state.light_pitch - 180 * down / height, 360);
}

// R = R_y(yaw) R_x(-pitch): +z rises towards +y, then moves towards +x.
Mat3 lightRotation(const ViewState& state) {
    const double yaw = radians(state.light_yaw), pitch = radians(state.light_pitch);
    const double sy = std::sin(yaw), cy = std::cos(yaw), sp = std::sin(pitch), cp = std::cos(pitch);
    const Mat3d about_y{{cy, 0, sy, 0, 1, 0, -sy, 0, cy}}, about_x{{1, 0, 0, 0, cp, sp, 0, -sp, cp}};
    const Mat3d r = about_y * about_x * toDouble(state.light_base);
    Mat3 out;
    for (std::size_t i = 0; i < 9; ++i) out.m[i] = float(r.m[i]);
    return out;
}

void advanceView(ViewState& state, const ViewContents& contents, double seconds) {
    showAwaited(state, contents);
    state.playhead.smooth = !snapsToFrames(state);
    advance(state.playhead, *contents.characters[state.selected].animation, selectedClip(state, contents), seconds);
}

}  // namespace penumbra
