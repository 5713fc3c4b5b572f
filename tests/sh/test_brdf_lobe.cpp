#include <cmath>
#include <limits>
#include <vector>

#include "sh/brdf/brdf_lobe.h"
#include "sh/quadrature.h"
#include "tests/sh/golden.h"

namespace penumbra::test_brdf_lobe {
namespace {

// Directions over the hemisphere, with the pole and some that graze.
std::vector<Vec3> manyDirections() {
    std::vector<Vec3> directions{{0, 0, 1}, {1, 0, 0}};
    for (Vec3d d : fibonacciSphere(60)) directions.push_back(toFloat(d));
    for (double z : {1e-6, 1e-3, 0.02})
        for (double phi : {0.3, 2.0, 3.5})
            directions.push_back(toFloat(normalized(Vec3d{std::cos(phi), std::sin(phi), z})));
    return directions;
}

TEST(BrdfLobe, IsTheModelItWasMadeOf) {
    for (const char* text : {"lambert:color=0.5/0.2/0.1", "oren-nayar:sigma=1.5", "phong:exponent=1e5",
                             "blinn-phong:exponent=1e5", "ward:ax=0.01,ay=10", "ward-gmd:ax=0.01,ay=0.02",
                             "ashikhmin-shirley:nu=1e5,nv=3", "ggx:alpha=0.01,f0=0.04", "cook-torrance:m=0.01,ior=100",
                             "principled-diffuse:f0=0.2,f90=0.7", "ggx-f0:roughness=0.3", "ggx-f90:roughness=0.3"}) {
        const BrdfSpec spec = parseBrdf(text);
        const BrdfLobe lobe = lobeOf(spec);
        EXPECT_TRUE(isValid(lobe)) << text;
        for (Vec3 wi : manyDirections())
            for (Vec3 wo : manyDirections()) {
                const Vec3d exact = spec.color * brdfFunction(spec)(normalized(toDouble(wi)), normalized(toDouble(wo)));
                const Vec3 ours = evalLobes({&lobe, 1}, wi, wo);
                // Only the parameters are rounded: by 6e-8, which the narrowest lobes raise to 1e-4 in their tails.
                for (int c = 0; c < 3; ++c) EXPECT_NEAR(ours[c], exact[c], 1e-4 * exact[c] + 1e-30) << text;
            }
    }
}

TEST(BrdfLobe, LobesAddUp) {
    const std::vector<BrdfLobe> lobes = {lobeOf(parseBrdf("lambert:color=0.5/0.2/0.1")), lobeOf(parseBrdf("ggx"))};
    const Vec3 wi = toFloat(normalized(Vec3d{0.2, 0.1, 1})), wo = toFloat(normalized(Vec3d{-0.3, 0, 1}));
    const Vec3 both = evalLobes(lobes, wi, wo);
    const Vec3 one = evalLobes(std::span(lobes).first(1), wi, wo), other = evalLobes(std::span(lobes).last(1), wi, wo);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(both[c], one[c] + other[c], 1e-6 * both[c]);
    EXPECT_EQ(evalLobes({}, wi, wo), Vec3{});
    EXPECT_EQ(evalLobes(lobes, {0, 0, -1}, wo), Vec3{});
}

TEST(BrdfLobe, MirrorReflectsOneDirectionOnly) {
    const BrdfLobe mirror = lobeOf(parseBrdf("mirror:f0=0.5,color=1/0.5/0"));
    const Vec3 wo = toFloat(normalized(Vec3d{0.3, 0, 1})), wi{-wo.x, -wo.y, wo.z};
    EXPECT_EQ(evalLobes({&mirror, 1}, wi, wo), Vec3{});
    EXPECT_EQ(mirrorReflectance({&mirror, 1}, {0, 0, 1}), (Vec3{0.5f, 0.25f, 0}));
    EXPECT_NEAR(mirrorReflectance({&mirror, 1}, {1, 0, 1e-6f}).x, 1, 1e-5);  // Schlick's term is 1 at grazing angles
    EXPECT_EQ(mirrorReflectance({&mirror, 1}, {0, 0, -1}), Vec3{});
    const BrdfLobe lambert;
    EXPECT_EQ(mirrorReflectance({&lambert, 1}, {0, 0, 1}), Vec3{});
}

TEST(BrdfLobe, RubbishIsNotValid) {
    const BrdfLobe good = lobeOf(parseBrdf("ggx"));
    for (float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1.0f, 2.0f}) {
        BrdfLobe lobe = good;
        lobe.parameters[0] = bad;
        EXPECT_FALSE(isValid(lobe)) << bad;
        lobe = good;
        lobe.parameters[3] = bad;
        EXPECT_FALSE(isValid(lobe)) << bad;
        lobe = good;
        lobe.color.y = bad;
        EXPECT_EQ(isValid(lobe), bad == 2.0f) << bad;
    }
    EXPECT_FALSE(isValid({BrdfModel(kBrdfModels)}));
}

}  // namespace
}  // namespace penumbra::test_brdf_lobe
