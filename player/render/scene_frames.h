#pragma once
// Computes frames of a scene, one after another, in whatever pose the scene has. What its materials and its light need
// is made once.
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "player/draw/draw_frame.h"
#include "player/frame/shot.h"
#include "player/scene/scene_ground.h"
#include "player/scene/scene_receivers.h"

namespace penumbra {

// A mesh as it is drawn. The spans point into SceneFrames.
struct SceneMesh {
    std::span<const std::uint32_t> triangles;
    std::span<const Vec3> positions, values;  // what ValuePainter takes
    Sides sides = Sides::kBoth;
};

class SceneFrames {
public:
    // Of the options it reads size, camera, channel (shaded or ambient) and shading. Shaded members need materials, and
    // the scene a light: UsageError. The scene outlives this object.
    SceneFrames(const PosedScene& scene, const RenderOptions& options, int threads);

    // The steps of a frame, in their order.
    void evaluateMembers();
    void evaluateGround();
    void shade();
    // Results of the steps, valid until the next ones: every member, then the ground, and how the camera sees them.
    std::vector<SceneMesh> meshes() const;
    const FrameView& view() const { return view_; }

    const std::vector<FrameVertices>& members() const { return members_; }
    const GroundVertices& ground() const { return ground_; }  // empty without a ground

private:
    // How a member looks. It stays where it is, because the shot points to the view.
    struct Look {
        AssetView view;  // the member's asset with the light of the scene
        Shot shot;
        std::optional<ShadingSet> shading;
        Look(const PosedScene& scene, const SceneMember& member, const RenderOptions& options);
    };

    const PosedScene& scene_;
    RenderOptions options_;
    int threads_;
    std::vector<std::unique_ptr<Look>> looks_;
    std::vector<FrameVertices> members_;
    GroundVertices ground_;
    FrameView view_;
    std::vector<std::vector<Vec3>> values_;  // of each member, then of the ground

    void findView();
};

}  // namespace penumbra
