#pragma once
// Holds all that a user chooses in the window, but not how it is drawn: keys and panels change it, and the scene
// follows it.
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "player/draw/view_display.h"
#include "player/frame/channel.h"
#include "player/frame/visibility_factors.h"
#include "player/papers/cast_way.h"
#include "player/view/playback/playhead.h"
#include "runtime/shade/indirect_light.h"
#include "runtime/shade/shading.h"
#include "sh/camera.h"

namespace penumbra {

struct Scene;

enum class Compare {
    kModel,
    kTruth,
    kSideBySide,  // with the model at the left
    kWipe,        // the model at the left of ShowChoice::wipe
    kDifference,  // |model - truth| of what each vertex shows, times ShowChoice::difference_gain
};

// Which shadows are shown.
enum class Shadows {
    kBoth,
    kSelf,  // each on itself
    kCast,  // on others and on the ground
    kNone,
};

struct CharacterChoice {
    std::size_t clip = 0;
    std::vector<std::size_t> material_of_slot;  // 1 entry for a mesh without slots
    double start = 0;                           // seconds that its clip is ahead of the playhead
    bool still = false;                         // it stays in the first frame of its animation, or its file's pose
    Vec3 moved = {};                            // from its place in the scene
    bool operator==(const CharacterChoice&) const = default;
};

struct PickedVertex {
    std::size_t character = 0, vertex = 0;
    bool operator==(const PickedVertex&) const = default;
};

// A character follows the pointer, at the height where it was taken.
struct DraggedCharacter {
    std::size_t character = 0;
    double height = 0;
    bool operator==(const DraggedCharacter&) const = default;
};

// Shapes a ground with heights under the pointer.
struct GroundBrush {
    bool on = false;
    double radius = 0.5, strength = 0.5;  // metres; metres a second in its middle
    bool operator==(const GroundBrush&) const = default;
};
constexpr double kMinBrush = 0.01, kMaxBrush = 1e4;  // limits for both
// Effect of the brush in one frame, in the scene: strokeHeights() has the shape.
struct GroundStroke {
    Vec3 at;
    float radius = 0, rise = 0;
    bool operator==(const GroundStroke&) const = default;
};

// Scores of a cluster that the user has changed.
struct ScoreEdit {
    std::size_t character = 0, cluster = 0;
    std::vector<float> added;  // added to each component's score
    bool operator==(const ScoreEdit&) const = default;
};

// Weights of a character's morph targets that the user has set, all of them.
struct WeightEdit {
    std::size_t character = 0;
    std::vector<float> weights;
    bool operator==(const WeightEdit&) const = default;
};

enum class Worst { kError, kOutOfRange };  // figure by which the worst frame of a clip is chosen

// The user asked for the worst frame before every frame's figure was known. It is shown again when all are known, if
// the user has stayed there.
struct AwaitedWorst {
    Worst by = Worst::kError;
    std::size_t character = 0, clip = 0;
    double time = 0;  // Playhead::time
    bool operator==(const AwaitedWorst&) const = default;
};

// The lighting of the vertices.
struct Lighting {
    std::size_t light = 0;
    double yaw = 0, pitch = 0;                 // degrees, sh/light/light_rotation.h
    Mat3 base;                                 // rotation of the light in the scene's file, before yaw and pitch
    bool suns = true;                          // suns are drawn as suns if they can shine (view_look.h); otherwise all
                                               // light is SH
    Bounces bounces = Bounces::kBoth;          // bounces on characters, and between them and the ground
    ShadingChoice shading;                     // wanted forms; a form that a chosen material or light lacks is not used
    std::map<std::size_t, double> parameters;  // parameters of live materials that differ from their files
    bool operator==(const Lighting&) const = default;
};

// The quantity that is drawn.
struct ShowChoice {
    Channel channel = Channel::kShaded;
    std::optional<std::size_t> component;  // component of the model's PCA, shown instead of the channel
    Compare compare = Compare::kModel;
    float wipe = 0.5f;  // position in the picture, as a share of its width
    float error_max = 0.25f;
    float difference_gain = 8;  // factor on each difference for Compare::kDifference
    Shadows shadows = Shadows::kBoth;
    CastMode cast_mode = CastMode::kProduct;  // the wanted mode; shownCastMode() tells which is shown
    bool background = true, ground = false;
    bool frames = false;  // draw normals and tangents
    bool boxes = false;   // draw the boxes of the fields of composed characters
    bool operator==(const ShowChoice&) const = default;
};

// The details that the user inspects.
struct Inspection {
    std::optional<PickedVertex> picked;  // its visibility is drawn
    FactorChoice factor;                 // part of the visibility; the whole if the vertex has no such factor
    std::optional<ScoreEdit> score_edit;
    std::optional<WeightEdit> weight_edit;
    bool operator==(const Inspection&) const = default;
};

// Uses of the pointer besides turning the camera.
struct PointerTool {
    GroundBrush brush;
    std::optional<GroundStroke> stroke;  // for the next frame
    std::optional<DraggedCharacter> dragged;
    bool operator==(const PointerTool&) const = default;
};

// Pictures that are written one after another.
enum class Sequence {
    kClip,       // all frames of the clip
    kTurntable,  // a whole turn of the camera, as a video; the clip plays or stands as it did
};

struct WindowChoice {
    bool panels = true, help = false, quit = false;
    bool hint = false;                                  // says how to begin, until something is pressed
    bool screenshot = false, screenshot_panels = true;  // taken at the next frame
    std::optional<std::size_t> sequence;                // number of the next picture of a sequence
    Sequence of = Sequence::kClip;
    int undone = 0;  // views to go back (below 0) or forth before the next frame (view_history.h)
    std::optional<std::filesystem::path> browsed;  // folder that the list of files shows, where it is open
    std::filesystem::path folder;                 // folder that it shows when it is opened again; empty: not yet chosen
    std::optional<std::filesystem::path> chosen;  // file that is opened before the next frame
    std::optional<std::size_t> leaving;           // character that is taken away before the next frame
    std::vector<std::filesystem::path> recent;    // files that were opened, the latest first
    bool closes_list = false;                     // an open list of a control closes in the next frame
    bool worst_point = false;                     // the vertex of the largest error is picked in the next frame
    bool operator==(const WindowChoice&) const = default;
};

struct ViewState {
    std::vector<CharacterChoice> characters;
    std::size_t selected = 0;  // the character that clips and materials are chosen for
    std::size_t slot = 0;      // slot for which a material is chosen; equal to the number of slots: all of them
    Playhead playhead;
    std::optional<AwaitedWorst> awaited;
    bool smooth = true;  // show poses between sampled frames, where no truth is shown
    Camera camera;
    bool turntable = false, frame_all = true;
    Lighting lighting;
    ShowChoice show;
    DisplayTransform display;
    bool automatic_exposure = true;  // display.exposure is measured (view_look.h)
    Inspection inspect;
    PointerTool tool;
    WindowChoice window;
    bool operator==(const ViewState&) const = default;
};

const ClipView& selectedClip(const ViewState& state, const Scene& scene);
// Goes to the clip's frame of the largest mean error against the truth, or of the pose that is farthest out of range,
// as far as these are known. advanceView() does it again when all of them are.
void showWorst(ViewState& state, const Scene& scene, Worst by);
// Picks the selected character's vertex of the largest error, of which the picture of errors is shown.
void pickWorst(ViewState& state, const Scene& scene);
// Tells whether the panels are there: the user has them, or looks into the keys or the files.
inline bool showsPanels(const ViewState& state) {
    return state.window.panels || state.window.help || state.window.browsed;
}
// Tells whether only sampled frames are shown: because the user chose so, or because truth is shown, which other
// poses lack.
bool snapsToFrames(const ViewState& state);
// Returns what is shown of the character's clip. All characters share the playhead's time. `part` is 0 on sampled
// frames.
ClipPosition shownPosition(const ViewState& state, const Scene& scene, std::size_t character);
// Seconds into the selected character's clip, and back.
double clipTime(const ViewState& state);
void showClipTime(ViewState& state, double seconds);

void chooseClip(ViewState& state, std::size_t clip);
void chooseMaterial(ViewState& state, std::size_t material);  // for the selected character's slot or slots
std::size_t chosenMaterial(const ViewState& state);
// A channel needs light, truth, parts or light that bounces; without, choosing it does nothing.
bool hasChannel(const Scene& scene, Channel channel);
void chooseChannel(ViewState& state, const Scene& scene, Channel channel);
// Goes to the next factor of the picked vertex, or to the one before, round the ends.
void chooseNextFactor(ViewState& state, const Scene& scene, int step);
// Tells whether the picture is one that truth has, too.
bool canCompare(const ViewState& state);
// Returns what is compared: only what truth has too, which is shaded pictures and ambient visibility.
Compare shownCompare(const ViewState& state);
// Lets the lamp follow the pointer: a drag over the whole height turns the light by half a turn.
void dragLight(ViewState& state, double right, double down, double height);
Mat3 lightRotation(const ViewState& state);

// Advances by `seconds` of wall clock.
void advanceView(ViewState& state, const Scene& scene, double seconds);

}  // namespace penumbra
