#pragma once
// Reads scene.json, which says who stands where (docs/scene.md has the keys). It opens no other file.
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/camera/camera_file.h"
#include "formats/common/file_format.h"
#include "formats/height/height_source.h"
#include "sh/height/height_refinement.h"
#include "sh/vec3.h"

namespace penumbra {

constexpr FileFormat kSceneFormat{"penumbra.scene", 1};
constexpr std::size_t kMaxSceneCharacters = 10000;
constexpr int kMaxGroundResolution = 2048;

// By which form a character casts a shadow. kWhatItHas: fields if its asset has them, else spheres, else nothing.
enum class SceneCasts { kWhatItHas, kFields, kSpheres, kNothing };

// A pose of a file (bone_poses.h) instead of a frame of the asset.
struct ScenePose {
    std::string at;  // see SceneCharacter::at
    std::filesystem::path file;
    std::size_t frame = 0;  // index of the pose in the file
};

// Something that stands in a scene. Its asset's frame is turned about y (degrees; positive turns +z towards +x) and
// then moved (metres).
struct SceneCharacter {
    std::string at;    // the file and the JSON pointer, for messages
    std::string name;  // the character's name; by default the asset's stem, numbered if there are several
    std::filesystem::path asset;
    std::string clip;                    // "": the first
    double seconds = 0;                  // into the clip; the nearest sampled frame
    std::optional<ScenePose> pose = {};  // instead of a clip and a time
    Vec3 position;
    bool on_ground = false;  // position.y counts from the ground at x and z
    double yaw = 0;
    std::string material;                                         // material of all parts; "": the asset chooses one
                                                                  // for each
    std::vector<std::pair<std::string, std::string>> slots = {};  // slot, material; after `material`
    SceneCasts casts = SceneCasts::kWhatItHas;
    // A prop that stands in the photograph already: it hides and it receives shadows, and it is not drawn. Its asset
    // may be a mesh (isRealMesh()), which stands still and has neither a model nor a material.
    bool real = false;
};
// Tells whether an asset's name is that of a mesh file, which only real props may be: .obj or .glb.
bool isRealMesh(const SceneCharacter& one);

// Heights of a ground: where they come from and how finely they are looked at (sh/height/height_visibility.h).
struct SceneHeights {
    HeightSource source;
    double seconds = 0;  // into a sequence or a closed form, where no other time is asked for
    int order = 5, step = 4;
    double refine = double(kHeightTolerance);  // HeightVisibility::tolerance()
};

// A square that faces up, or a height field whose middle is `center`, with its columns along x and its rows along z.
struct SceneGround {
    double height = 0;                         // y, metres
    Vec3 center;                               // x and z count
    double size = 4;                           // side, metres
    int resolution = 128;                      // vertices a side
    Vec3 albedo{0.5f, 0.5f, 0.5f};             // linear
    std::optional<SceneHeights> heights = {};  // then size and resolution are theirs
    std::string material = {};                 // material for heights, from the light's asset; "": Lambertian with the
                                               // albedo
    // It stands in the photograph already: it is not drawn, and shows shadows only as a share of its light.
    bool catcher = false;
    bool casts = true;  // a level one hides light from what stands on it, and sends light back
};

// The camera that took a photograph, in the frame of the marker (sh/pinhole_camera.h).
struct SceneCamera {
    std::string at;  // see SceneCharacter::at
    // The camera and its pose, or a file of poses (formats/camera/camera_file.h) and which of its frames comes first.
    PinholeCamera camera;
    CameraPose pose;
    std::filesystem::path poses;  // empty: the two above
    std::size_t frame = 0;
};

struct SceneLight {
    std::string at;               // see SceneCharacter::at
    std::filesystem::path asset;  // empty: the first character's
    std::string name;             // "": the first
    std::string rotation;         // sh/light/light_rotation.h
};

struct SceneDescription {
    std::string at;                                 // the file, for messages
    std::vector<SceneCharacter> characters, props;  // either may be empty
    std::optional<SceneGround> ground;
    SceneLight light;
    std::string camera;                          // sh/camera.h
    std::optional<SceneCamera> photograph = {};  // instead of `camera`
    double world_scale = 1;                      // metres of the marker's frame that a metre of the scene is
    // Where (0, 0, 0) of all places above stands in the file's frame, which `camera` and points of probes are in. It is
    // not 0 after openGround() (scene_origin.h) alone.
    Vec3d origin = {};
};

// Paths in the result are relative to the folder of `path`, as they are in the file, joined with it. Throws IoError,
// and InvalidInput with the file, the JSON pointer of the key, and what is wrong with it: unknown keys, a key that
// stands twice, numbers out of range, two characters of one name.
SceneDescription readScene(const std::filesystem::path& path);
// Returns every file that the scene names, each once, in the order in which they are named.
std::vector<std::filesystem::path> filesNamedIn(const SceneDescription& scene);
// Names what has no name. Throws InvalidInput for names that stand twice.
void nameAll(SceneDescription& scene);
// Same as readScene(), for text. Messages contain `name`; paths are relative to `folder`.
SceneDescription parseScene(const std::string& text, const std::string& name, const std::filesystem::path& folder);

}  // namespace penumbra
