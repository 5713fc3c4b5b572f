// How the papers capture light: goldens, and the errors that they have.
#include <gtest/gtest.h>

#include <numbers>

#include "fit/papers/capture/ball_crop.h"
#include "fit/papers/capture/merge_unbounded.h"
#include "tests/difference.h"
#include "tests/sh/golden.h"
#include "tests/synthetic_photos.h"

namespace penumbra::test_paper_capture {
namespace {

using std::numbers::pi;

TEST(MergeUnbounded, IsTheGoldenMerge) {
    const nlohmann::json golden = readGolden("light_capture.json")["merge"];
    const std::vector<double> exposures = doubles(golden["exposures"]), radiance = doubles(golden["radiance"]);
    const CameraResponse srgb = *knownResponse("srgb");
    for (std::size_t i = 0; i < radiance.size(); ++i) {
        std::vector<std::uint8_t> codes;
        for (const nlohmann::json& row : golden["z"]) codes.push_back(row[i]);
        const MergedCode merged = mergeCodes(codes, exposures, srgb, 1);
        EXPECT_NEAR(merged.radiance / radiance[i], 1, 1e-6);  // the response is stored as floats
        EXPECT_EQ(merged.clipped, bool(golden["clipped"][i]));
    }
}

TEST(BallCrop, WeightsSumToTheSphere) {
    for (CropFormula formula : {CropFormula::kFarBall, CropFormula::kEquationSix}) {
        const int width = 256;
        double sum = 0;
        for (int y = 0; y < width; ++y)
            for (int x = 0; x < width; ++x)
                if (const auto crop =
                        cropDirection(formula, (2 * x + 1.0) / width - 1, (2 * y + 1.0) / width - 1, width))
                    sum += crop->steradians;
        EXPECT_NEAR(sum / (4 * pi), 1, 1e-4);
    }
}

std::vector<double> cropOf(const std::string& light, double distance, CropFormula formula) {
    const MirrorBall ball{distance * normalized(Vec3d{0.4, -0.8, -0.3}), 1, 1};
    const double k = 1 / distance, reach = k / std::sqrt(1 - k * k);
    const PinholeCamera camera{256 / reach, 255.5, 255.5, 512, 512, 0, 0};
    const PosedPicture shot = photograph(camera, lookingAt({}, ball.center), 1,
                                         withBall(ball, [&](Vec3d, Vec3d ray) { return goldenLight(light, ray); }));
    return projectCrop(shot, ball, formula, 4, 512);
}

// The scene's frame is another one than the golden's: bands have the same norms, so both sides are turned.
std::vector<double> truthOf(const std::string& light) {
    const Panorama p = paintPanorama(256, 2, 2, [&](Vec3d d) -> SeenLight {
        return {toFloat(goldenLight(light, d)), {}, 0, 1};
    });
    std::vector<double> sh(48), basis(16);
    for (int y = 0; y < p.height; ++y)
        for (int x = 0; x < p.width; ++x) {
            evalBasis(4, latLongDirection((x + 0.5) / p.width, (y + 0.5) / p.height), basis);
            for (std::size_t i = 0; i < 48; ++i)
                sh[i] +=
                    steradiansOfRow(p, y) * basis[i / 3] * double(p.radiance[std::size_t(y * p.width + x)][int(i % 3)]);
        }
    return sh;
}

// The errors of the far-ball formula are the golden ones: .16 .28 .10 at d/r 3 and .009 .016 .006 at 60.
TEST(BallCrop, TheFarBallFormulaErrsAsMeasured) {
    const nlohmann::json table = readGolden("light_capture.json")["photo_errors"];
    const char* lights[] = {"sky and sun", "room", "sunset"};
    for (const auto& [distance, row] : {std::pair(3.0, "d/r 3, 512 px"), {60.0, "d/r 60, 512 px"}})
        for (std::size_t i = 0; i < 3; ++i)
            EXPECT_NEAR(relativeDifference(cropOf(lights[i], distance, CropFormula::kFarBall), truthOf(lights[i])),
                        double(table[row][i]["orthographic"]), 0.003)
                << lights[i] << " " << distance;
}

// Even of a distant ball, equation 6 makes light of another shape: the crop is no angular map.
TEST(BallCrop, EquationSixErrsAtAnyDistance) {
    EXPECT_GT(relativeDifference(cropOf("room", 60, CropFormula::kEquationSix), truthOf("room")), 0.5);
}

}  // namespace
}  // namespace penumbra::test_paper_capture
