#include "player/composite/live_light.h"

#include <array>
#include <chrono>
#include <stdexcept>

#include "formats/capture/ball_panorama.h"
#include "formats/capture/bracket_pose.h"
#include "formats/capture/merge_exposures.h"
#include "formats/image/factor_light.h"
#include "formats/image/project_map.h"

namespace penumbra {

namespace {

constexpr double kPause = 0.5;    // seconds from one light to the next
constexpr int kPanorama = 128;    // pixels of its width: SH of order 6 need no more
constexpr double kWhole = 0.999;  // part of the ball's outline that must be in the picture

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

// What a photograph of one exposure shows of the light. None where the ball is not seen whole.
std::optional<Panorama> panoramaOf(const LiveBall& ball, const PosedPicture& shot, int threads) {
    try {
        if (outlineOf(shot, ball.ball).in_picture < kWhole) return std::nullopt;
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

const LightView* LiveLight::update(const TexturePicture& picture, const PinholeCamera& camera, const CameraPose& pose,
                                   int threads) {
    const double start = now();
    if (last_ && start - *last_ < kPause) return nullptr;
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
    view_ = {.name = "ball", .order = order_, .sh = sh_, .suns = suns_};
    last_ = start;
    milliseconds_ = 1000 * (now() - start);
    return &view_;
}

}  // namespace penumbra
