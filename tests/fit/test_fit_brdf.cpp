#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "fit/reflectance/fit_brdf.h"
#include "formats/common/errors.h"
#include "sh/quadrature.h"
#include "sh/reflectance.h"
#include "sh/sh_product.h"
#include "tests/sh/golden.h"

namespace penumbra::test_fit_brdf {
namespace {

RgbBrdf specBrdf(const std::string& text) { return rgbBrdf(parseBrdf(text)); }

std::string specOfGolden(const std::string& name) {
    if (name == "phong10") return "phong:exponent=10";
    if (name == "ggx_.3") return "ggx:alpha=0.3,f0=0.9";
    if (name == "ward_gmd_.2_.5") return "ward-gmd:ax=0.2,ay=0.5";
    return name;
}

// Returns a dense [36, 25] matrix from [i, k, value], in the columns of the even indices.
std::vector<double> denseC(const nlohmann::json& entries) {
    const std::vector<int> even = evenIndices(5);
    std::vector<double> c(36 * even.size());
    for (const auto& entry : entries) {
        const auto column = std::find(even.begin(), even.end(), entry.at(1).get<int>()) - even.begin();
        c.at(entry.at(0).get<std::size_t>() * even.size() + std::size_t(column)) = entry.at(2);
    }
    return c;
}

double shade(std::span<const double> light, std::span<const double> visibility, int visibility_order, int slice_order,
             std::span<const double> c, Vec3d view) {
    std::vector<double> product(std::size_t(coefficientCount(slice_order)));
    multiply(slice_order, light, 4, visibility, visibility_order, product);
    const std::vector<int> even = evenIndices(5);
    std::vector<double> y(25);
    evalBasis(5, view, y);
    double sum = 0;
    for (std::size_t i = 0; i < product.size(); ++i)
        for (std::size_t e = 0; e < even.size(); ++e)
            sum += product[i] * c[i * even.size() + e] * y[std::size_t(even[e])];
    return sum;
}

TEST(FitBrdf, SlicesMatchGolden) {
    const auto golden = readGolden("rpo.json");
    for (const auto& test : golden.at("cases")) {
        const BrdfSpec spec = parseBrdf(specOfGolden(test.at("brdf")));
        const std::vector<double> rgb = fitSlices(tabulateSlices(rgbBrdf(spec), 6, 32, 32, 2), {6, 5});
        std::vector<double> c;
        for (std::size_t i = 0; i < rgb.size(); i += 3) c.push_back(rgb[i]);
        expectNear(c, denseC(test.at("C_ls_nonzero")), golden.at("tol"));
    }
}

TEST(FitBrdf, ShadingMatchesGolden) {
    const auto golden = readGolden("rpo.json"), visibility = readGolden("visibility_cases.json");
    const std::vector<double> light = doubles(golden.at("light"));
    const std::vector<double> d = doubles(visibility.at("cases").at(3).at("D")),
                              a = doubles(visibility.at("cases").at(3).at("A"));
    ASSERT_EQ(visibility.at("cases").at(3).at("name"), "wall_az70_e50");
    for (const auto& test : golden.at("cases")) {
        const std::vector<double> c_ls = denseC(test.at("C_ls_nonzero")), c_closed = denseC(test.at("C_nonzero"));
        for (std::size_t v = 0; v < 3; ++v) {
            const Vec3d view = vec3(golden.at("views")[v]);
            const auto expectShade = [&](const char* name, std::span<const double> vis, int vis_order, int slice_order,
                                         const std::vector<double>& c) {
                EXPECT_NEAR(
                    shade(light, vis.first(std::size_t(coefficientCount(vis_order))), vis_order, slice_order, c, view),
                    test.at(name)[v].get<double>(), 1e-9)
                    << test.at("brdf") << " " << name;
            };
            expectShade("directLS_D5_J5", d, 5, 5, c_ls);
            expectShade("directLS_D4_J5", d, 4, 5, c_ls);
            expectShade("direct_D5_J5", d, 5, 5, c_closed);
            expectShade("direct_D5_J6", d, 5, 6, c_closed);
            expectShade("direct_A4_J4", a, 4, 4, c_closed);
        }
    }
}

// F of a Lambertian is the clamped cosine / pi for every view, times its colour. The fit is exact.
TEST(FitBrdf, LambertIsTheClampedCosine) {
    const BrdfFile brdf = fitBrdf(specBrdf("lambert:color=0.5/1/0.25"), {}, 2);
    EXPECT_LT(brdf.errors.at("fit"), 1e-12);
    EXPECT_NEAR(brdf.errors.at("albedo_r"), 0.5, 1e-12);
    EXPECT_NEAR(brdf.errors.at("albedo_b"), 0.25, 1e-12);
    EXPECT_NEAR(brdf.errors.at("albedo_max"), 1, 1e-12);
    const std::size_t e = brdf.even_index.size();
    EXPECT_EQ(brdf.slices.size(), 25 * e * 3);
    // C_00 y_0 = F_0 = (cosine ZH z_0) / pi = 1 / (2 sqrt pi), so C_00 = 1.
    EXPECT_NEAR(brdf.slices[0], 0.5, 1e-12);
    EXPECT_NEAR(brdf.slices[1], 1, 1e-12);
}

TEST(FitBrdf, EveryModelSettles) {
    for (const std::string& name : brdfNames()) {
        const BrdfFile brdf = fitBrdf(specBrdf(name), {}, 2);
        EXPECT_LT(brdf.errors.at("refinement"), 1e-3) << name;
        EXPECT_LE(brdf.errors.at("albedo_r"), 1 + 1e-12) << name;
        // Ward's model of 1992 is known to reflect more than it gets at grazing views; the others do not.
        EXPECT_EQ(brdf.errors.at("albedo_max") > 1.001, name == "ward") << name << brdf.errors.at("albedo_max");
    }
}

// Lobes of 0.003 radians around the mirror direction settle. The closed form of the albedo at normal view is 1.
TEST(FitBrdf, NarrowLobesSettleBecauseGridsAreDenseAroundTheMirrorDirection) {
    const BrdfFile brdf = fitBrdf(specBrdf("phong:exponent=100000"), {}, 2);
    EXPECT_LT(brdf.errors.at("refinement"), 1e-3);
    EXPECT_NEAR(brdf.errors.at("albedo_max"), 1, 2e-3);  // the highest view is not quite the normal: 0.9993
}

// This BRDF reflects back to the light and not at all at the mirror direction. Its lobe is 0.1 radians wide. It
// settles, and its albedo is that of its mirror image.
TEST(FitBrdf, WideLobesSettleAnywhere) {
    const RgbBrdf retro{"retro", BrdfSymmetry::kIsotropic, [](Vec3d wi, Vec3d wo) {
                            const double f = 102 / (2 * std::numbers::pi) * std::pow(std::max(0.0, dot(wi, wo)), 100);
                            return Vec3d{f, f / 2, 0};
                        }};
    const BrdfFile brdf = fitBrdf(retro, {}, 2), phong = fitBrdf(specBrdf("phong:exponent=100,color=1/0.5/0"), {}, 2);
    for (const char* figure : {"albedo_r", "albedo_g", "albedo_b", "albedo_max", "fit"})
        EXPECT_NEAR(brdf.errors.at(figure), phong.errors.at(figure), 2e-3) << figure;
}

TEST(FitBrdf, ABlackMaterialIsZero) {
    const RgbBrdf black{"black", BrdfSymmetry::kGeneral, [](Vec3d, Vec3d) { return Vec3d{}; }};
    const BrdfFile brdf = fitBrdf(black, {}, 2);
    for (double value : brdf.slices) EXPECT_EQ(value, 0);
    EXPECT_EQ(brdf.errors.at("albedo_max"), 0);
}

// This lobe reflects back to the light and is 0.001 radians wide. No grid expects it there.
TEST(FitBrdf, LobeTooNarrowAwayFromTheMirrorDirectionIsRefused) {
    const RgbBrdf retro{"retro", BrdfSymmetry::kIsotropic, [](Vec3d wi, Vec3d wo) {
                            const double f = 1e5 * std::pow(std::max(0.0, dot(wi, wo)), 1e6);
                            return Vec3d{f, f, f};
                        }};
    EXPECT_THROW(fitBrdf(retro, {}, 2), InvalidInput);
}

TEST(FitBrdf, SameResultForAnyThreadCount) {
    for (const char* text : {"ggx", "ward"}) {
        const std::vector<double> one = fitBrdf(specBrdf(text), {}, 1).slices;
        for (int threads : {2, 8}) EXPECT_EQ(fitBrdf(specBrdf(text), {}, threads).slices, one) << text;
    }
}

}  // namespace
}  // namespace penumbra::test_fit_brdf
