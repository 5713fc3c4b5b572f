#include "player/composite/live_light.h"

#include <array>
#include <chrono>
#include <stdexcept>

#include "formats/capture/ball_panorama.h"
#include "formats/capture/bracket_pose.h"
#include "formats/capture/merge_exposures.h"
#include "formats/image/factor_light.h"
#include "formats/image/project_map.h"
#include "sh/sh_rotation.h"

namespace penumbra {

namespace {

constexpr double kPause = 0.5;    // seconds from one light to the next
constexpr int kPanorama = 128;    // pixels of its width: SH of order 6 need no more
constexpr double kWhole = 0.999;  // part of the ball's outline that must be in the picture

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

// Tells whether all of the ball lies in the picture of a camera, without looking at that.
bool isSeenWhole(const LiveBall& ball, const PinholeCamera& camera, const CameraPose& pose) {
    try {
        return outlineOf({{}, camera, pose}, ball.ball).in_picture >= kWhole;
    } catch (const std::invalid_argument&) {  // the camera is inside of the ball, or looks away from it
        return false;
    }
}

// Returns the panorama that a photograph of one exposure shows. None where the ball is not seen.
std::optional<Panorama> panoramaOf(const LiveBall& ball, const PosedPicture& shot, int threads) {
    try {
        Panorama out = panoramaOfBall(shot, ball.ball, {ball.at, kPanorama, 2, threads, Ground::kLevel});
        fillHoles(out, Ground::kLevel);
        return out;
    } catch (const std::invalid_argument&) {  // the camera is inside of the ball, or looks away from it
        return std::nullopt;
    }
}

// Gives what is clipped in the ball the light that falls onto the marker's paper.
void raise(const LiveBall& ball, const PosedPicture& shot, Panorama& panorama) {
    const PaperMeasure paper = measurePaper({&shot, 1}, paperOf(*ball.paper));
    if (!paper.found()) return;
    Vec3d wanted;
    for (int c = 0; c < 3; ++c) wanted[c] = paperIrradiance(paper.radiance[c], ball.paper_reflectance);
    raiseClipped(panorama, {0, 1, 0}, wanted);
}

}  // namespace

LiveLight::LiveLight(const LiveBall& ball, int order, const CameraResponse& response, double exposure)
    : ball_(ball), order_(order), response_(response), exposure_(exposure) {}

// The scene turns every light as it turns its own, and this one must stay as it was seen: it is turned back before.
void LiveLight::turnToScene() {
    const std::size_t count = sh_.size() / 3;
    const ShRotation back = makeShRotation(order_, transposed(ball_.scene_turn));
    std::vector<float> from(count), to(count);
    for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t i = 0; i < count; ++i) from[i] = sh_[3 * i + c];
        apply(back, from, to);
        for (std::size_t i = 0; i < count; ++i) sh_[3 * i + c] = to[i];
    }
    for (Sun& sun : suns_) sun.direction = transposed(ball_.scene_turn) * sun.direction;
}

const LightView* LiveLight::update(const TexturePicture& picture, const PinholeCamera& camera, const CameraPose& pose,
                                   int threads) {
    const double start = now();
    if (last_ && start - *last_ < kPause) return nullptr;
    if (!isSeenWhole(ball_, camera, pose)) return nullptr;  // the check costs little, so it is done for every picture
    last_ = start;
    const std::array<double, 1> exposure{exposure_};
    const PosedPicture shot{mergeExposures({&picture, 1}, exposure, response_), camera, pose};
    std::optional<Panorama> panorama = panoramaOf(ball_, shot, threads);
    if (!panorama) return nullptr;
    if (ball_.paper) raise(ball_, shot, *panorama);
    EnvironmentMap map;
    map.image = {panorama->width, panorama->height, std::move(panorama->radiance), {}};
    const std::vector<double> sh = projectMap(map, order_, threads).sh;
    sh_.assign(sh.begin(), sh.end());
    const LightSuns found = factorLight(map, {.suns = 1, .picture_width = 0}, threads);
    suns_.clear();
    for (const SunD& sun : found.suns) suns_.push_back(floatSun(sun));
    // A light that had a sun keeps one: without light where the ball shows none.
    if (suns_.empty()) suns_.push_back(Sun{});
    view_ = {.name = "ball", .order = order_, .sh = sh_, .suns = suns_};
    turnToScene();
    milliseconds_ = 1000 * (now() - start);
    return &view_;
}

}  // namespace penumbra
