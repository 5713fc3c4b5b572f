#pragma once
// Computes frames of a scene, one after another, in whatever pose the scene has. What its materials and its light need
// is made once. Others cast as PosedScene::castWay() says.
#include <memory>
#include <span>
#include <vector>

#include "formats/scene/scene_camera.h"
#include "player/draw/draw_frame.h"
#include "player/render/scene_look.h"
#include "player/scene/scene_ground.h"
#include "player/scene/scene_receivers.h"
#include "sh/bounding_box.h"

namespace penumbra {

// A mesh as it is drawn. The spans point into SceneFrames.
struct SceneMesh {
    std::span<const std::uint32_t> triangles;
    std::span<const Vec3> positions, values;  // inputs of ValuePainter
    Sides sides = Sides::kBoth;
    Channel channel = Channel::kShaded;   // channel of the values
    SunlitSurface surface = {};           // where suns shine
    bool is_ground = false;               // true for the ground, whose triangles change in every frame
    const MeshView* mesh = nullptr;       // set for a member
    const ShadingSet* shading = nullptr;  // set for a member that is shaded and whose pictures may be drawn
};

class SceneFrames {
public:
    // Reads from the options: size, camera, channel (shaded, ambient or error) and shading. Shaded members need
    // materials, and the scene a light: UsageError. `truth` is for the error channel: members whose mesh it was baked
    // for and whose frame it has show |E of the model - E of the truth|, both past the same casters. The others and the
    // ground show E. Throws InvalidInput where it fits nobody. The scene and the truth outlive this object.
    SceneFrames(const PosedScene& scene, const RenderOptions& options, int threads, const AssetView* truth = nullptr);

    // The steps of a frame, in their order.
    void evaluateMembers();
    void evaluateGround();
    // Looks at the members as they stand, by the camera of the options. Frames that follow keep it until the next call.
    void frameCamera();
    void shade();
    void shadeMembers();  // without the ground
    // Lights the members as `light` does, turned as the scene's light is, from the next step on. It has at most the
    // order of the scene's light. Its suns shine where that has suns. `light` outlives this object, or the next call.
    void replaceLight(const LightView& light);
    // Shades the members alone, as seen from a place in the scene that is not the camera of the options.
    void shadeFrom(Vec3 eye) {
        view_.eye = eye;
        shadeMembers();
    }
    // Returns what others receive, after shade() or shadeMembers(). It is nothing where light between members is left
    // out.
    SentLight sentLight();
    // Results of the steps, valid until the next ones: every member, then the ground, and how the camera sees them.
    std::vector<SceneMesh> meshes() const;
    const FrameView& view() const { return view_; }
    // Inputs of suns: themselves, their casters, and the lobes of all materials. No suns: all light is SH.
    std::span<const Sun> suns() const { return sunlight_.suns; }
    SunCasters sunCasters() const;
    const LobeTable& lobes() const { return sunlight_.lobes; }
    const Mat3& lightRotation() const { return sunlight_.light_rotation; }

    const std::vector<FrameVertices>& members() const { return members_; }
    // Radiance of a member's vertices, without suns; empty if it is not drawn.
    const std::vector<Vec3>& valuesOf(std::size_t member) const { return values_[member]; }
    const SceneLook& lookOf(std::size_t member) const { return *looks_[member]; }
    const SceneSunlight& sunlight() const { return sunlight_; }
    const GroundVertices& ground() const { return ground_; }  // empty without a level ground
    const FrameVertices& field() const { return field_; }     // empty without a ground with heights

private:
    const PosedScene& scene_;
    RenderOptions options_;
    int threads_;
    std::vector<std::unique_ptr<SceneLook>> looks_;
    std::vector<FrameVertices> members_;
    GroundVertices ground_;
    FrameVertices field_;
    std::vector<std::uint32_t> field_triangles_;
    std::vector<Vec3> field_casting_;  // in the maps of suns
    std::vector<std::uint32_t> field_casting_triangles_;
    std::optional<FieldLook> field_look_;    // where it is shaded
    std::vector<std::vector<float>> casts_;  // for modes that compare: V_c of each member, then of the ground
    FrameView view_;
    std::vector<std::vector<Vec3>> values_;  // for each member, then for the ground
    // Light that the ground and members send to one another.
    std::vector<HiddenSky> hidden_;  // one for each member
    GroundGlow glow_;
    std::vector<ShiningMember> shining_;                        // one for each member
    bool shines_ = false;                                       // they are those of this frame
    std::vector<std::size_t> receivers_;                        // members that others hide something of the sky from
    std::vector<Vec3> standing_;                                // corners of the boxes of all members
    std::vector<std::vector<std::uint32_t>> shining_vertices_;  // the ones that stand for each member
    std::vector<std::vector<Vec3>> sent_;                       // their radiance, [V]
    LightView whole_light_;                                     // with its suns
    SceneSunlight sunlight_;
    std::vector<LobeRange> ground_lobes_;    // one for each vertex
    std::vector<std::vector<float>> sight_;  // sight of each member's mirrors
    std::vector<float> field_sight_;         // for a ground with heights that is a mirror

    bool compares() const { return scene_.castWay().mode != CastMode::kProduct; }
    void attachTruth(const AssetView& truth);
    bool receives() const;
    void castOnGlow();
    void receiveFromMembers();
    void findShining();
    Channel channelOf(std::size_t member) const;
    FrameVertices trueMember(std::size_t member) const;
    std::vector<float> memberAmbient(std::size_t member, const FrameVertices& vertices) const;
    void findMemberValues(std::size_t member);
    void findGroundValues();
    void makeField();
};

// Writes the matrix of a photograph's camera without its lens, with depths that hold the boxes and `reach` metres
// around them.
void clipFromPhotograph(const SceneView& view, std::span<const BoundingBox> boxes, double reach,
                        std::span<float, 16> out);

// How the camera sees the scene: the first photograph where the file has one and the options name no other. `members`
// have positions in the scene. Of the options it reads size and camera.
FrameView sceneView(const PosedScene& scene, const RenderOptions& options, std::span<const FrameVertices> members);

}  // namespace penumbra
