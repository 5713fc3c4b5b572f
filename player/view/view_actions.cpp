#include "player/view/view_actions.h"

#include <algorithm>
#include <array>

#include "player/view/view_cast_way.h"
#include "player/view/view_exposure.h"

namespace penumbra {
namespace {

// Returns the next of `count`, or the one before, round the ends.
std::size_t next(std::size_t index, std::size_t count, bool back) {
    return count == 0 ? 0 : (index + (back ? count - 1 : 1)) % count;
}

const AnimationView& animationOf(const ViewState& state, const ViewContents& contents) {
    return *contents.characters[state.selected].animation;
}

void play(ViewState& state, const ViewContents&, bool) { state.playhead.playing = !state.playhead.playing; }

template <int kFrames>
void step(ViewState& state, const ViewContents& contents, bool shift) {
    // Stepping back from between two frames, the first of the two is one step.
    const bool between = kFrames < 0 && shownPosition(state, contents, state.selected).part > 0;
    Playhead in_clip = state.playhead;
    in_clip.time = clipTime(state);
    stepFrames(in_clip, animationOf(state, contents), selectedClip(state, contents),
               (shift ? 10 * kFrames : kFrames) + (between ? 1 : 0));
    state.playhead.playing = in_clip.playing;
    showClipTime(state, in_clip.time);
}

void rewind(ViewState& state, const ViewContents&, bool) { showClipTime(state, 0); }

void worst(ViewState& state, const ViewContents& contents, bool out_of_range) {
    out_of_range ? showWorstRange(state, contents) : showWorstError(state, contents);
}

void smooth(ViewState& state, const ViewContents&, bool) { state.smooth = !state.smooth; }

void faster(ViewState& state, const ViewContents&, bool) {
    state.playhead.speed = std::min(8.0, 2 * state.playhead.speed);
}
void slower(ViewState& state, const ViewContents&, bool) {
    state.playhead.speed = std::max(0.125, state.playhead.speed / 2);
}

template <bool kBack>
void otherClip(ViewState& state, const ViewContents& contents, bool) {
    const std::size_t clips = animationOf(state, contents).clips.size();
    chooseClip(state, next(state.characters[state.selected].clip, clips, kBack));
}

void otherMaterial(ViewState& state, const ViewContents& contents, bool back) {
    if (contents.materials > 0) chooseMaterial(state, next(chosenMaterial(state), contents.materials, back));
}

void otherSlot(ViewState& state, const ViewContents& contents, bool back) {
    const std::size_t slots = contents.characters[state.selected].slots;
    state.slot = next(std::min(state.slot, slots), slots + 1, back);  // the last one: all of them
}

void otherLight(ViewState& state, const ViewContents& contents, bool back) {
    state.light = next(state.light, contents.lights, back);
}

void otherLightForm(ViewState& state, const ViewContents&, bool back) {
    state.shading.light_form = LightForm(next(std::size_t(state.shading.light_form), 3, back));
}
void otherReflectance(ViewState& state, const ViewContents&, bool) {
    state.shading.reflectance =
        state.shading.reflectance == Reflectance::kSlices ? Reflectance::kOperators : Reflectance::kSlices;
}

void unturnLight(ViewState& state, const ViewContents&, bool) { state.light_yaw = state.light_pitch = 0; }

void suns(ViewState& state, const ViewContents&, bool) { state.suns = !state.suns; }

void otherBounces(ViewState& state, const ViewContents& contents, bool back) {
    if (contents.bounces()) state.bounces = Bounces(next(std::size_t(state.bounces), 3, back));
}

void brighter(ViewState& state, const ViewContents&, bool automatic) {
    if (automatic)
        state.automatic_exposure = true;
    else
        fixExposure(state, state.display.exposure * 1.25f);
}
void darker(ViewState& state, const ViewContents&, bool) { fixExposure(state, state.display.exposure / 1.25f); }

void otherToneMap(ViewState& state, const ViewContents&, bool back) {
    state.display.tone_map = ToneMap(next(std::size_t(state.display.tone_map), 3, back));
}

void toggleTruth(ViewState& state, const ViewContents& contents, bool) {
    chooseCompare(state, contents, state.compare == Compare::kTruth ? Compare::kModel : Compare::kTruth);
}
void otherCompare(ViewState& state, const ViewContents& contents, bool back) {
    chooseCompare(state, contents, Compare(next(std::size_t(state.compare), 5, back)));
}

template <Channel kChannel>
void channel(ViewState& state, const ViewContents& contents, bool) {
    chooseChannel(state, contents, kChannel);
}

void component(ViewState& state, const ViewContents& contents, bool back) {
    const std::size_t most = contents.components();
    if (most > 0) chooseComponent(state, contents, state.component ? next(*state.component, most, back) : 0);
}
void smallerError(ViewState& state, const ViewContents&, bool) {
    state.error_max = std::max(1e-3f, state.error_max / 1.25f);
}
void largerError(ViewState& state, const ViewContents&, bool) {
    state.error_max = std::min(1.0f, state.error_max * 1.25f);
}
void otherFactor(ViewState& state, const ViewContents& contents, bool back) { chooseNextFactor(state, contents, back); }
void boxes(ViewState& state, const ViewContents&, bool) { state.boxes = !state.boxes; }
void frames(ViewState& state, const ViewContents&, bool) { state.frames = !state.frames; }
void unedit(ViewState& state, const ViewContents&, bool) { state.score_edit.reset(); }
void otherShadows(ViewState& state, const ViewContents&, bool back) {
    state.shadows = Shadows(next(std::size_t(state.shadows), 4, back));
}
void otherCastMode(ViewState& state, const ViewContents& contents, bool back) {
    chooseNextCastMode(state, contents, back);
}
void unpick(ViewState& state, const ViewContents&, bool) { state.picked.reset(); }

void frameScene(ViewState& state, const ViewContents&, bool) { state.frame_all = true; }
void turn(ViewState& state, const ViewContents&, bool) { state.turntable = !state.turntable; }
void panels(ViewState& state, const ViewContents&, bool) { state.panels = !state.panels; }
void help(ViewState& state, const ViewContents&, bool) { state.help = !state.help; }
void closeHelp(ViewState& state, const ViewContents&, bool) {
    state.help = false;
    state.sequence.reset();
}
void sequence(ViewState& state, const ViewContents&, bool) { state.sequence = 0; }
void background(ViewState& state, const ViewContents&, bool) { state.background = !state.background; }
void ground(ViewState& state, const ViewContents&, bool) { state.ground = !state.ground; }
void brush(ViewState& state, const ViewContents& contents, bool) {
    state.brush.on = contents.heights && !state.brush.on;
}
template <bool kMore>
void otherBrush(ViewState& state, const ViewContents&, bool strength) {
    double& size = strength ? state.brush.strength : state.brush.radius;
    size = std::clamp(kMore ? size * 1.25 : size / 1.25, kMinBrush, kMaxBrush);
}
void quit(ViewState& state, const ViewContents&, bool) { state.quit = true; }
void screenshot(ViewState& state, const ViewContents&, bool shift) {
    state.screenshot = true;
    state.screenshot_panels = !shift;
}

constexpr std::array kShortcuts = {
    Shortcut{' ', "Space", "", "play or pause", play},
    Shortcut{kKeyRight, "Right", "10 frames", "next frame", step<1>},
    Shortcut{kKeyLeft, "Left", "10 frames", "previous frame", step<-1>},
    Shortcut{kKeyHome, "Home", "", "first frame", rewind},
    Shortcut{'W', "W", "farthest out of range", "the clip's frame of the largest error", worst},
    Shortcut{'I', "I", "", "interpolate between sampled frames, or snap to them", smooth},
    Shortcut{kKeyUp, "Up", "", "twice as fast", faster},
    Shortcut{kKeyDown, "Down", "", "half as fast", slower},
    Shortcut{kKeyPageDown, "Page Down", "", "next clip", otherClip<false>},
    Shortcut{kKeyPageUp, "Page Up", "", "previous clip", otherClip<true>},
    Shortcut{'M', "M", "previous", "next material of the chosen slot", otherMaterial},
    Shortcut{'S', "S", "previous", "next slot, or all slots", otherSlot},
    Shortcut{'L', "L", "previous", "next light", otherLight},
    Shortcut{'K', "K", "", "light as it came, not turned", unturnLight},
    Shortcut{'H', "H", "", "suns of the light with shadow maps, or all light as SH", suns},
    Shortcut{'V', "V", "previous", "next form of the light: lobes, fixed lobes, exact rotation", otherLightForm},
    Shortcut{'P', "P", "", "reflectance as slices or as operators", otherReflectance},
    Shortcut{'E', "E", "automatic exposure", "brighter", brighter},
    Shortcut{'D', "D", "", "darker", darker},
    Shortcut{'O', "O", "previous", "next tone mapping", otherToneMap},
    Shortcut{'T', "T", "", "baked truth or model", toggleTruth},
    Shortcut{'C', "C", "previous", "next way to compare with the truth", otherCompare},
    Shortcut{'1', "1", "", "shaded", channel<Channel::kShaded>},
    Shortcut{'2', "2", "", "ambient visibility", channel<Channel::kAmbient>},
    Shortcut{'3', "3", "", "error against the truth", channel<Channel::kError>},
    Shortcut{'4', "4", "", "clusters", channel<Channel::kClusters>},
    Shortcut{'5', "5", "", "normals", channel<Channel::kNormals>},
    Shortcut{'6', "6", "previous", "PCA component, the next one", component},
    Shortcut{'7', "7", "", "rigid parts of composed characters", channel<Channel::kParts>},
    Shortcut{'8', "8", "", "ambient visibility with light that bounces", channel<Channel::kBouncedAmbient>},
    Shortcut{'9', "9", "previous", "next light: all, direct light, light that bounces", otherBounces},
    Shortcut{'[', "[", "", "error scale to a smaller number", smallerError},
    Shortcut{']', "]", "", "error scale to a larger number", largerError},
    Shortcut{'N', "N", "", "normals and tangents as lines", frames},
    Shortcut{'U', "U", "", "boxes of fields, or spheres, that characters cast by", boxes},
    Shortcut{'Y', "Y", "previous", "lobe of the next factor of the picked vertex", otherFactor},
    Shortcut{'X', "X", "", "no vertex picked", unpick},
    Shortcut{'Z', "Z", "", "scores as the pose has them, not changed", unedit},
    Shortcut{'F', "F", "", "frame everything", frameScene},
    Shortcut{'R', "R", "", "turntable", turn},
    Shortcut{'B', "B", "", "background of the light", background},
    Shortcut{'G', "G", "", "ground plane", ground},
    Shortcut{'0', "0", "", "brush for a ground with heights: left drag raises, Shift + left drag lowers", brush},
    Shortcut{',', ",", "weaker brush", "smaller brush", otherBrush<false>},
    Shortcut{'.', ".", "stronger brush", "larger brush", otherBrush<true>},
    Shortcut{'J', "J", "previous", "next shadows: of all, on itself, on others, none", otherShadows},
    Shortcut{'A', "A", "previous",
             "next way that shadows of others join: product, folded, Nowrouzezahrai 2009 and 2011", otherCastMode},
    Shortcut{kKeyTab, "Tab", "", "panels", panels},
    Shortcut{kKeyF12, "F12", "without panels", "screenshot", screenshot},
    Shortcut{kKeyF11, "F11", "", "pictures of all frames of the clip", sequence},
    Shortcut{kKeyF1, "F1", "", "this help", help},
    Shortcut{kKeyEscape, "Escape", "", "close the help, stop pictures", closeHelp},
    Shortcut{'Q', "Q", "", "quit", quit},
};

}  // namespace

std::span<const Shortcut> shortcuts() { return kShortcuts; }

bool applyKey(ViewState& state, const ViewContents& contents, KeyPress press) {
    for (const Shortcut& shortcut : kShortcuts)
        if (shortcut.key == press.key) {
            shortcut.apply(state, contents, press.shift);
            return true;
        }
    return false;
}

}  // namespace penumbra
