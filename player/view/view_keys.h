#pragma once
// What is shown follows from keys, and these from the files and the state alone. Each part of the picture is kept with
// the key that it was made for (cached.h), and is made anew when its key has become another one.
#include <cstdint>

#include "formats/scene/bone_poses.h"
#include "player/view/view_state.h"

namespace penumbra {

// How a character is posed.
struct PoseKey {
    const BonePose* file_pose = nullptr;  // null: a frame
    std::size_t frame = 0, next = 0;      // in the animation; the pose is `part` of the way from one to the other
    double part = 0;
    std::optional<ScoreEdit> edited;
    std::optional<WeightEdit> weights;
    bool operator==(const PoseKey&) const = default;
};

struct Stance {
    PoseKey pose;
    Affine to_scene;
    bool operator==(const Stance&) const = default;
};

// The numbers of a character's vertices, with the shadows that they have.
struct CoefficientsKey {
    Stance own;
    Shadows shadows = Shadows::kBoth;
    CastMode mode = CastMode::kProduct;
    bool on_ground = false;       // a level ground hides light from it
    std::vector<Stance> casters;  // where they change the numbers, or join them later
    std::uint64_t field = 0;      // SceneField::version(), where that changes the numbers
    bool operator==(const CoefficientsKey&) const = default;
};

// The light of a moment.
struct LightKey {
    std::size_t light = 0;
    std::uint64_t version = 0;  // LightBlend::version()
    bool operator==(const LightKey&) const = default;
};

// What a character's materials and light are.
struct LookKey {
    std::vector<std::size_t> material_of_slot;
    Lighting lighting;
    ShadingChoice shading;  // that is shown
    LightKey light;
    bool suns = false;  // shine as such
    Mat3 turn;          // of the character in the scene
    CastMode mode = CastMode::kProduct;
    bool operator==(const LookKey&) const = default;
};

// What the vertices of a character show.
struct CharacterKey {
    CoefficientsKey coefficients;
    LookKey look;
    Channel channel = Channel::kShaded;
    Compare compare = Compare::kModel;
    std::optional<std::size_t> component, picked;
    float gain = 0;              // of differences
    Vec3 eye;                    // of shaded pictures
    std::uint64_t received = 0;  // ReceivedLight::version
    bool operator==(const CharacterKey&) const = default;
};

// What the ground shows at its vertices.
struct GroundKey {
    CoefficientsKey seen;  // without a field, whose changes are few
    bool on_cpu = true;
    std::uint64_t field = 0;
    bool lit = false, suns = false;
    LightKey light;              // where it is lit
    Mat3 rotation;               // of the light
    Vec3 eye;                    // of a ground with a material
    std::uint64_t received = 0;  // ReceivedLight::version
    bool operator==(const GroundKey&) const = default;
};

// What characters and a level ground send to one another.
struct ReceivedKey {
    bool wanted = false;
    std::vector<CoefficientsKey> coefficients;  // of everyone, where it is wanted
    std::vector<LookKey> looks;
    Vec3 eye;  // towards which characters show what they send to others
    bool operator==(const ReceivedKey&) const = default;
};

// What the maps of suns are drawn for.
struct SunsKey {
    std::vector<Stance> everyone;
    std::uint64_t field = 0;
    LightKey light;
    Mat3 rotation;
    bool operator==(const SunsKey&) const = default;
};

struct ViewKeys {
    std::vector<CharacterKey> characters;
    GroundKey ground;
    SunsKey suns;
    ReceivedKey received;
};

// What a frame of the window shows: all that the user may change, and what comes to be known by itself.
struct FrameKey {
    ViewState state;
    std::uint64_t light = 0, field = 0;  // LightBlend::version(), SceneField::version()
    std::size_t figures = 0;             // of the timeline and the panels, that are known
    bool operator==(const FrameKey&) const = default;
};
FrameKey frameKey(const Scene& scene, const ViewState& state);

// Returns the pose that a character is to take.
PoseKey poseKey(const Scene& scene, const ViewState& state, std::size_t character);
// Returns all other keys, once everyone stands as `state` says. `field_on_cpu` tells where a ground with heights is
// computed.
ViewKeys keysOf(const Scene& scene, const ViewState& state, bool field_on_cpu = true);

// Returns the way that shadows of others join: only pictures that have such shadows have another one than the product.
CastMode shownCastMode(const ViewState& state);
// Returns the channel that a character shows where another one is wished that it lacks.
Channel shownChannel(const Scene& scene, const ViewState& state, std::size_t character);
// Returns the shading forms that every chosen material and the chosen light support (operators, fitted lobes).
ShadingChoice shownShading(const Scene& scene, const ViewState& state);
// Tells whether a level ground hides light from characters and sends light back: one that is shown and casts.
bool groundCasts(const Scene& scene, const ViewState& state);
// Tells whether characters and a level ground send light to one another (player/scene/received_light.h).
bool sendsLight(const Scene& scene, const ViewState& state);
// Tells whether shadows, and a level ground where it casts, change numbers of this character.
bool changesCoefficients(const Scene& scene, std::size_t character, const CoefficientsKey& key);

}  // namespace penumbra
