#pragma once
// The window's ground with heights where the GPU computes it.
#include <map>
#include <memory>

#include "player/draw/gl_heights_ground.h"
#include "player/view/view_sunlight.h"

namespace penumbra {

class ViewField {
public:
    // The scene has a ground with heights, and outlives this object. updateScene() must have been called.
    explicit ViewField(const Scene& scene);
    ViewField(const ViewField&) = delete;  // the grounds point to the heights

    const GlHeights& heights() const { return heights_; }
    // Takes over what has changed of the heights.
    void update();
    // Computes what the points show to `eye`. `suns` have shone, or are null where they do not shine.
    void evaluate(const ViewState& state, Vec3 eye, GlCast& cast, const ViewSunlight* suns);
    // Draws what was evaluated last.
    void draw(const FrameView& view, const Sunlight* suns) const;

private:
    // One way to show the points.
    struct Look {
        bool lit = false, sunlit = false;
        auto operator<=>(const Look&) const = default;
    };
    struct Shown {
        FieldShading shading;
        std::optional<GlHeightsGround> ground;
        Cached<LightKey> light;  // light of the shading
        Shown(const SceneGround& of, const Convention& convention, const AssetView& asset, const LightView& room)
            : shading(of, convention, asset, room) {}
    };
    const Scene* scene_;
    GlHeights heights_;
    std::map<Look, std::unique_ptr<Shown>> shown_;  // made when they are first needed
    Look last_;

    Shown& shownAs(const Look& look, const ViewSunlight* suns);
};

}  // namespace penumbra
