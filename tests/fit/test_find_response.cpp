// The response of a camera from brackets that this test makes: known curves come back, and what tells none is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <string>

#include "fit/camera/find_response.h"
#include "formats/common/errors.h"
#include "tests/difference.h"

namespace penumbra::test_find_response {
namespace {

using ::testing::HasSubstr;

// A curve with a toe and a shoulder, as film has: its code falls short of a power law at both ends.
float filmCode(double light) {
    const double power = std::pow(std::min(light, 1.0), 0.42);
    return float(255 * power * (1 + 0.6 * power) / (0.25 + 1.35 * power));
}

float codeOfLight(const char* curve, double light) {
    static std::map<std::string, std::optional<CameraResponse>> known;  // a table takes long to make
    if (!known.contains(curve)) known[curve] = knownResponse(curve);
    const std::optional<CameraResponse>& response = known[curve];
    return response ? codeOf(*response, 0, float(std::min(light, 1.0))) : filmCode(light);
}

// 12 x 12 flat fields over 5 decades of light, with noise, at exposures two stops apart.
BracketPictures fieldsUnder(const char* curve, double gain = 1) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    BracketPictures out{"b.json", {}, {}};
    for (int k = 0; k < 6; ++k) {
        out.exposures.push_back(std::pow(4.0, -k));
        TexturePicture& picture = out.pictures.emplace_back(TexturePicture{144, 144, {}});
        for (int y = 0; y < 144; ++y)
            for (int x = 0; x < 144; ++x)
                for (int c = 0; c < 3; ++c) {
                    const int field = 12 * (y / 12) + x / 12;
                    const double light = gain * 2e-3 * std::pow(10.0, field * 5.0 / 143) * out.exposures.back();
                    const double noisy = light + (0.0015 + 0.004 * std::sqrt(light)) * normal(random);
                    picture.rgb.push_back(std::uint8_t(std::lround(codeOfLight(curve, std::max(noisy, 0.0)))));
                }
    }
    return out;
}

// rms of the relative error between codes 10 and 245, after the best common factor.
double curveError(const CameraResponse& found, const char* curve) {
    Largest worst;
    for (std::size_t c = 0; c < 3; ++c) {
        double ratio = 0, square = 0;
        std::vector<double> ratios;
        for (int i = 1; i < 4000; ++i) {
            const double light = i / 4000.0;
            const float code = codeOfLight(curve, light);
            if (code < 10 || code > 245) continue;
            ratios.push_back(exposureOf(found, int(c), code) / light);
            ratio += ratios.back() / 4000;
            square += ratios.back() * ratios.back() / 4000;
        }
        double sum = 0;
        for (const double one : ratios) sum += std::pow(one * ratio / square - 1, 2) / double(ratios.size());
        worst.add(std::sqrt(sum));
    }
    return worst;
}

// Measured: srgb .003, rec709 .003, linear .005, film .014.
TEST(FindResponse, BringsKnownCurvesBack) {
    for (const char* curve : {"srgb", "rec709", "linear", "film"}) {
        const FoundResponse found = findResponse(fieldsUnder(curve));
        EXPECT_LE(curveError(found.response, curve), 0.03) << curve;
        for (const ResponseQuality& channel : found.channels) {
            EXPECT_GT(channel.samples, 30);
            EXPECT_LE(channel.rms, 0.1);
        }
        for (const auto& channel : found.response.exposure) {
            EXPECT_TRUE(std::ranges::is_sorted(channel));
            EXPECT_EQ(channel.back(), 1);
        }
    }
}

std::string problemOf(const BracketPictures& bracket) {
    try {
        (void)findResponse(bracket);
    } catch (const InvalidInput& problem) {
        return problem.what();
    }
    return "none";
}

TEST(FindResponse, RefusesWhatTellsNone) {
    EXPECT_THAT(problemOf(fieldsUnder("srgb", 1e9)), HasSubstr("b.json: 0 places show a usable red"));
    EXPECT_THAT(problemOf(fieldsUnder("srgb", 1e9)), HasSubstr("100% of all codes are clipped"));
    EXPECT_THAT(problemOf(fieldsUnder("srgb", 0)), HasSubstr("0% of all codes are clipped"));
    BracketPictures apart = fieldsUnder("srgb");  // so far that the second shows nothing
    apart.pictures.resize(2);
    apart.exposures = {1, 1e-9};
    std::ranges::fill(apart.pictures[1].rgb, std::uint8_t(0));
    EXPECT_THAT(problemOf(apart), HasSubstr("take exposures that are nearer to one another"));
}

}  // namespace
}  // namespace penumbra::test_find_response
