#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "bake/reference/direct_light.h"
#include "bake/reference/sampling_lobe.h"
#include "formats/brdf/brdf_readers.h"
#include "sh/quadrature.h"
#include "tests/bake/shapes.h"
#include "tests/formats/brdf_samples.h"

namespace penumbra::test_sampling_lobe {
namespace {

RgbBrdf brdfOf(const char* spec) { return rgbBrdf(parseBrdf(spec)); }

Vec3d viewAt(double z, double azimuth) {
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

// Analytic, fitted and measured materials, narrow and wide, with and without a preferred direction.
std::vector<RgbBrdf> materials() {
    std::vector<RgbBrdf> all;
    for (const std::string& name : brdfNames()) all.push_back(brdfOf(name.c_str()));
    for (const char* spec : {"ggx:alpha=0.05", "phong:exponent=1000", "ward-gmd:ax=0.05,ay=0.5",
                             "ashikhmin-shirley:nu=1000,nv=10,rs=0.9,rd=0.1"})
        all.push_back(brdfOf(spec));
    const std::string fits =
        "material,kD_r,kD_g,kD_b,A_r,A_g,A_b,B,C,ior\nchrome,0.003,0.003,0.003,987,771,696,64661,1.9,100\n";
    all.push_back(decodeFits(fits, "fits", "chrome").brdf);
    all.back().name = "fit:chrome";
    all.push_back(decodeBrdfTable(samples::anisotropicTable(brdfOf("ward-gmd:ax=0.3,ay=0.8"), "general", 12, 16, 24),
                                  "general table")
                      .brdf);
    all.push_back(
        decodeScattered(samples::scatteredFile(brdfOf("ggx:alpha=0.2,color=1/0.5/0.2"), 12, 9), "scattered", 1).brdf);
    return all;
}

// Samples of a lobe are as dense as lobeDensity() says: their mean of g / density is the integral of g. This looks
// above the horizon only: half vectors that face away from the view mirror it to below, where nothing is ever
// evaluated.
TEST(SamplingLobe, SamplesAgreeWithTheDensity) {
    for (const SamplingLobe& lobe : {SamplingLobe{SamplingLobe::Kind::kPower, 20, 0, 0.5},
                                     SamplingLobe{SamplingLobe::Kind::kHalfVector, 0.5, 0.5, 0.5},
                                     SamplingLobe{SamplingLobe::Kind::kHalfVector, 0.2, 0.8, 0.5}})
        for (const Vec3d wo : {viewAt(0.9, 0.3), viewAt(0.4, 2)}) {
            const auto g = [&](Vec3d w) { return lobeDensity(lobe, wo, w) * (1 + w.x - 0.5 * w.y + w.z * w.z); };
            double exact = 0, estimate = 0;
            for (const auto& [d, weight] : gaussHemisphere(256, 512)) exact += weight * g(d);
            constexpr int kSamples = 1 << 14;
            for (int i = 0; i < kSamples; ++i) {
                const Vec3d wi = sampleLobe(lobe, wo, stratified(i, kSamples, 3));
                EXPECT_NEAR(length(wi), 1, 1e-12);
                if (wi.z > 0) estimate += g(wi) / lobeDensity(lobe, wo, wi) / kSamples;
            }
            EXPECT_NEAR(estimate / exact, 1, 5e-3);
        }
}

TEST(SamplingLobe, FindsTheLobeOfTheModel) {
    EXPECT_EQ(fitLobe(brdfOf("lambert")).kind, SamplingLobe::Kind::kNone);
    const SamplingLobe ggx = fitLobe(brdfOf("ggx:alpha=0.1"));
    EXPECT_EQ(ggx.kind, SamplingLobe::Kind::kHalfVector);
    EXPECT_GT(ggx.x, 0.07);
    EXPECT_LT(ggx.x, 0.15);
    const SamplingLobe phong = fitLobe(brdfOf("phong:exponent=100"));
    EXPECT_EQ(phong.kind, SamplingLobe::Kind::kPower);
    EXPECT_NEAR(std::log2(phong.x), std::log2(100.0), 1.01);
    const SamplingLobe brushed = fitLobe(brdfOf("ward-gmd:ax=0.05,ay=0.5"));
    EXPECT_GT(brushed.y, 4 * brushed.x);
}

struct Noise {
    double cosine = 0, fitted = 0;  // standard deviation of one sample over the value
};

// A white furnace has half of its sky behind a wall, so that the value is the albedo of half of the hemisphere. The
// variance over directions comes from a quadrature with the estimator's own samples.
Noise noiseOf(const RgbBrdf& brdf, const SamplingLobe& lobe, Vec3d wo) {
    constexpr int kSamples = 1 << 14;
    const auto value = [&](Vec3d wi) {
        const Vec3d f = brdf.eval(wi, wo);
        return wi.z > 0 && wi.x > 0 ? (f.x + f.y + f.z) * wi.z : 0;
    };
    const auto spread = [&](double share) {
        double sum = 0, squares = 0;
        for (int i = 0; i < kSamples; ++i) {
            const bool of_lobe = i < share * kSamples;
            const UnitSquare s = stratified(i % (kSamples / 2), kSamples / 2, of_lobe ? 5 : 6);
            const Vec3d wi = of_lobe ? sampleLobe(lobe, wo, s) : sampleCosine(s);
            if (wi.z <= 0) continue;
            const double density =
                share * (share > 0 ? lobeDensity(lobe, wo, wi) : 0) + (1 - share) * cosineDensity(wi);
            sum += value(wi) / density;
            squares += std::pow(value(wi) / density, 2);
        }
        const double mean = sum / kSamples;
        return std::sqrt(std::max(0.0, squares / kSamples - mean * mean)) / mean;
    };
    return {spread(0), spread(lobe.kind == SamplingLobe::Kind::kNone ? 0 : 0.5)};
}

// Compares the noise of the estimator with the fitted lobe to that with cosine-weighted directions alone, for as many
// samples.
TEST(SamplingLobe, NoiseIsNeverMuchAboveThatOfTheCosineAndFarBelowForNarrowLobes) {
    for (const RgbBrdf& brdf : materials()) {
        const SamplingLobe lobe = fitLobe(brdf);
        const Noise noise = noiseOf(brdf, lobe, viewAt(0.6, std::numbers::pi + 0.4));
        std::printf("%-50s lobe %d %8.3g %8.3g, %2.0f%%; noise of a sample %.2f, cosine only %.2f\n", brdf.name.c_str(),
                    int(lobe.kind), lobe.x, lobe.y, 100 * lobe.share, noise.fitted, noise.cosine);
        const bool narrow = lobe.kind == SamplingLobe::Kind::kHalfVector && std::max(lobe.x, lobe.y) < 0.1;
        EXPECT_LT(noise.fitted, (narrow ? 0.3 : 1.3) * noise.cosine) << brdf.name;
    }
}

// Integrates over the half of the hemisphere that the wall leaves. Nodes follow the mirror direction in height and
// azimuth by sinh, so that narrow lobes are seen.
Vec3d lightBesideWall(const RgbBrdf& brdf, const SurfacePoint& point) {
    constexpr double kScale = 0.003;
    const Vec3d wo = viewDirection(point);
    const double t_o = std::sqrt(wo.z), mirror = std::atan2(-wo.y, -wo.x), b = std::asinh(std::numbers::pi / kScale);
    const std::vector<WeightedNumber> nodes = gaussInterval(400);
    Vec3d sum;
    for (double side : {-1.0, 1.0})
        for (const auto& [u, u_weight] : nodes) {
            const double bt = std::asinh((side < 0 ? t_o : 1 - t_o) / kScale),
                         t = t_o + side * kScale * std::sinh(bt * u);
            const double height = 2 * t * kScale * bt * std::cosh(bt * u) * u_weight;
            for (double sign : {-1.0, 1.0})
                for (const auto& [v, v_weight] : nodes) {
                    const Vec3d wi = viewAt(t * t, mirror + sign * kScale * std::sinh(b * v));
                    const double area = height * kScale * b * std::cosh(b * v) * v_weight;
                    if ((transposed(point.frame) * wi).x > 0) sum += brdf.eval(wi, wo) * (wi.z * area);
                }
        }
    return sum;
}

// Compares the estimator with quadrature, with half of the sky behind a wall. The mean over seeds must be the
// integral.
TEST(DirectLight, IsUnbiasedForEveryKindOfMaterial) {
    const shapes::Shape wall = shapes::square({-0.5, 0, 0}, {1, 0, 0}, 1000);
    const OcclusionScene scene(wall.positions, wall.triangles);
    const SurfacePoint point{{0, 0, 0}, shadingFrame({0, 1, 0}), normalized(Vec3d{-0.5, 0.6, 0.2})};
    for (const RgbBrdf& brdf : materials()) {
        const Vec3d exact = lightBesideWall(brdf, point);
        const SampledBrdf sampled = sampledBrdf(brdf);
        Vec3d mean;
        for (std::uint64_t seed = 0; seed < 64; ++seed)
            mean += directLight({scene, false}, point, EnvironmentLight::white(), sampled, 512, seed) / 64;
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(mean[c] / exact[c], 1, 0.01) << brdf.name << " channel " << c;
            if (c == 0) std::printf("%-50s %+.2e\n", brdf.name.c_str(), mean[c] / exact[c] - 1);
        }
    }
}

}  // namespace
}  // namespace penumbra::test_sampling_lobe
