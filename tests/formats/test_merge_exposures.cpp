// Exposures become radiance: what is not clipped, what is, and pictures that do not belong together.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/capture/merge_exposures.h"
#include "formats/capture/shot_pictures.h"
#include "tests/difference.h"

namespace penumbra::test_merge_exposures {
namespace {

using ::testing::HasSubstr;

const CameraResponse kLinear = *knownResponse("linear");

TexturePicture gray(std::initializer_list<std::uint8_t> codes) {
    TexturePicture out{int(codes.size()), 1, {}};
    for (std::uint8_t code : codes) out.rgb.insert(out.rgb.end(), 3, code);
    return out;
}

RadiancePicture merged(const std::vector<TexturePicture>& pictures, const std::vector<double>& exposures) {
    return mergeExposures(pictures, exposures, kLinear);
}

TEST(MergeExposures, ExposuresThatAgreeGiveTheirRadiance) {
    const RadiancePicture out = merged({gray({200, 100}), gray({100, 50}), gray({50, 25})}, {1, 0.5, 0.25});
    EXPECT_NEAR(out.radiance[0].x, 200 / 255.0, 1e-6);
    EXPECT_NEAR(out.radiance[1].z, 100 / 255.0, 1e-6);
    EXPECT_EQ(out.at_least[0], 0);
    EXPECT_EQ(out.at_most[0], 0);
}

// w t x and w t^2 by hand: codes 40 at exposure 1/4 and 180 at 1.
TEST(MergeExposures, WeighsLongExposuresMore) {
    const RadiancePicture out = merged({gray({180}), gray({40})}, {1, 0.25});
    const double numerator = 75 * 180 / 255.0 + 40 * 0.25 * 40 / 255.0, denominator = 75 + 40 * 0.0625;
    EXPECT_NEAR(out.radiance[0].y, numerator / denominator, 1e-6);
}

TEST(MergeExposures, AClippedCodeIsALowerBound) {
    // Clipped at 1 and at 1/4, where the lower bound is 4 x 248 / 255; dark in the shortest. No code can be used, and
    // the shortest exposure alone would say 1024 x 2 / 255.
    const RadiancePicture out = merged({gray({255}), gray({248}), gray({2})}, {1, 0.25, 1.0 / 1024});
    EXPECT_NEAR(out.radiance[0].x, 1024 * 2 / 255.0, 1e-3);
    EXPECT_EQ(out.at_least[0], 0);
    // The usable code says less than the clipped one, as blurred colors do.
    const RadiancePicture blurred = merged({gray({255}), gray({30})}, {1, 0.25});
    EXPECT_NEAR(blurred.radiance[0].x, 248 / 255.0, 1e-6);
    // Clipped everywhere.
    const RadiancePicture all = merged({gray({255}), gray({250})}, {1, 0.25});
    EXPECT_GE(all.radiance[0].x, 4 * 248 / 255.0f);
    EXPECT_EQ(all.at_least[0], 7);
}

TEST(MergeExposures, CodesThatAreTooDarkAreMarked) {
    const RadiancePicture out = merged({gray({4, 5}), gray({1, 1})}, {1, 0.25});
    EXPECT_EQ(out.at_most[0], 7);
    EXPECT_EQ(out.at_most[1], 0);
    EXPECT_NEAR(out.radiance[0].x, 4 / 255.0, 1e-6);
}

TEST(MergeExposures, TheOrderOfPicturesDoesNotMatter) {
    const RadiancePicture one = merged({gray({220, 3}), gray({60, 1})}, {1, 0.25}),
                          two = merged({gray({60, 1}), gray({220, 3})}, {0.25, 1});
    EXPECT_EQ(largestDifference(one.radiance, two.radiance), 0);
}

std::string problemOf(const std::vector<TexturePicture>& pictures, const std::vector<double>& exposures) {
    std::vector<std::filesystem::path> files;
    for (std::size_t i = 0; i < pictures.size(); ++i) files.emplace_back("p" + std::to_string(i) + ".png");
    return findProblem(ExposureSet{pictures, exposures, files});
}

TEST(ExposureSet, NamesPicturesThatDoNotBelongTogether) {
    EXPECT_EQ(problemOf({gray({200}), gray({100})}, {1, 0.5}), "");
    EXPECT_EQ(problemOf({gray({200})}, {1}), "");
    EXPECT_THAT(problemOf({gray({200}), gray({100})}, {1, 1}), HasSubstr("p1.png have the same exposure"));
    EXPECT_EQ(problemOf({gray({100}), gray({200})}, {1, 0.5}),
              "p0.png (exposure 1) is darker than p1.png (exposure 0.5): exposures are out of order");
    EXPECT_THAT(problemOf({gray({100}), gray({100})}, {1, 0.5}), HasSubstr("is the same picture as p1.png"));
    EXPECT_EQ(problemOf({gray({100, 2}), gray({2, 1}), gray({2, 1})}, {1, 0.1, 0.01}), "");  // both are black
    EXPECT_THAT(problemOf({gray({255, 249}), gray({250, 248})}, {1, 0.5}), HasSubstr("clipped everywhere"));
    EXPECT_THAT(problemOf({gray({4, 0}), gray({3, 0})}, {1, 0.5}),
                HasSubstr("p0.png (exposure 1) is black everywhere"));
}

}  // namespace
}  // namespace penumbra::test_merge_exposures
