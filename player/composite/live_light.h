#pragma once
// Light from a mirror ball in the photographs of a window, so that characters are lit as the place is now.
#include <optional>
#include <vector>

#include "formats/asset/asset_file.h"
#include "formats/camera/tag_detector.h"
#include "formats/image/texture_file.h"
#include "sh/light/dominant_light.h"
#include "sh/light/mirror_ball.h"
#include "sh/pinhole_camera.h"

namespace penumbra {

struct LiveBall {
    MirrorBall ball;  // metres of the marker's frame
    Vec3d at;         // where the light is wanted
    // The white paper of the marker, from whose light the clipped part of the ball's picture is raised.
    std::optional<TagChoice> paper = {};
    double paper_reflectance = 0.8;
    Mat3 scene_turn = {};  // rotation of the scene's light; a light that was found is turned back by it
};

class LiveLight {
public:
    // The light has SH of this order and one sun, which is dark where the ball shows none.
    LiveLight(const LiveBall& ball, int order, const CameraResponse& response, double exposure);
    // Takes the light from a photograph. None where the ball is not seen whole, and while less than half a second has
    // gone by since the last one.
    const LightView* update(const TexturePicture& picture, const PinholeCamera& camera, const CameraPose& pose,
                            int threads);
    double milliseconds() const { return milliseconds_; }  // time of the last update

private:
    LiveBall ball_;
    int order_;
    CameraResponse response_;
    double exposure_, milliseconds_ = 0;
    std::optional<double> last_;  // seconds of the steady clock
    std::vector<float> sh_;
    std::vector<Sun> suns_;
    LightView view_;

    void turnToScene();
};

}  // namespace penumbra
