// Pictures that look around become the light at a character, and paper is the light meter.
#include <gtest/gtest.h>

#include <numbers>

#include "formats/capture/paper_meter.h"
#include "formats/capture/roam_panorama.h"
#include "tests/difference.h"
#include "tests/synthetic_photos.h"

namespace penumbra::test_roam_panorama {
namespace {

using std::numbers::pi;

const PinholeCamera kCamera{110, 79.5, 59.5, 160, 120, -0.1, 0.01};
const PaperTag kTag{0.5, 8};
constexpr double kReflectance = 0.8;
const Vec3d kSun = normalized(Vec3d{-0.5, -0.3, 0.8});
constexpr double kSunRadius = 1.5 * pi / 180;

// Sky, ground and a sheet of paper with a black square, lit by a sun of irradiance 3 at normal incidence.
Vec3d place(Vec3d from, Vec3d ray) {
    if (dot(ray, kSun) > std::cos(kSunRadius)) return Vec3d{3, 3, 3} / (2 * pi * (1 - std::cos(kSunRadius)));
    if (ray.z > -1e-6) return {0.5, 0.7, 1};
    const Vec3d at = from - (from.z / ray.z) * ray;
    const Vec3d irradiance = pi * Vec3d{0.5, 0.7, 1} + 3 * kSun.z * Vec3d{1, 1, 1};
    const double side = std::max(std::abs(at.x), std::abs(at.y));
    const double albedo = side < 0.25 ? 0.04 : side < 0.3125 ? kReflectance : 0.3;
    return albedo / pi * irradiance;
}

// Looks up, around and down from near `at`.
std::vector<PosedPicture> lookAround(Vec3d at, int samples) {
    std::vector<PosedPicture> shots;
    for (double z : {-3.0, -0.6, 0.4, 3.0})
        for (int n = 0; n < 8; ++n) {
            const Vec3d eye = at + Vec3d{0.1 * std::cos(n), 0.1 * std::sin(n), 0.05 * std::sin(3.0 * n)};
            const Vec3d ray{std::cos(n * pi / 4 + 0.3), std::sin(n * pi / 4 + 0.3), z};
            shots.push_back(photograph(kCamera, lookingAt(eye, eye + ray), samples, place));
        }
    return shots;
}

// Clips a picture at a radiance, as a camera does.
void clip(std::vector<PosedPicture>& shots, float most) {
    for (PosedPicture& shot : shots)
        for (std::size_t i = 0; i < shot.picture.radiance.size(); ++i)
            for (int c = 0; c < 3; ++c)
                if (shot.picture.radiance[i][c] > most) {
                    shot.picture.radiance[i][c] = most;
                    shot.picture.at_least[i] |= std::uint8_t(1u << c);
                }
}

double errorAt(Panorama p, Vec3d at) {
    fillHoles(p, Ground::kLevel);
    const Panorama truth = paintPanorama(p.width, 3, 2, [&](Vec3d d) -> SeenLight {
        return {toFloat(place(at, d)), {}, 0, 1};
    });
    return relativeDifference(projectedInMarkerFrame(p, 6), projectedInMarkerFrame(truth, 6));
}

// Measured .016: the sun's disc through pixels of half a degree.
TEST(RoamPanorama, IsTheLightAtTheCharacter) {
    const Vec3d at{0.05, 0, 0.9};
    const Panorama p = panoramaOfPictures(lookAround(at, 4), {at, 256, 3, 2, Ground::kLevel});
    EXPECT_LT(errorAt(p, at), 0.04);
}

TEST(RoamPanorama, AClippedSunIsRaisedByThePaper) {
    const Vec3d at{0.05, 0, 0.9};
    std::vector<PosedPicture> shots = lookAround(at, 4);
    clip(shots, 20);
    Panorama p = panoramaOfPictures(shots, {at, 256, 3, 2, Ground::kLevel});
    EXPECT_GT(errorAt(p, at), 0.3);
    const PaperMeasure paper = measurePaper(shots, kTag);
    ASSERT_TRUE(paper.found());
    const Vec3d irradiance = pi * Vec3d{0.5, 0.7, 1} + 3 * kSun.z * Vec3d{1, 1, 1};
    const Vec3d measured{paperIrradiance(paper.radiance.x, kReflectance),
                         paperIrradiance(paper.radiance.y, kReflectance),
                         paperIrradiance(paper.radiance.z, kReflectance)};
    EXPECT_LT(relativeDifference(measured, irradiance), 1e-4);
    raiseClipped(p, {0, 1, 0}, measured);
    EXPECT_LT(errorAt(p, at), 0.06);
}

TEST(PaperMeter, TellsThatPaperIsClippedOrNotSeen) {
    std::vector<PosedPicture> shots = lookAround({0, 0, 0.9}, 1);
    clip(shots, 0.1f);
    const PaperMeasure clipped = measurePaper(shots, kTag);
    EXPECT_GT(clipped.places, 0u);
    EXPECT_FALSE(clipped.found());
    std::vector<PosedPicture> up;
    up.push_back(photograph(kCamera, lookingAt({0, 0, 1}, {0, 1, 2}), 1, place));
    EXPECT_EQ(measurePaper(up, kTag).places, 0u);
}

// One picture is clipped where another is not: the other one counts.
TEST(RoamPanorama, WhatIsNotClippedCountsMore) {
    std::vector<PosedPicture> shots;
    for (float light : {1.0f, 4.0f}) {
        shots.push_back(photograph(kCamera, lookingAt({0, 0, 1}, {0, 1, 1}), 1, [&](Vec3d, Vec3d) {
            return Vec3d{1, 1, 1} * double(light);
        }));
    }
    for (std::uint8_t& bits : shots[0].picture.at_least) bits = 7;
    const Panorama p = panoramaOfPictures(shots, {{0, 0, 1}, 64, 2, 1, Ground::kLevel});
    for (std::size_t i = 0; i < p.radiance.size(); ++i) {
        if (p.seen[i] > 0) {
            ASSERT_NEAR(p.radiance[i].x, 4, 0.05);
        }
    }
}

}  // namespace
}  // namespace penumbra::test_roam_panorama
