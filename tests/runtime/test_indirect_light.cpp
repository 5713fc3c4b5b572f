// Light that bounces at run time: the light that it takes, and what others leave of it.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "runtime/shade/indirect_light.h"
#include "sh/far/far_visibility.h"

namespace penumbra::test_indirect_light {
namespace {

TEST(IndirectLight, OthersLeaveTheShareOfAWhiteSky) {
    // Nothing is hidden from the first vertex, half of every direction from the second, everything from the third.
    std::vector<float> mirrored(3 * kFarCoefficients), indirect(3 * kIndirectStride, 2.0f);
    mirrored[0] = 2 * std::sqrt(std::numbers::pi_v<float>);
    mirrored[kFarCoefficients] = std::sqrt(std::numbers::pi_v<float>);
    castOnIndirect(mirrored, indirect);
    for (std::size_t i = 0; i < kIndirectStride; ++i) {
        EXPECT_NEAR(indirect[i], 2, 1e-5);
        EXPECT_NEAR(indirect[kIndirectStride + i], 1, 1e-5);
        EXPECT_EQ(indirect[2 * kIndirectStride + i], 0);
    }
}

TEST(IndirectLight, UniformLightHasAConstantAlone) {
    std::array<Vec3, kIndirectCoefficients> light{};
    light[0] = {2, 3, 4};
    const ColorAxes axes;  // red, green, blue
    const std::array<Vec3, kBouncedLight> bounced = makeBouncedLight(axes, light);
    EXPECT_EQ(bounced[0], (Vec3{2, 0, 0}));
    EXPECT_EQ(bounced[10], (Vec3{0, 3, 0}));
    EXPECT_EQ(bounced[11], (Vec3{0, 0, 4}));
    for (std::size_t i = 1; i < 10; ++i) EXPECT_EQ(bounced[i], Vec3{});
}

TEST(IndirectLight, NumbersGiveBackWhatTheAxesSpan) {
    const Vec3 first = normalized(Vec3{3, 2, 1}), second = normalized(cross(first, Vec3{0, 1, 0}));
    const ColorAxes axes = fromRows(first, second, cross(first, second));
    std::vector<float> transfer(3 * 16), coefficients(kIndirectSize);  // order 4; bands 3 and 4 do not count
    for (std::size_t i = 0; i < 16; ++i)
        for (int c = 0; c < 3; ++c) transfer[std::size_t(c) * 16 + i] = (1 + float(i)) * first[c];
    transfer[0] += 0.5f;  // another colour, in band 0 alone
    toIndirectCoefficients(axes, transfer, coefficients);
    for (std::size_t i = 0; i < kIndirectCoefficients; ++i)
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(indirectCoefficient(axes, coefficients, i)[c], transfer[std::size_t(c) * 16 + i], 1e-5);
}

}  // namespace
}  // namespace penumbra::test_indirect_light
