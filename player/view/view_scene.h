#pragma once
// The opened files and, for each character, what its vertices show at the moment. It uses no GL.
#include <array>
#include <functional>
#include <memory>

#include "formats/image/picture_options.h"
#include "formats/scene/bone_poses.h"
#include "player/frame/frame_values.h"
#include "player/frame/open_asset.h"
#include "player/frame/orbit_camera.h"
#include "player/papers/joined_cast.h"
#include "player/scene/received_light.h"
#include "player/scene/scene_field.h"
#include "player/scene/scene_ground.h"
#include "player/view/cached.h"
#include "player/view/light_blend.h"
#include "player/view/playback/clip_figures.h"
#include "player/view/playback/pose_interpolation.h"
#include "player/view/playback/position_interpolation.h"
#include "player/view/playback/score_ranges.h"
#include "player/view/view_keys.h"
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

// What the files say of a character. It stays as openScene() has made it.
struct OpenedCharacter {
    // With the materials and lights of every file, and a last light whose place Scene::blend takes.
    AssetView asset;
    std::vector<SlotSurface> pictured_slots;  // asset.surface->slots, with the numbers of those materials
    const AssetView* truth = nullptr;
    Affine placement;              // from its model frame to the scene: a rotation about y and a translation
    std::size_t caster = kNobody;  // of Scene::cast
    std::optional<CasterKind> casts = {};
    const BonePose* file_pose = nullptr;  // of the scene's file; shown where CharacterChoice::still
    std::size_t file_bytes = 0;
};

// What follows from its pose.
struct CharacterPose {
    std::unique_ptr<Evaluator> evaluator;                            // has the pose
    std::unique_ptr<PoseInterpolation> interpolation;                // null of a deforming mesh
    std::unique_ptr<PositionInterpolation> position_interpolation;   // null for a skinned mesh
    Cached<PoseKey, std::optional<std::size_t>> truth_frame;         // none between sampled frames, and without truth
    Affine to_scene;                                                 // the placement, with what the user has moved it
    FrameVertices vertices;                                          // numbers: of the model
    FrameVertices in_scene;                                          // where they stand: without numbers
    HiddenSky hidden;                                                // of the model's numbers
    Cached<CoefficientsKey> coefficients;                            // those of `vertices`
    Cached<CoefficientsKey, std::vector<float>> truth_coefficients;  // in the local frames of `vertices`
    // Of the picked vertex of a composed asset.
    Cached<std::pair<PoseKey, std::optional<std::size_t>>, std::vector<VisibilityFactor>> factors;
    const PoseKey& pose() const { return *truth_frame.key(); }
};

// What a unit of a component's score changes of E.
struct ComponentEffect {
    std::vector<float> ambient;  // componentAmbient()
    float most = 0;              // the largest of them, without its sign
};

// What is drawn of it.
struct CharacterLook {
    std::unique_ptr<ShadingSet> shading;         // null without materials or lights
    Cached<LookKey> look;                        // that the shading has
    Cached<CoefficientsKey, JoinedCast> joined;  // for CastMode beside kProduct
    Cached<LookKey> joined_look;                 // that it has
    // The channel of the values. Without truth, error is shown as ambient visibility, and so are parts without any.
    Channel channel = Channel::kShaded;
    Cached<CharacterKey, std::array<std::vector<Vec3>, kShownCount>> values;
    Cached<std::size_t, ComponentEffect> component;
    double mean_error = 0, max_error = 0;  // |E(model) - E(truth)| of the frame, Channel::kError
    std::span<const Vec3> of(Shown shown) const { return (*values)[std::size_t(shown)]; }
};

// Figures of a clip's frames, from the first on, as far as they are known.
struct ClipFigures {
    std::size_t clip = 0;
    std::vector<float> out_of_range;  // Evaluator::outOfRange()
    std::vector<FrameError> errors;   // only with truth
};

// What the panels show beside the picture. It is computed a little at a time.
struct CharacterTimeline {
    std::unique_ptr<Evaluator> evaluator;  // for poses that are not drawn
    ClipFigures figures;
    ErrorStrip error_strip;
    ScoreRanges score_ranges;
    Cached<std::size_t, std::vector<ComponentFigures>> components;  // of a cluster; known when the ranges are
};

struct Character : OpenedCharacter {
    CharacterPose posed;
    CharacterLook shown;
    CharacterTimeline timeline;
};

// A file of any kind that a scene is made of.
struct SceneFile {
    std::unique_ptr<OpenAsset> asset;  // null: a picture of a light
    std::string light_name;
    std::vector<float> light_sh;  // [kPictureLightOrder^2, 3]
    std::vector<Sun> light_suns;
    int picture_width = 0;
    std::vector<std::uint16_t> picture;  // PictureView, without the suns
    SkyPicture backdrop;                 // the picture itself, suns included
};
constexpr int kPictureLightOrder = 5;

// What the ground shows at its vertices.
struct ShownGround {
    Cached<GroundKey, std::vector<Vec3>> values;
    Cached<std::pair<CoefficientsKey, bool>> seen;  // what the vertices have, and whether the CPU has computed it
    Cached<std::uint64_t> heights;                  // SceneField::version() that they have
    std::size_t updated = 0;                        // points of a ground with heights that the last change has reached
    GroundVertices vertices;                        // of a ground with heights: without numbers of its own
    FrameVertices points;                           // of a ground with heights
    bool lit() const { return values.key() && values.key()->lit; }  // the values are radiance; otherwise colours
};

// What characters and a level ground send to one another. It is in CharacterPose::vertices.received.
struct ReceivedLight {
    Cached<ReceivedKey> key;
    Cached<std::vector<Stance>, GroundGlow> shadows;  // on the ground, of everyone
    std::uint64_t version = 0;           // 0 where nothing is received; otherwise another one for every key
    std::uint64_t latest = 0;            // the last version that was not 0
    std::vector<ShiningMember> shining;  // empty where nobody receives from characters
};

struct Scene {
    std::vector<SceneFile> files;
    std::optional<SceneDescription> file;  // scene.json
    PoseFiles poses;
    std::vector<std::unique_ptr<Character>> characters;
    std::vector<std::string_view> material_names, light_names;
    std::vector<const SkyPicture*> backdrops;  // of each light; null: what its file has of it
    std::unique_ptr<CastShadow> cast;
    std::unique_ptr<CastShadow> sphere_cast;  // all of them by their spheres; null where one has none
    std::optional<SceneGround> ground_file;   // none where a scene's file has none
    std::unique_ptr<SceneField> field;        // the heights of the ground; null where it is level
    ShownGround ground;
    ReceivedLight received;
    LightBlend blend;               // of the light that is switched
    std::vector<float> dark_light;  // SH of the last light of all characters, 0
    bool textures = true;           // as OpenChoice has it

    bool shaded() const { return !material_names.empty() && !light_names.empty(); }
    bool hasTruth() const;
    bool composed() const;           // some character is
    bool bounces() const;            // some character has light that bounces
    bool passesLight() const;        // characters and a level ground can send light to one another
    bool hasOutlines() const;        // some character has boxes of fields, or spheres
    std::size_t components() const;  // the most of the model's PCA that any character has
    std::uint64_t fieldVersion() const { return field ? field->version() : 0; }
};

struct OpenChoice {
    PictureOptions reading;  // of the pictures of lights
    bool textures = true;    // pictures of assets that have them are shown where a slot has its own material
    // Called a few times a second while a large picture is read: its file, and the share that is done.
    std::function<void(const std::filesystem::path&, double)> progress = {};
};

// Opens a scene. A .json says who stands where (docs/scene.md); its characters and props come first. Without one the
// characters stand side by side. A .pnb is a character, or truth for the characters that it fits, or brings materials
// or lights. An .exr or .hdr is a light's picture, which is read as `choice` says. Throws InvalidInput when none is a
// character, and when a truth fits no character.
Scene openScene(std::span<const std::filesystem::path> paths, int threads, const OpenChoice& choice = {});
// Returns what the scene's file says of a character; null without a file, and for one that was added to it.
const SceneCharacter* memberOf(const Scene& scene, std::size_t character);
// Returns characters, clips and materials as the files have them. What `old` has chosen stays where it still exists.
ViewState stateFor(const Scene& scene, const ViewState& old);
// Returns what a state of one scene has chosen of materials and lights as another scene numbers them, by their names. A
// character whose material is gone loses its choice, which stateFor() then takes from the file.
ViewState carriedOver(const Scene& from, const Scene& to, const ViewState& old);

// Gives the state what the scene's file says: clips, times, materials, light and camera.
void applySceneFile(const Scene& scene, ViewState& state);

// Tells what a frame needs on the CPU.
struct UpdateNeeds {
    bool values = true;  // what every vertex shows, for the CPU path
    bool casts = true;   // what others cast, unless the GPU does it
    bool field = true;   // what a ground with heights shows, unless the GPU computes it
    int threads = 0;
};
// Brings the characters to what `state` says. Computes only what is missing or changed, and returns whether anything
// was.
bool updateScene(Scene& scene, const ViewState& state, const UpdateNeeds& needs, UpdateCost& cost);

// Goes on computing, for some milliseconds, what the timeline shows of the selected character's clip.
void computeStrips(Scene& scene, const ViewState& state, double milliseconds);
bool stripsAreComplete(const Scene& scene, const ViewState& state);

// Returns what of the picked vertex' visibility is drawn: state.inspect.factor, or the whole where the vertex has no
// such factor. Null where nothing is picked, or the character is not composed.
const VisibilityFactor* shownFactor(const Scene& scene, const ViewState& state);

// Returns which frame of the truth a character shows in a pose. A pose between sampled frames, one of a file and one
// with weights of the user have none.
std::optional<std::size_t> truthFrameOf(const Character& character, const PoseKey& pose);
// Says why nobody's baked truth can be shown now: no file has any, or none of the clip, or none of the pose. Empty
// where a character has some. Characters without truth show the model in its place.
std::string_view whyNoTruth(const Scene& scene, const ViewState& state);

// Returns, for instance, "clip walk, frame 3, shaded, model, material lambert, light sky".
std::string describe(const Scene& scene, const ViewState& state);

BoundingBox boundsOf(const Scene& scene);
BoundingBox restBounds(const Scene& scene);  // bounds of the rest poses

}  // namespace penumbra
