#pragma once
// Computes the additions of a scene to photographs, one after another: the picture of its characters, and the ratio of
// the ground.
#include <memory>
#include <optional>

#include "player/composite/ground_ratio.h"
#include "player/composite/lens_resampler.h"
#include "player/composite/pictured_light.h"
#include "player/composite/real_surfaces.h"
#include "player/draw/draw_frame.h"
#include "player/gl/gl_context.h"
#include "player/gl/offscreen_target.h"
#include "player/render/scene_frames.h"

namespace penumbra {

// The additions to one photograph.
struct PhotographFrame {
    Image characters;         // radiance times coverage, of the photograph's size; empty: nobody is drawn
    std::vector<Vec3> ratio;  // [height, width]
};

// Effects of characters on the ground; for comparison one can be left out.
struct GroundParts {
    bool shadow = true, bounce = true;
};

class PhotographFrames {
public:
    // Reads from the options: shading, suns, sun_map, samples and backend. The scene has a photograph, light and a
    // level ground or none, and casts as a product. Throws InvalidInput for another, and what SceneFrames throws.
    // `draws` is false where characters come from elsewhere. The scene outlives this object.
    PhotographFrames(PosedScene& scene, const RenderOptions& options, int threads, bool draws = true);
    ~PhotographFrames();

    const PinholeCamera& camera() const { return cameras_.camera(); }
    const SceneCameras& cameras() const { return cameras_; }
    std::size_t sunCount() const { return frames_.suns().size(); }
    void setParts(const GroundParts& parts) { parts_ = parts; }
    // Takes everyone to a time (as PosedScene::pose()), and adds them to the photograph of this number.
    void compute(std::size_t picture, std::optional<double> seconds, PhotographFrame& out) {
        compute(cameras_.view(picture, scene_.file().origin), seconds, out);
    }
    // The same for a photograph of a camera that stands where a tracker says.
    void compute(const CameraPose& pose, std::optional<double> seconds, PhotographFrame& out) {
        compute(cameras_.viewFrom(pose, scene_.file().origin), seconds, out);
    }
    // SceneFrames::replaceLight(), for the next picture.
    void replaceLight(const LightView& light) {
        frames_.replaceLight(light);
        is_posed_ = false;
    }
    // Milliseconds of the last frame: poses and shading, suns and light from characters, the ground, drawing.
    struct Cost {
        double shade = 0, light = 0, ground = 0, draw = 0;
    };
    const Cost& cost() const { return cost_; }

private:
    struct Drawing;
    PosedScene& scene_;
    RenderOptions options_;
    int threads_;
    SceneCameras cameras_;
    SceneFrames frames_;
    GroundRatio ratio_;
    std::unique_ptr<CastShadow> real_cast_;  // casts of the things in the photograph
    std::vector<SunMaps> maps_, real_maps_;
    std::vector<std::vector<Vec3>> sunlit_;                 // for each member, the radiance of its vertices with suns
    std::vector<std::unique_ptr<PicturedLight>> pictured_;  // for each member that shows pictures
    std::vector<Emitter> emitters_;
    std::unique_ptr<Drawing> drawing_;
    bool draws_;                         // true if characters are drawn
    std::vector<RealSurface> surfaces_;  // surfaces in the photograph: members, then meshes
    std::optional<double> posed_;        // time of the current pose
    GroundParts parts_;
    bool is_posed_ = false;
    Cost cost_;

    void compute(const SceneView& view, std::optional<double> seconds, PhotographFrame& out);
    bool pose(std::optional<double> seconds);  // returns whether anybody may have moved
    void shineSuns();
    void findEmitters();
    void addSuns(std::size_t member, Vec3 eye);
    void joinPictures(std::size_t member);
    GroundLight groundLight() const;
    bool hasReal() const;
    void makeSurfaces();
    void poseSurfaces();
    void addSurfaces(const SceneView& view, std::vector<Vec3>& ratio);
};

}  // namespace penumbra
