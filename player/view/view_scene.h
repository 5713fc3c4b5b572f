#pragma once
// The opened files and, for each character, what its vertices show at the moment. It uses no GL.
#include <array>
#include <memory>

#include "formats/scene/bone_poses.h"
#include "player/frame/frame_values.h"
#include "player/frame/open_asset.h"
#include "player/frame/orbit_camera.h"
#include "player/scene/cast_shader.h"
#include "player/scene/scene_field.h"
#include "player/scene/scene_ground.h"
#include "player/view/light_blend.h"
#include "player/view/playback/clip_strip.h"
#include "player/view/playback/error_strip.h"
#include "player/view/playback/pose_interpolation.h"
#include "player/view/playback/position_interpolation.h"
#include "player/view/playback/score_ranges.h"
#include "player/view/view_state.h"
#include "runtime/cast/cast_shadow.h"

namespace penumbra {

// Tells whose values are drawn.
enum class Shown { kModel, kTruth, kDifference };
constexpr std::size_t kShownCount = 3;

// Milliseconds of one update.
struct UpdateCost {
    double evaluate = 0;  // pose, skinning, visibility, shadows of others; of the last update that computed any
    double ground = 0;    // the ground's shadow
    double shade = 0;     // computing what every vertex shows
};

// What the shading of another way than the product was made for.
struct JoinedLook {
    CastMode mode = CastMode::kProduct;
    std::vector<std::size_t> material_of_slot;
    std::size_t light = 0;
    Mat3 light_rotation;
    ShadingChoice shading;
    bool operator==(const JoinedLook&) const = default;
};

struct Character {
    // With the materials and lights of every file, and a last light whose place Scene::blend takes.
    AssetView asset;
    const AssetView* truth = nullptr;
    Affine placement;              // from its model frame to the scene: a rotation about y and a translation
    Affine to_scene;               // the same, with what the user has moved it
    std::size_t caster = kNobody;  // of Scene::cast
    std::optional<CasterKind> casts = {};
    std::unique_ptr<Evaluator> evaluator;
    std::unique_ptr<ShadingSet> shading;  // null without materials or lights
    std::uint64_t light_version = 0;      // of Scene::blend, where the set has its light

    std::unique_ptr<PoseInterpolation> interpolation;               // null of a deforming mesh
    std::unique_ptr<PositionInterpolation> position_interpolation;  // null for a skinned mesh
    const BonePose* file_pose = nullptr;   // of the scene's file; shown where CharacterChoice::still
    const BonePose* shown_pose = nullptr;  // what the evaluator has of it; null: a frame
    std::size_t frame = 0;                 // in the animation; the pose is `part` of the way from it to the next
    double part = 0;
    std::optional<std::size_t> truth_frame;  // only for sampled frames
    std::optional<ScoreEdit> edited;         // that the evaluator has
    bool posed = false, has_model_numbers = false, has_truth_numbers = false;
    // What the numbers were made for.
    Shadows shadows = Shadows::kBoth;
    std::uint64_t cast_version = 0;
    FrameVertices vertices;            // numbers: of the model
    std::vector<float> truth_numbers;  // in the local frames of `vertices`
    // Of other ways than the product (view_cast_way.h):
    std::vector<float> others;            // V_c over the sphere, of every vertex, in the scene
    std::optional<CastMode> others_mode;  // that it was made for
    std::uint64_t others_version = 0;     // Scene::pose_version of then
    std::unique_ptr<CastShader> joined;   // for joined_look
    JoinedLook joined_look;

    std::array<std::vector<Vec3>, kShownCount> values;
    // The channel of the values. Without truth, error is shown as ambient visibility, and so are parts without any.
    Channel channel = Channel::kShaded;
    bool plain = false;                    // the values are colours, neither exposed nor tone mapped
    std::vector<float> component_ambient;  // componentAmbient() of ViewState::component
    std::optional<std::size_t> component;  // the component that these belong to
    float component_most = 0;              // the largest of them, without its sign
    ClipStrip strip;
    ErrorStrip error_strip;  // only with truth
    ScoreRanges score_ranges;
    std::optional<std::size_t> components_of;  // the cluster; known when the ranges are
    std::vector<ComponentFigures> components;
    std::optional<std::size_t> factors_of;  // the vertex that these belong to, in the pose of now
    std::vector<VisibilityFactor> factors;  // only of a composed asset
    std::size_t file_bytes = 0;
    std::unique_ptr<Evaluator> strip_evaluator;  // for poses that are not drawn
    double mean_error = 0, max_error = 0;        // |E(model) - E(truth)| of the frame, Channel::kError
};

// A file of any kind that a scene is made of.
struct SceneFile {
    std::unique_ptr<OpenAsset> asset;  // null: a picture of a light
    std::string light_name;
    std::vector<float> light_sh;  // [kPictureLightOrder^2, 3]
    std::vector<Sun> light_suns;
    int picture_width = 0;
    std::vector<std::uint16_t> picture;  // PictureView, without the suns
};
constexpr int kPictureLightOrder = 5;

// Tells the lights of different moments apart.
struct LightKey {
    std::size_t light = 0;
    std::uint64_t version = 0;  // of Scene::blend
    bool operator==(const LightKey&) const = default;
};

// What the ground shows at its vertices.
struct ShownGround {
    struct Made {
        bool shadows = false, lit = false, suns = false, on_cpu = true;
        CastMode mode = CastMode::kProduct;
        std::uint64_t caster_version = 0, field_version = 0;
        LightKey light;
        Mat3 rotation;
        Vec3 eye;  // of a ground with a material
        bool operator==(const Made&) const = default;
    };
    std::optional<Made> made;  // what the values were made for
    std::uint64_t version = 0;
    std::size_t updated = 0;  // points of a ground with heights that the last change has reached
    GroundVertices vertices;  // of a ground with heights: without numbers of its own
    FrameVertices points;     // of a ground with heights
    std::vector<Vec3> values;
    bool lit() const { return made && made->lit; }  // the values are radiance; otherwise colours
};

struct Scene {
    std::vector<SceneFile> files;
    std::optional<SceneDescription> file;  // scene.json
    PoseFiles poses;
    std::vector<std::unique_ptr<Character>> characters;
    std::vector<std::string_view> material_names, light_names;
    std::unique_ptr<CastShadow> cast;
    std::unique_ptr<CastShadow> sphere_cast;  // all of them by their spheres; null where one has none
    std::uint64_t cast_version = 0;           // grows with every caster that takes another pose or place, and heights
    std::uint64_t caster_version = 0;         // without heights
    std::uint64_t field_version = 0;          // SceneField::version() that the others were grown for
    std::uint64_t pose_version = 0;           // grows with everyone who does, caster or not
    std::optional<SceneGround> ground_file;   // none where a scene's file has none
    std::unique_ptr<SceneField> field;        // the heights of the ground; null where it is level
    ShownGround ground;
    LightBlend blend;               // of the light that is switched
    std::vector<float> dark_light;  // SH of the last light of all characters, 0
};

// Opens a scene. A .json says who stands where (docs/scene.md); its characters and props come first. Without one the
// characters stand side by side. A .pnb is a character, or truth for the characters that it fits, or brings materials
// or lights. An .exr or .hdr is a light's picture (lat-long or a cube's cross). Throws InvalidInput when none is a
// character, and when a truth fits no character.
Scene openScene(std::span<const std::filesystem::path> paths, int threads);
ViewContents contentsOf(const Scene& scene);
// Returns what the scene's file says of a character; null without a file, and for one that was added to it.
const SceneCharacter* memberOf(const Scene& scene, std::size_t character);
// Returns characters, clips and materials as the files have them. What `old` has chosen stays where it still exists.
ViewState stateFor(const Scene& scene, const ViewState& old);

// Gives the state what the scene's file says: clips, times, materials, light and camera.
void applySceneFile(const Scene& scene, ViewState& state);

// Tells what a frame needs on the CPU.
struct UpdateNeeds {
    bool values = true;  // what every vertex shows, for the CPU path
    bool casts = true;   // what others cast, unless the GPU does it
    bool field = true;   // what a ground with heights shows, unless the GPU computes it
    int threads = 0;
};
// Brings the characters to what `state` says. Computes only what changed.
void updateScene(Scene& scene, const ViewState& state, const UpdateNeeds& needs, UpdateCost& cost);

// Returns the shading forms that every chosen material and the chosen light support (operators, fitted lobes).
ShadingChoice shownShading(const Scene& scene, const ViewState& state);
// Makes a character's ShadingSet anew where its choice has changed. Returns true then, because painters keep
// references to it.
bool useShading(Scene& scene, const ViewState& state);

// Goes on computing, for some milliseconds, what the timeline shows of the selected character's clip.
void computeStrips(Scene& scene, const ViewState& state, double milliseconds);
bool stripsAreComplete(const Scene& scene, const ViewState& state);

// Returns what of the picked vertex' visibility is drawn: state.factor, or the whole where the vertex has no such
// factor. Null where nothing is picked, or the character is not composed.
const VisibilityFactor* shownFactor(const Scene& scene, const ViewState& state);

// Returns, for instance, "clip walk, frame 3, shaded, model, material lambert, light sky".
std::string describe(const Scene& scene, const ViewState& state);

BoundingBox boundsOf(const Scene& scene);
BoundingBox restBounds(const Scene& scene);  // bounds of the rest poses

}  // namespace penumbra
