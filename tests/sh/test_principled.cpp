// glTF's material, its parts, and sums of models in general.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "sh/brdf/brdf_range.h"
#include "sh/brdf/principled.h"
#include "tests/difference.h"

namespace penumbra::test_principled {
namespace {

using std::numbers::pi;

// The reference implementation of glTF 2.0, appendix B, as it stands there, with the lobe's own formulas: D of
// Trowbridge and Reitz, V of Smith correlated in height.
Vec3d gltfReference(const Principled& m, Vec3d l, Vec3d v) {
    const Vec3d h = normalized(l + v);
    const double a2 = std::pow(m.roughness, 4), denominator = h.z * h.z * (a2 - 1) + 1;
    const double d = a2 / (pi * denominator * denominator);
    const double visible =
        0.5 / (l.z * std::sqrt(v.z * v.z * (1 - a2) + a2) + v.z * std::sqrt(l.z * l.z * (1 - a2) + a2));
    const double power = std::pow(1 - std::abs(dot(v, h)), 5);
    const double root = (1 - m.ior) / (1 + m.ior);
    Vec3d fresnel, metal;
    for (int c = 0; c < 3; ++c) {
        const double f0 = std::min(root * root * m.specular_color[c], 1.0);
        fresnel[c] = f0 + (1 - f0) * power;
        metal[c] = m.color[c] + (1 - m.color[c]) * power;
    }
    const double strongest = std::max({fresnel.x, fresnel.y, fresnel.z});
    Vec3d f;
    for (int c = 0; c < 3; ++c) {
        const double base = m.color[c] / pi,
                     dielectric = (1 - m.specular * strongest) * base + m.specular * fresnel[c] * visible * d;
        f[c] = (1 - m.metallic) * dielectric + m.metallic * metal[c] * visible * d;
    }
    return f;
}

struct RandomDirections {
    std::mt19937 random{7};
    double next(double least, double most) {
        return least + (most - least) * double(random()) / double(std::mt19937::max());
    }
    Vec3d color() { return {next(0, 1), next(0, 1), next(0, 1)}; }
    Vec3d above() {
        const double z = next(0.02, 1), r = std::sqrt(1 - z * z), phi = next(0, 2 * pi);
        return {r * std::cos(phi), r * std::sin(phi), z};
    }
};

// The three parts times their coefficients are glTF's material. Measured: 4e-14 of the value.
TEST(Principled, PartsAddUpToTheReferenceOfGltf) {
    RandomDirections random;
    Largest worst;
    for (int k = 0; k < 5000; ++k) {
        Principled m{.color = random.color(), .metallic = random.next(0, 1), .roughness = random.next(0.1, 1)};
        m.ior = k % 10 == 0 ? 0 : random.next(1, 3);
        m.specular = random.next(0, 1);
        m.specular_color = random.color() * 4.0;
        const PrincipledSplit split = splitOf(m);
        const double roughness = m.roughness;
        const Vec3d i = random.above(), o = random.above(), exact = gltfReference(m, i, o);
        const double diffuse = brdfFunction(principledDiffuse(m))(i, o),
                     a = brdfFunction(principledF0(roughness))(i, o), b = brdfFunction(principledF90(roughness))(i, o);
        const Vec3d sum = sumBrdf(parseBrdfSum(toString(m))).eval(i, o);
        for (int c = 0; c < 3; ++c) {
            const double parts = split.diffuse[c] * diffuse + split.f0[c] * a + split.f90 * b;
            worst.add(std::abs(parts - exact[c]) / std::max(1.0, exact[c]));
            worst.add(std::abs(sum[c] - exact[c]) / std::max(1.0, exact[c]));
        }
    }
    EXPECT_LT(worst, 1e-6);
}

TEST(Principled, TextRoundTripsAndWrongOnesAreNamed) {
    for (const char* text : {"principled", "principled:color=0.8/0.2/0.1,metallic=1,roughness=0.3",
                             "principled:ior=0,specular=0.5,specular-color=2/1/1,emission=4/0/0"}) {
        const BrdfSum sum = parseBrdfSum(text);
        EXPECT_EQ(parseBrdfSum(sum.name).terms, sum.terms) << text;
        EXPECT_EQ(parseBrdfSum(sum.name).emission, sum.emission) << text;
    }
    EXPECT_EQ(parseBrdfSum("principled").name, "principled:color=1/1/1,metallic=0,roughness=0.5,ior=1.5,specular=1");
    for (const auto& [text, words] :
         {std::pair("principled:ior=0.5", "principled ior must be 0 or a number from 1 to 100, not '0.5'"),
          {"principled:color=2", "principled color must be"},
          {"principled:rough=1", "principled has no 'rough': use color, specular-color, emission, metallic, roughness"},
          {"principled:", "expected key=value"},
          {"principled+principled", "a sum has 4 lobes at most, not 6"},
          {"lambert+phong-live", "phong-live has no table"},
          {"mirror+lambert", "a mirror cannot be part of a sum"},
          {"lambert+membrane", "a membrane cannot be part of a sum"},
          {"lambert+", "no BRDF 'lambert+'"}}) {
        try {
            parseBrdfSum(text);
            ADD_FAILURE() << text;
        } catch (const std::invalid_argument& error) {
            EXPECT_THAT(error.what(), testing::HasSubstr(words));
        }
    }
}

TEST(BrdfSum, AddsUpItsTermsWithTheirColours) {
    const BrdfSum sum = parseBrdfSum("lambert:color=2e-1/0/1+ward:ax=0.2,color=0.5+ggx:f0=1e+0");
    ASSERT_EQ(sum.terms.size(), 3u);
    EXPECT_EQ(sum.name, "lambert:color=0.2/0/1+ward:ax=0.2,ay=0.5,color=0.5/0.5/0.5+ggx:alpha=0.3,f0=1");
    const RgbBrdf brdf = sumBrdf(sum);
    EXPECT_EQ(brdf.symmetry, BrdfSymmetry::kOrthotropic);
    RandomDirections random;
    for (int k = 0; k < 100; ++k) {
        const Vec3d i = random.above(), o = random.above();
        Vec3d f;
        for (const BrdfSpec& term : sum.terms) f += rgbBrdf(term).eval(i, o);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(brdf.eval(i, o)[c], f[c], 1e-12 * std::max(1.0, f[c]));
    }
    EXPECT_EQ(lobesOf(sum).size(), 3u);
}

}  // namespace
}  // namespace penumbra::test_principled
