#pragma once
// Draws frames of a scene that the GPU evaluates, casts and shades, in whatever pose the scene has.
#include <memory>
#include <optional>
#include <vector>

#include "player/draw/gl_ground.h"
#include "player/draw/gl_heights_ground.h"
#include "player/draw/model_painter.h"
#include "player/render/scene_look.h"
#include "player/scene/scene_ground.h"
#include "player/scene/scene_receivers.h"

namespace penumbra {

// Tells whether the GPU can evaluate the picture. It has the default way of casting, draws everyone, and has no level
// ground that casts.
bool fitsGpu(const PosedScene& scene, const RenderOptions& options);

class SceneOnGpu {
public:
    // Takes what SceneFrames takes, and throws what it throws. Throws Unsupported where the scene is too large for this
    // OpenGL.
    SceneOnGpu(const PosedScene& scene, const RenderOptions& options, int threads);

    // Uploads the poses, casts, evaluates and shades.
    void evaluate();
    // Draws what was evaluated last, as `view` of the scene. `suns` are not null where suns() shine.
    void draw(const FrameView& view, const Sunlight* suns = nullptr) const;
    // Inputs of suns, see SceneFrames.
    std::span<const Sun> suns() const { return sunlight_.suns; }
    SunCasters sunCasters() const;
    const LobeTable& lobes() const { return sunlight_.lobes; }
    const Mat3& lightRotation() const { return sunlight_.light_rotation; }
    const FrameView& view() const { return view_; }                               // by the options' camera
    const GlHeights* heights() const { return heights_ ? &*heights_ : nullptr; }  // heights of the ground

private:
    // Members of one asset, which are drawn together.
    struct Group {
        std::shared_ptr<GlAsset> asset;
        std::optional<ModelPainter> painter;
        std::vector<std::size_t> members;
    };

    const PosedScene& scene_;
    RenderOptions options_;
    int threads_;
    std::vector<std::unique_ptr<SceneLook>> looks_;  // one for each member
    SceneSunlight sunlight_;
    std::vector<FrameVertices> members_;  // for the camera, suns, and the numbers that an asset needs
    std::vector<Group> groups_;
    std::vector<GlCaster> casters_;
    std::optional<GlCast> cast_;
    std::optional<GlGround> ground_;
    std::vector<Vec3> ground_weights_;
    // Set for a ground with heights. Suns use its points and triangles.
    std::optional<GlHeights> heights_;
    std::optional<FieldShading> field_shading_;
    std::optional<GlHeightsGround> heights_ground_;
    std::vector<Vec3> field_points_;
    std::vector<std::uint32_t> field_triangles_;
    FrameView view_;
    std::vector<PosedCharacter> posed_;

    void makeGroups();
    void makeGround();
    void makeHeights();
    void evaluate(Group& group);
};

}  // namespace penumbra
