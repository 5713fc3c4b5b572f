#include "player/view/view_actions.h"

#include <algorithm>
#include <array>

#include "player/view/view_controls.h"
#include "player/view/view_look.h"
#include "player/view/view_scene.h"

namespace penumbra {
namespace {

template <const Menu& kMenu>
void next(ViewState& state, const Scene& scene, KeyPress press) {
    chooseNext(kMenu, state, scene, press.shift ? -1 : 1);
}
template <int kStep>
void otherClip(ViewState& state, const Scene& scene, KeyPress) {
    chooseNext(kClipMenu, state, scene, kStep);
}

template <auto kFirst, auto... kMembers>
void toggle(ViewState& state, const Scene&, KeyPress) {
    bool& on = ((state.*kFirst).*....*kMembers);
    on = !on;
}

template <int kFrames>
void step(ViewState& state, const Scene& scene, KeyPress press) {
    // Stepping back from between two frames, the first of the two is one step.
    const bool between = kFrames < 0 && shownPosition(state, scene, state.selected).part > 0;
    Playhead in_clip = state.playhead;
    in_clip.time = clipTime(state);
    stepFrames(in_clip, scene.characters[state.selected]->asset.animation, selectedClip(state, scene),
               (press.shift ? 10 * kFrames : kFrames) + (between ? 1 : 0));
    state.playhead.playing = in_clip.playing;
    showClipTime(state, in_clip.time);
}

void rewind(ViewState& state, const Scene&, KeyPress) { showClipTime(state, 0); }

void faster(ViewState& state, const Scene&, KeyPress) {
    state.playhead.speed = std::min(8.0, 2 * state.playhead.speed);
}
void slower(ViewState& state, const Scene&, KeyPress) {
    state.playhead.speed = std::max(0.125, state.playhead.speed / 2);
}

void unturnLight(ViewState& state, const Scene&, KeyPress) { state.lighting.yaw = state.lighting.pitch = 0; }

void brighter(ViewState& state, const Scene&, KeyPress press) {
    if (press.shift)
        state.automatic_exposure = true;
    else
        fixExposure(state, state.display.exposure * 1.25f);
}
void darker(ViewState& state, const Scene&, KeyPress) { fixExposure(state, state.display.exposure / 1.25f); }

void toggleTruth(ViewState& state, const Scene& scene, KeyPress) {
    if (scene.hasTruth() && canCompare(state))
        state.show.compare = state.show.compare == Compare::kTruth ? Compare::kModel : Compare::kTruth;
}
void otherCompare(ViewState& state, const Scene& scene, KeyPress press) {
    if (canCompare(state)) next<kCompareMenu>(state, scene, press);
}

template <Channel kChannel>
void channel(ViewState& state, const Scene& scene, KeyPress) {
    chooseChannel(state, scene, kChannel);
}

void component(ViewState& state, const Scene& scene, KeyPress press) {
    const std::size_t count = scene.components();
    if (count == 0) return;
    std::optional<std::size_t>& shown = state.show.component;
    shown = shown ? (*shown + (press.shift ? count - 1 : 1)) % count : 0;
}
void smallerError(ViewState& state, const Scene&, KeyPress) {
    state.show.error_max = std::max(1e-3f, state.show.error_max / 1.25f);
}
void largerError(ViewState& state, const Scene&, KeyPress) {
    state.show.error_max = std::min(1.0f, state.show.error_max * 1.25f);
}
void unedit(ViewState& state, const Scene&, KeyPress) { state.inspect.score_edit.reset(); }
void unpick(ViewState& state, const Scene&, KeyPress) { state.inspect.picked.reset(); }

void frameScene(ViewState& state, const Scene&, KeyPress) { state.frame_all = true; }
void nextFactor(ViewState& state, const Scene& scene, KeyPress press) {
    chooseNextFactor(state, scene, press.shift ? -1 : 1);
}
void worst(ViewState& state, const Scene& scene, KeyPress press) {
    showWorst(state, scene, press.shift ? Worst::kOutOfRange : Worst::kError);
}
void closeHelp(ViewState& state, const Scene&, KeyPress) {
    state.window.help = false;
    state.window.browsed.reset();
    state.window.sequence.reset();
}
void sequence(ViewState& state, const Scene&, KeyPress press) {
    state.window.of = press.shift ? Sequence::kTurntable : Sequence::kClip;
    state.window.sequence = 0;
}
void undo(ViewState& state, const Scene&, KeyPress press) { state.window.undone += press.shift ? 1 : -1; }
void browse(ViewState& state, const Scene&, KeyPress) {
    if (state.window.browsed)
        state.window.browsed.reset();
    else
        browseFiles(state);
}
void help(ViewState& state, const Scene&, KeyPress) {
    state.window.help = !state.window.help || state.window.browsed;
    state.window.browsed.reset();
}
void brush(ViewState& state, const Scene& scene, KeyPress) {
    state.tool.brush.on = scene.field && !state.tool.brush.on;
}
template <bool kMore>
void otherBrush(ViewState& state, const Scene&, KeyPress press) {
    double& size = press.shift ? state.tool.brush.strength : state.tool.brush.radius;
    size = std::clamp(kMore ? size * 1.25 : size / 1.25, kMinBrush, kMaxBrush);
}
// Pictures that are being written are not lost by a key beside another one.
void quit(ViewState& state, const Scene&, KeyPress) { state.window.quit |= !state.window.sequence; }
void screenshot(ViewState& state, const Scene&, KeyPress press) {
    state.window.screenshot = true;
    state.window.screenshot_panels = !press.shift;
}

// Where a change shows, of keys whose change only some pictures show.
constexpr std::string_view kInShaded = "shows in shaded pictures (1)";

std::string_view unlessShaded(const Scene&, const ViewState& state) {
    return state.show.channel == Channel::kShaded && !state.show.component ? "" : kInShaded;
}
std::string_view unlessSuns(const Scene& scene, const ViewState& state) {
    const std::string_view where = unlessShaded(scene, state);
    return where.empty() ? whyNoSuns(scene, state) : where;
}
std::string_view unlessShadowed(const Scene&, const ViewState& state) {
    switch (state.show.channel) {
        case Channel::kShaded:
        case Channel::kAmbient:
        case Channel::kError:
        case Channel::kBouncedAmbient:
            if (!state.show.component) return {};
            break;
        default:
            break;
    }
    return "shows in shaded pictures, ambient visibility and errors (1, 2, 3)";
}
std::string_view unlessCompared(const Scene& scene, const ViewState& state) {
    if (!scene.hasTruth()) return {};  // then it changes nothing
    return state.show.compare == Compare::kModel ? "" : whyNoTruth(scene, state);
}
std::string_view unlessTruth(const Scene& scene, const ViewState& state) {
    return scene.hasTruth() ? whyNoTruth(scene, state) : "";
}
std::string_view unlessError(const Scene&, const ViewState& state) {
    return state.show.channel == Channel::kError && !state.show.component ? "" : "shows in the picture of errors (3)";
}
std::string_view unlessBetween(const Scene&, const ViewState& state) {
    return state.smooth && snapsToFrames(state) ? "shows where no truth does: between sampled frames there is none"
                                                : "";
}
std::string_view unlessOutlines(const Scene& scene, const ViewState&) {
    return scene.hasOutlines() ? "" : "no character here has boxes or spheres to cast by";
}
std::string_view unlessBrush(const Scene&, const ViewState& state) {
    return state.tool.brush.on ? "" : "shows with the brush (0)";
}

constexpr std::string_view kNeedsToCompare =
    "a baked truth (F2 opens one), and a shaded picture or ambient visibility (1, 2)";

constexpr std::array kShortcuts = {
    Shortcut{' ', "Space", "", "play or pause", toggle<&ViewState::playhead, &Playhead::playing>},
    Shortcut{kKeyRight, "Right", "10 frames", "next frame", step<1>},
    Shortcut{kKeyLeft, "Left", "10 frames", "previous frame", step<-1>},
    Shortcut{kKeyHome, "Home", "", "first frame", rewind},
    Shortcut{'W', "W", "farthest out of range", "the clip's frame of the largest error", worst,
             "a clip with baked truth, and another frame than the worst"},
    Shortcut{'I', "I", "", "interpolate between sampled frames, or snap to them", toggle<&ViewState::smooth>, "",
             unlessBetween},
    Shortcut{kKeyUp, "Up", "", "twice as fast", faster},
    Shortcut{kKeyDown, "Down", "", "half as fast", slower},
    Shortcut{kKeyPageDown, "Page Down", "", "next clip", otherClip<1>, "another clip"},
    Shortcut{kKeyPageUp, "Page Up", "", "previous clip", otherClip<-1>, "another clip"},
    Shortcut{'M', "M", "previous", "next material of the chosen slot", next<kMaterialMenu>,
             "another material (F2 opens a file that has some)", unlessShaded},
    Shortcut{'S', "S", "previous", "next slot, or all slots", next<kSlotMenu>, "a mesh with slots"},
    Shortcut{'L', "L", "previous", "next light", next<kLightMenu>, "another light (F2 opens one)", unlessShaded},
    Shortcut{'K', "K", "", "light as it came, not turned", unturnLight, "a light that is turned", unlessShaded},
    Shortcut{'H', "H", "", "suns of the light with shadow maps, or all light as SH",
             toggle<&ViewState::lighting, &Lighting::suns>, "", unlessSuns},
    Shortcut{'V', "V", "previous", "next form of the light: lobes, fixed lobes, exact rotation", next<kLightFormMenu>,
             "", unlessShaded},
    Shortcut{'P', "P", "", "reflectance as slices or as operators", next<kReflectanceMenu>, "", unlessShaded},
    Shortcut{'E', "E", "automatic exposure", "brighter", brighter, "", unlessShaded},
    Shortcut{'D', "D", "", "darker", darker, "", unlessShaded},
    Shortcut{'O', "O", "previous", "next tone mapping", next<kToneMapMenu>, "", unlessShaded},
    Shortcut{'T', "T", "", "baked truth or model", toggleTruth, kNeedsToCompare, unlessCompared},
    Shortcut{'C', "C", "previous", "next way to compare with the truth", otherCompare, kNeedsToCompare, unlessCompared},
    Shortcut{'1', "1", "", "shaded", channel<Channel::kShaded>, "a material and a light, unless it shows already"},
    Shortcut{'2', "2", "", "ambient visibility", channel<Channel::kAmbient>},
    Shortcut{'3', "3", "", "error against the truth", channel<Channel::kError>,
             "a baked truth (F2 opens one), unless it shows already", unlessTruth},
    Shortcut{'4', "4", "", "clusters", channel<Channel::kClusters>},
    Shortcut{'5', "5", "", "normals", channel<Channel::kNormals>},
    Shortcut{'6', "6", "previous", "PCA component, the next one", component, "a model with components"},
    Shortcut{'7', "7", "", "rigid parts of composed characters", channel<Channel::kParts>,
             "a composed character, unless they show already"},
    Shortcut{'8', "8", "", "ambient visibility with light that bounces", channel<Channel::kBouncedAmbient>,
             "a character with light that bounces, unless it shows already"},
    Shortcut{'9', "9", "previous", "next light: all, direct light, light that bounces", next<kBounceMenu>,
             "light that bounces, on a character or from others and the ground", unlessShaded},
    Shortcut{'[', "[", "", "error scale to a smaller number", smallerError, "", unlessError},
    Shortcut{']', "]", "", "error scale to a larger number", largerError, "", unlessError},
    Shortcut{'N', "N", "", "normals and tangents as lines", toggle<&ViewState::show, &ShowChoice::frames>},
    Shortcut{'U', "U", "", "boxes of fields, or spheres, that characters cast by",
             toggle<&ViewState::show, &ShowChoice::boxes>, "", unlessOutlines},
    Shortcut{'Y', "Y", "previous", "lobe of the next factor of the picked vertex", nextFactor,
             "a picked vertex of a composed character"},
    Shortcut{'X', "X", "", "no vertex picked", unpick, "a picked vertex"},
    Shortcut{'Z', "Z", "", "scores as the pose has them, not changed", unedit, "scores that are changed"},
    Shortcut{'F', "F", "", "frame everything", frameScene},
    Shortcut{'R', "R", "", "turntable", toggle<&ViewState::turntable>},
    Shortcut{'B', "B", "", "background of the light", toggle<&ViewState::show, &ShowChoice::background>, "",
             unlessShaded},
    Shortcut{'G', "G", "", "ground plane", toggle<&ViewState::show, &ShowChoice::ground>},
    Shortcut{'0', "0", "", "brush for a ground with heights: left drag raises, Shift + left drag lowers", brush,
             "a ground with heights"},
    Shortcut{',', ",", "weaker brush", "smaller brush", otherBrush<false>, "", unlessBrush},
    Shortcut{'.', ".", "stronger brush", "larger brush", otherBrush<true>, "", unlessBrush},
    Shortcut{'J', "J", "previous", "next shadows: all, on itself, on others, none", next<kShadowMenu>, "",
             unlessShadowed},
    Shortcut{kKeyTab, "Tab", "", "panels", toggle<&ViewState::window, &WindowChoice::panels>},
    Shortcut{kKeyF12, "F12", "without panels", "screenshot", screenshot},
    Shortcut{kKeyF11, "F11", "turntable as a video", "pictures of all frames of the clip", sequence},
    Shortcut{kKeyBackspace, "Backspace", "forward again", "back to the view before (Ctrl + Z)", undo},
    Shortcut{kKeyF2, "F2", "", "open a file (Ctrl + O)", browse},
    Shortcut{kKeyF1, "F1", "", "this help", help},
    Shortcut{kKeyEscape, "Escape", "", "close the help and the files, stop pictures", closeHelp, "something to close"},
    Shortcut{'Q', "Q", "", "quit", quit, "the pictures to be written, or stopped (Escape)"},
};

}  // namespace

void browseFiles(ViewState& state) {
    if (state.window.folder.empty())
        state.window.folder = state.window.recent.empty() ? "." : state.window.recent.front().parent_path();
    state.window.browsed = state.window.folder;
    state.window.help = false;
}

std::span<const Shortcut> shortcuts() { return kShortcuts; }

std::string whyNothing(KeyPress press) {
    const auto shortcut = std::ranges::find(kShortcuts, press.key, &Shortcut::key);
    if (shortcut == kShortcuts.end())
        return press.key > ' ' && press.key < 127
                   ? std::string(1, char(press.key)) + " is not a key of this window; F1 lists them"
                   : "";
    const std::string what = std::string(shortcut->name) + " (" + std::string(shortcut->text) + ")";
    return what + (shortcut->needs.empty() ? " changes nothing now" : " needs " + std::string(shortcut->needs));
}

std::string whyUnseen(const ViewState& state, const Scene& scene, KeyPress press) {
    const auto shortcut = std::ranges::find(kShortcuts, press.key, &Shortcut::key);
    if (shortcut == kShortcuts.end() || !shortcut->unseen) return "";
    const std::string_view why = shortcut->unseen(scene, state);
    if (why.empty()) return "";
    return std::string(shortcut->name) + " (" + std::string(shortcut->text) + "): " + std::string(why);
}

bool applyKey(ViewState& state, const Scene& scene, KeyPress press) {
    for (const Shortcut& shortcut : kShortcuts)
        if (shortcut.key == press.key) {
            shortcut.apply(state, scene, press);
            return true;
        }
    return false;
}

}  // namespace penumbra
