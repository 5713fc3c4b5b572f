// Reads measurements of a known BRDF from a file and fits slices. They must be the slices of the BRDF itself.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "fit/reflectance/fit_brdf.h"
#include "formats/brdf/brdf_readers.h"
#include "sh/key_values.h"
#include "tests/difference.h"
#include "tests/formats/brdf_samples.h"

namespace penumbra::test_measured_brdf {
namespace {

double differenceOfSlices(const RgbBrdf& measured, const RgbBrdf& exact) {
    const BrdfFile fitted = fitBrdf(measured, {}, 2);
    EXPECT_LT(fitted.errors.at("refinement"), kSettled);
    const double result = relativeDifference(fitted.slices, fitBrdf(exact, {}, 2).slices);
    std::printf("%s: slices differ by %.2g\n", exact.name.c_str(), result);
    return result;
}

RgbBrdf brdfOf(const char* spec) { return rgbBrdf(parseBrdf(spec)); }

// The measured errors 4e-8, 7e-4, 0.011 and 1.1e-3 are what linear interpolation between cells leaves. The third BRDF
// has Fresnel's rise at grazing angles within few cells of theta_d.
TEST(MeasuredBrdf, MerlSlicesAreThoseOfTheBrdf) {
    for (const auto& [spec, bound] : {std::pair("lambert:color=0.5/0.25/0.1", 1e-6),
                                      {"ggx:alpha=0.3,color=0.9/0.5/0.2", 4e-3},
                                      {"ggx:alpha=0.05,f0=0.04,color=1/0.5/0.25", 0.02},
                                      {"phong:exponent=50,color=0.2/0.5/1", 4e-3}}) {
        const RgbBrdf exact = brdfOf(spec);
        EXPECT_LT(differenceOfSlices(decodeMerl(samples::merlFile(exact), "x").brdf, exact), bound) << spec;
    }
}

// Anisotropic tables with either symmetry, and one without symmetry, for which every view is refined on its own.
TEST(MeasuredBrdf, TableSlicesAreThoseOfTheBrdf) {
    const RgbBrdf brushed = brdfOf("ward-gmd:ax=0.5,ay=0.8,color=1/0.5/0.25"), gloss = brdfOf("phong:exponent=6");
    const auto read = [](const std::string& text) { return decodeBrdfTable(text, "x").brdf; };
    EXPECT_LT(differenceOfSlices(read(samples::isotropicTable(gloss, 32, 33)), gloss), 0.01);
    EXPECT_LT(differenceOfSlices(read(samples::anisotropicTable(brushed, "orthotropic", 20, 7, 36)), brushed), 0.03);
    EXPECT_LT(differenceOfSlices(read(samples::anisotropicTable(brushed, "general", 20, 24, 36)), brushed), 0.03);
}

// Cornell's text of a glossy paint, measured at `count`^3 pairs of directions that miss the mirror direction.
std::string scatteredPaint(const RgbBrdf& paint, int count) {
    std::string text = "2\n450 650\n";
    for (int i = 0; i < count; ++i)
        for (int o = 0; o < count; ++o)
            for (int p = 0; p < count; ++p) {
                const double theta_i = std::numbers::pi / 2 * (i + 0.5) / count,
                             theta_o = std::numbers::pi / 2 * (o + 0.6) / count,
                             phi = std::numbers::pi * (p + 0.45) / count;
                const double f = paint.eval(samples::direction(theta_i, 0), samples::direction(theta_o, phi)).y;
                for (double number : {theta_i, 0.0, theta_o, phi, f, f}) text += shortest(number) + " ";
                text += "\n";
            }
    return text;
}

RgbBrdf overMatte(const char* lobe) {
    return {lobe, BrdfSymmetry::kIsotropic,
            [lobe = brdfOf(lobe), matte = brdfOf("lambert:color=0.3")](Vec3d wi, Vec3d wo) {
                return lobe.eval(wi, wo) + matte.eval(wi, wo);
            }};
}

// The samples are 8.3 and 2.8 degrees apart, and the half-widths of the lobes are 0.7 to 3.7 degrees. Measured: .011,
// .000, .011, .100 and .003, against .53 to .87 without the fit. Few samples see the fourth lobe, so its f0 is off.
TEST(MeasuredBrdf, LobesNarrowerThanTheSamplesAreThoseOfTheBrdf) {
    for (const auto& [spec, count, bound] : {std::tuple("ggx:alpha=0.02,f0=0.9", 9, 0.03),
                                             {"ggx:alpha=0.05,f0=0.04", 9, 0.01},
                                             {"ggx:alpha=0.1,f0=0.9", 9, 0.03},
                                             {"ggx:alpha=0.02,f0=0.04", 18, 0.15},
                                             {"ggx:alpha=0.05,f0=0.9", 18, 0.01}}) {
        const RgbBrdf exact = overMatte(spec);
        EXPECT_LT(differenceOfSlices(decodeScattered(scatteredPaint(exact, count), "x", 2).brdf, exact), bound) << spec;
    }
}

// A lobe turned about the normal has no mirror planes at x = 0 and y = 0. Only the general path can get it right, and
// turning it back gives the slices of the unturned lobe.
TEST(MeasuredBrdf, GeneralSymmetryKeepsALobeThatIsTurned) {
    const RgbBrdf straight = brdfOf("ward-gmd:ax=0.2,ay=0.5");
    const double c = std::cos(0.5), s = std::sin(0.5);
    const auto turned = [c, s](Vec3d v) { return Vec3d{c * v.x + s * v.y, -s * v.x + c * v.y, v.z}; };
    const RgbBrdf general{"turned", BrdfSymmetry::kGeneral,
                          [=](Vec3d wi, Vec3d wo) { return straight.eval(turned(wi), turned(wo)); }};
    RgbBrdf unturned = straight;
    unturned.symmetry = BrdfSymmetry::kGeneral;
    const std::vector<double> exact = fitBrdf(straight, {}, 2).slices;
    EXPECT_LT(relativeDifference(fitBrdf(unturned, {}, 2).slices, exact), 1e-3);  // measured 5e-5
    const std::vector<double> slices = fitBrdf(general, {}, 2).slices;
    EXPECT_GT(relativeDifference(slices, exact), 0.1);
    double norm = 0, exact_norm = 0;  // a rotation of both arguments is orthogonal
    for (std::size_t i = 0; i < slices.size(); ++i) {
        norm += slices[i] * slices[i];
        exact_norm += exact[i] * exact[i];
    }
    EXPECT_NEAR(norm / exact_norm, 1, 1e-3);
}

}  // namespace
}  // namespace penumbra::test_measured_brdf
