#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "formats/image/exposure.h"

namespace penumbra::test_exposure {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();

Image greys(const std::vector<float>& values) {
    Image image{int(values.size()), 1, {}, {}};
    for (const float value : values) image.pixels.push_back({value, value, value});
    return image;
}

// The 90th percentile of the greys 1..100 is 90, in any order.
TEST(AutomaticExposure, ShowsThePercentileAsTheStatedValue) {
    std::vector<float> values;
    for (int i = 0; i < 100; ++i) values.push_back(float(1 + i * 37 % 100));
    EXPECT_FLOAT_EQ(automaticExposure(greys(values)), 0.006667f);
    EXPECT_NEAR(90 * automaticExposure(greys(values)), kExposedValue, 1e-4);
    const std::vector<std::uint8_t> bytes = displayedBytes(greys({90}), automaticExposure(greys(values)));
    EXPECT_EQ(bytes[0], 203);
}

// Rec.709: a green of 1 has the luminance 0.7152.
TEST(AutomaticExposure, MeasuresLuminance) {
    const Image green{1, 1, {{0, 1, 0}}, {}};
    EXPECT_FLOAT_EQ(automaticExposure(green), 0.8389f);  // 0.6 / 0.7152
}

TEST(AutomaticExposure, LeavesABlackPictureAlone) {
    EXPECT_EQ(automaticExposure(greys({0, 0, 0})), 1);
    EXPECT_EQ(automaticExposure(greys({0, -1, kNan})), 1);
    EXPECT_EQ(automaticExposure(Image{}), 1);
    EXPECT_EQ(automaticExposure(Image{1, 1, {{5, 5, 5}}, {0}}), 1) << "nothing covers the pixel";
}

// A highlight does not darken the picture, and one lit pixel among black ones decides alone.
TEST(AutomaticExposure, OneBrightPixel) {
    std::vector<float> values(100, 0.3f);
    values[7] = 1e5f;
    EXPECT_FLOAT_EQ(automaticExposure(greys(values)), 2);
    values.assign(100, 0);
    values[7] = 12;
    EXPECT_FLOAT_EQ(automaticExposure(greys(values)), 0.05f);
}

TEST(AutomaticExposure, LeavesOutWhatIsNotANumber) {
    EXPECT_FLOAT_EQ(automaticExposure(greys({kNan, 0.3f, kInf, -kInf, kNan})), 2);
    EXPECT_FLOAT_EQ(automaticExposure(Image{2, 1, {{8, 8, 8}, {0.3f, 0.3f, 0.3f}}, {kNan, 1}}), 2);
}

// Colours are multiplied by alpha. The background (alpha 0) and faint edges do not count.
TEST(AutomaticExposure, CountsWhatIsCovered) {
    const Image image{3, 1, {{0.2f, 0.2f, 0.2f}, {0.1f, 0.1f, 0.1f}, {9, 9, 9}}, {0.5f, 0.25f, 0}};
    EXPECT_FLOAT_EQ(automaticExposure(image), 1.5f);  // 0.6 / (0.2 / 0.5)
}

TEST(AutomaticExposure, IsBounded) {
    EXPECT_EQ(automaticExposure(greys({1e30f})), kMinExposure);
    EXPECT_EQ(automaticExposure(greys({1e-30f})), kMaxExposure);
    EXPECT_EQ(automaticExposure(greys({std::numeric_limits<float>::denorm_min()})), kMaxExposure);
}

// Brightness of the light cancels: what a PNG shows is the same to a step.
TEST(AutomaticExposure, CancelsTheBrightnessOfTheLight) {
    std::vector<float> dim, bright;
    for (int i = 1; i <= 50; ++i) {
        dim.push_back(1e-3f * float(i));
        bright.push_back(1e4f * float(i));
    }
    const std::vector<std::uint8_t> a = displayedBytes(greys(dim), automaticExposure(greys(dim)));
    const std::vector<std::uint8_t> b = displayedBytes(greys(bright), automaticExposure(greys(bright)));
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1) << i;
}

}  // namespace
}  // namespace penumbra::test_exposure
