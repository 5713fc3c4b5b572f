#pragma once
// The light at a character, from the photograph of a mirror ball that stands nearby.
#include "formats/capture/posed_picture.h"
#include "sh/light/mirror_ball.h"

namespace penumbra {

struct BallOutline {
    double radius = 0;      // about, pixels
    double in_picture = 0;  // part of the outline that lies in the picture
};
// Throws std::invalid_argument, which says what is wrong: the camera stands inside of the ball, or the ball's middle is
// behind the camera or out of the picture.
BallOutline outlineOf(const PosedPicture& shot, const MirrorBall& ball);

struct BallPanoramaOptions {
    Vec3d at;         // where the light is wanted, metres of the marker's frame, z > 0
    int width = 512;  // pixels of the panorama
    int samples = 2;  // a pixel and axis
    int threads = 0;
    Ground ground = Ground::kLevel;
};
// Gathers: for every direction from `at` it asks where the ball shows what lies there. Directions that go down see the
// ground z = 0, whose places the ball shows elsewhere than what is far away: this halves the error or better
// (docs/ar.md). What lies higher counts as far away. The ball's reflectance is divided out. In the
// outermost kOutlineMargin pixels the picture mixes the ball with what is behind it, so the pixels inside of them stand
// for them.
constexpr double kOutlineMargin = 0.5;
Panorama panoramaOfBall(const PosedPicture& shot, const MirrorBall& ball, const BallPanoramaOptions& options);

}  // namespace penumbra
