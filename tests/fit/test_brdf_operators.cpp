// Makes the operators M^b of Nowrouzezahrai 2009 in three ways, on the scenes of the accuracy table of docs/formulas.md
// section 3.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "fit/papers/operators/brdf_operators.h"
#include "fit/reflectance/fit_brdf.h"
#include "formats/common/errors.h"
#include "sh/brdf/reflection_operator.h"
#include "tests/fit/golden_scenes.h"

namespace penumbra::test_brdf_operators {
namespace {

const Convention kA4{BelowHorizon::kOpen, 4}, kD5{BelowHorizon::kMirrored, 5};

BrdfFile withOperators(BrdfFile file, const RgbBrdf& brdf, OperatorSource from) {
    file.operators = fitOperators(brdf, file, from, 8, 2);
    return file;
}
BrdfFile fitted(const RgbBrdf& brdf, OperatorSource from, int count) {
    BrdfFile file = fitBrdf(brdf, {}, 2);
    file.operators = fitOperators(brdf, file, from, count, 2);
    return file;
}

std::vector<double> slicesOfOperators(const BrdfOperators& o, const std::vector<Vec3d>& views) {
    const std::size_t rows = std::size_t(coefficientCount(o.order)), columns = o.view_index.size();
    std::vector<double> f(views.size() * rows * 3), y(std::size_t(coefficientCount(kMaxOrder)));
    for (std::size_t v = 0; v < views.size(); ++v) {
        evalBasis(kMaxOrder, views[v], y);
        for (std::size_t b = 0; b < std::size_t(o.count); ++b)
            for (std::size_t c = 0; c < 3; ++c) {
                double at_view = 0;
                for (std::size_t e = 0; e < columns; ++e)
                    at_view += o.w[(b * columns + e) * 3 + c] * y[std::size_t(o.view_index[e])];
                for (std::size_t i = 0; i < rows; ++i)
                    f[(v * rows + i) * 3 + c] += at_view * o.u[(b * rows + i) * 3 + c];
            }
    }
    return f;
}

// When there are as many terms as C has rank, the operators are C itself.
TEST(BrdfOperators, AllTermsOfTheSlicesAreTheSlices) {
    const ShadingScenes scenes = referenceScenes();
    for (const char* text : {"ward:ax=0.2,ay=0.5,color=1/0.5/0.25", "ggx", "lambert"}) {
        const BrdfFile file = fitted(rgbBrdf(parseBrdf(text)), OperatorSource::kSlices, 16);
        EXPECT_LE(file.operators.count, 15);
        EXPECT_EQ(file.operators.order, file.slice_order);
        expectNear(slicesOfOperators(file.operators, scenes.views),
                   slicesOfViews(scenes.views, file.slices, file.even_index), 1e-9);
    }
}

// Eq 11 with the M^b of sh/brdf/reflection_operator.h equals the product with the operators' own slices.
TEST(BrdfOperators, Equation11IsTheProduct) {
    const BrdfFile file = fitted(rgbBrdf(parseBrdf("ashikhmin-shirley")), OperatorSource::kTable, 8);
    const BrdfOperators& o = file.operators;
    const ShadingScenes scenes = referenceScenes();
    const ShadingTest test = makeShadingTest(scenes, 2);
    for (const Convention& convention : {kA4, kD5}) {
        // The radiance by eq 11 is the truth here. The other way must agree with it.
        std::vector<double> truth(3 * scenes.views.size() * scenes.lights.size() * scenes.occluders.size());
        const std::size_t columns = o.view_index.size(), rows = std::size_t(coefficientCount(o.order));
        std::vector<double> y(std::size_t(coefficientCount(kMaxOrder)));
        for (std::size_t b = 0; b < std::size_t(o.count); ++b) {
            std::vector<double> u(rows);
            for (std::size_t i = 0; i < rows; ++i) u[i] = o.u[(b * rows + i) * 3];
            const std::vector<double> m = reflectionOperator(4, convention, u);
            for (std::size_t v = 0; v < scenes.views.size(); ++v) {
                evalBasis(kMaxOrder, scenes.views[v], y);
                double at_view = 0;
                for (std::size_t e = 0; e < columns; ++e)
                    at_view += o.w[(b * columns + e) * 3] * y[std::size_t(o.view_index[e])];
                for (std::size_t s = 0; s < scenes.lights.size() * scenes.occluders.size(); ++s) {
                    const double* moments = test.moments.data() + s % 61 * coefficientCount(kMaxOrder);
                    const std::vector<float> b_i(moments, moments + coefficientCount(convention.order));
                    std::vector<float> coefficients(std::size_t(convention.size()));
                    fromMoments(convention, b_i, coefficients);
                    double transported = 0;
                    for (std::size_t i = 0; i < 16; ++i)
                        for (std::size_t j = 0; j < coefficients.size(); ++j)
                            transported += scenes.lights[s / 61][i] * m[i * coefficients.size() + j] * coefficients[j];
                    for (std::size_t c = 0; c < 3; ++c)
                        truth[(c * scenes.views.size() + v) * 366 + s] += at_view * transported;
                }
            }
        }
        EXPECT_LT(shadingError({test, truth}, convention, slicesOfOperators(o, scenes.views), o.order), 1e-6);
    }
}

// An isotropic BRDF that lost one of a pair would no longer be isotropic. F(Rz o) must stay Rz F(o) for every k.
TEST(BrdfOperators, NoPairIsCut) {
    const double angle = 0.7;
    const auto turned = [&](Vec3d d) {
        return Vec3d{std::cos(angle) * d.x - std::sin(angle) * d.y, std::sin(angle) * d.x + std::cos(angle) * d.y, d.z};
    };
    const std::vector<Vec3d> views = {{0.6, 0, 0.8}, turned({0.6, 0, 0.8})};
    for (const char* text : {"phong:exponent=10", "ggx"}) {
        const RgbBrdf brdf = rgbBrdf(parseBrdf(text));
        const BrdfFile file = fitBrdf(brdf, {}, 2);
        for (OperatorSource from : {OperatorSource::kSlices, OperatorSource::kTable}) {
            for (int k : {1, 2, 3, 5, 8, 11, 16}) {
                const BrdfOperators o = fitOperators(brdf, file, from, k, 2);
                EXPECT_LE(std::abs(o.count - k), 1) << text << k;
                EXPECT_LE(o.count, 16);
                const std::vector<double> f = slicesOfOperators(o, views);
                const std::size_t rows = std::size_t(coefficientCount(o.order));
                for (int l = 0; l < o.order; ++l)
                    for (int m = 1; m <= l; ++m) {
                        const auto at = [&](std::size_t v, int order_m) {
                            return f[(v * rows + std::size_t(shIndex(l, order_m))) * 3];
                        };
                        const double cosine = std::cos(m * angle), sine = std::sin(m * angle);
                        EXPECT_NEAR(at(1, m), cosine * at(0, m) - sine * at(0, -m), 1e-8);
                        EXPECT_NEAR(at(1, -m), sine * at(0, m) + cosine * at(0, -m), 1e-8)
                            << text << " " << nameOf(from) << " asked " << k << " got " << o.count;
                    }
            }
        }
    }
}

// Channels of different materials are fitted one by one. A black channel has no terms.
TEST(BrdfOperators, ChannelsOfTheirOwn) {
    const RgbBrdf ggx = rgbBrdf(parseBrdf("ggx")), lambert = rgbBrdf(parseBrdf("lambert"));
    const RgbBrdf mixed{"mixed", BrdfSymmetry::kIsotropic, [&](Vec3d wi, Vec3d wo) {
                            return Vec3d{lambert.eval(wi, wo).x, 2 * ggx.eval(wi, wo).x, 0};
                        }};
    const BrdfFile of_mixed = fitBrdf(mixed, {}, 2), of_ggx = fitBrdf(ggx, {}, 2), of_lambert = fitBrdf(lambert, {}, 2);
    for (OperatorSource from : {OperatorSource::kSlices, OperatorSource::kTable, OperatorSource::kLiteral}) {
        const BrdfFile file = withOperators(of_mixed, mixed, from), alone = withOperators(of_ggx, ggx, from),
                       flat = withOperators(of_lambert, lambert, from);
        const std::vector<Vec3d> views = {{0.6, 0, 0.8}, {0, -0.8, 0.6}};
        const auto f = slicesOfOperators(file.operators, views), g = slicesOfOperators(alone.operators, views),
                   h = slicesOfOperators(flat.operators, views);
        ASSERT_EQ(f.size(), g.size());
        for (std::size_t i = 0; i < f.size(); i += 3) {
            EXPECT_NEAR(f[i], h[i], 1e-9);
            EXPECT_NEAR(f[i + 1], 2 * g[i], 1e-9);
            EXPECT_EQ(f[i + 2], 0);
        }
    }
}

TEST(BrdfOperators, BlackIsNoProblem) {
    const RgbBrdf black = rgbBrdf(parseBrdf("lambert:color=0/0/0"));
    const BrdfFile without = fitBrdf(black, {}, 2);
    const ShadingTruth truth = shadingTruth(black, 2);
    for (OperatorSource from : {OperatorSource::kSlices, OperatorSource::kTable, OperatorSource::kLiteral}) {
        BrdfFile file = withOperators(without, black, from);
        EXPECT_EQ(file.operators.count, 1);
        EXPECT_THAT(file.operators.u, testing::Each(0.0));
        measureOperators(truth, file);
        EXPECT_EQ(file.errors.at("shading_operators"), 0);
    }
}

TEST(BrdfOperators, SameResultForAnyThreadCount) {
    for (const char* text : {"ggx", "ashikhmin-shirley"}) {
        const RgbBrdf brdf = rgbBrdf(parseBrdf(text));
        const BrdfFile file = fitBrdf(brdf, {}, 2);
        const BrdfOperators one = fitOperators(brdf, file, OperatorSource::kTable, 8, 1);
        for (int threads : {2, 8}) EXPECT_EQ(fitOperators(brdf, file, OperatorSource::kTable, 8, threads), one) << text;
    }
}

}  // namespace
}  // namespace penumbra::test_brdf_operators
