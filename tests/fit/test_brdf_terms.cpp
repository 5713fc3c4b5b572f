#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fit/numerics/truncated_svd.h"
#include "fit/papers/operators/brdf_terms.h"
#include "sh/brdf/reflection_operator.h"
#include "sh/quadrature.h"
#include "sh/sh_product.h"
#include "tests/sh/golden.h"

namespace penumbra::test_brdf_terms {
namespace {

// Returns k columns of a discrete cosine transform, which are orthonormal.
Matrix cosines(std::size_t n, std::size_t k) {
    Matrix m(k, n);
    for (std::size_t b = 0; b < k; ++b)
        for (std::size_t i = 0; i < n; ++i)
            m(b, i) = std::sqrt((b ? 2.0 : 1.0) / double(n)) *
                      std::cos(std::numbers::pi * double(b) * (double(i) + 0.5) / double(n));
    return m;
}

// The matrix is a sum of sigma u v^T with a pair of equal values and a tail. It is too large to be solved directly.
TEST(TruncatedSvd, FindsAKnownSpectrum) {
    const std::size_t rows = 300, columns = 260, rank = 250;
    const Matrix u = cosines(rows, rank), v = cosines(columns, rank);
    std::vector<double> sigma = {5, 4, 4, 2.5, 1.5, 1.49, 1};
    while (sigma.size() < rank) sigma.push_back(0.97 * sigma.back());
    Matrix a(rows, columns);
    for (std::size_t b = 0; b < rank; ++b)
        for (std::size_t i = 0; i < rows; ++i)
            for (std::size_t j = 0; j < columns; ++j) a(i, j) += sigma[b] * u(b, i) * v(b, j);
    const TruncatedSvd svd = truncatedSvd(a, 9);
    ASSERT_EQ(svd.sigma.size(), 9u);
    for (std::size_t b = 0; b < 9; ++b) EXPECT_NEAR(svd.sigma[b], sigma[b], 1e-12);
    for (std::size_t b : {0u, 3u, 4u, 5u, 8u}) {  // not the pair, because its vectors are not unique
        double along = 0;
        for (std::size_t i = 0; i < rows; ++i) along += svd.u(b, i) * u(b, i);
        EXPECT_NEAR(std::abs(along), 1, 1e-12);
        for (std::size_t j = 0; j < columns; ++j) EXPECT_NEAR(svd.v(b, j), v(b, j) * (along < 0 ? -1 : 1), 1e-9);
    }
}

TEST(TruncatedSvd, GivesNoMoreThanThereIs) {
    Matrix a(2, 3);
    a(0, 0) = 3, a(1, 2) = 4;
    const TruncatedSvd svd = truncatedSvd(a, 5);
    EXPECT_EQ(svd.sigma, (std::vector<double>{4, 3}));
    EXPECT_EQ(truncatedSvd(Matrix(300, 300), 3).sigma, (std::vector<double>{0, 0, 0}));
}

std::vector<double> singularValues(const RgbBrdf& brdf, ViewMeasure measure, std::size_t count) {
    std::vector<double> sigma = brdfTerms(brdf, gaussGrid(32, 64), measure, int(count), 2)[0].sigma;
    sigma.resize(count);
    return sigma;
}

RgbBrdf brdfOfGolden(const std::string& name) {
    if (name == "phong10") return rgbBrdf(parseBrdf("phong:exponent=10"));
    if (name == "ggx_.3") return rgbBrdf(parseBrdf("ggx:alpha=0.3,f0=0.9"));
    if (name == "ward_gmd_.2_.5") return rgbBrdf(parseBrdf("ward-gmd:ax=0.2,ay=0.5"));
    return rgbBrdf(parseBrdf(name));
}

TEST(BrdfTerms, SingularValuesMatchGolden) {
    const auto golden = readGolden("rpo.json");
    for (const auto& test : golden.at("cases")) {
        const RgbBrdf brdf = brdfOfGolden(test.at("brdf"));
        const std::vector<double> solid_angle = doubles(test.at("singular_values")),
                                  cosine = doubles(test.at("singular_values_cos"));
        expectNear(singularValues(brdf, ViewMeasure::kSolidAngle, solid_angle.size()), solid_angle, golden.at("tol"));
        expectNear(singularValues(brdf, ViewMeasure::kCosine, cosine.size()), cosine, golden.at("tol"));
    }
}

// Returns the coefficients i < order^2 of a function on the grid.
std::vector<double> coefficients(std::span<const double> values, const DirectionGrid& grid, int order) {
    std::vector<double> out(std::size_t(coefficientCount(order))), y(out.size());
    for (std::size_t q = 0; q < grid.size(); ++q) {
        evalBasis(order, grid.direction(q), y);
        for (std::size_t i = 0; i < y.size(); ++i) out[i] += grid.weight(q) * values[q] * y[i];
    }
    return out;
}

// Evaluates eq 11 with u and w of order 4 and the truncated M^b. w is extended evenly, or by zeros as printed.
double eq11(const BrdfTerms& terms, std::size_t rank, const DirectionGrid& grid, std::span<const double> light,
            std::span<const double> visibility, Vec3d view, bool even) {
    std::vector<double> y(16);
    evalBasis(4, view, y);
    double radiance = 0;
    for (std::size_t b = 0; b < rank; ++b) {
        const std::vector<double> m = productMatrix(4, coefficients(terms.u.row(b), grid, 4), 4);
        const std::vector<double> w = coefficients(terms.w.row(b), grid, 4);
        double at_view = 0, transported = 0;
        for (int l = 0, i = 0; l < 4; ++l)
            for (int order_m = -l; order_m <= l; ++order_m, ++i) {
                const double factor = !even ? 1 : (l + order_m) % 2 == 0 ? 2 : 0;
                at_view += factor * w[std::size_t(i)] * y[std::size_t(i)];
            }
        for (std::size_t i = 0; i < 16; ++i)
            for (std::size_t j = 0; j < 16; ++j) transported += light[i] * m[i * 16 + j] * visibility[j];
        radiance += at_view * transported;
    }
    return radiance;
}

TEST(BrdfTerms, OperatorsOfThePaperMatchGolden) {
    const auto golden = readGolden("rpo.json"), visibility = readGolden("visibility_cases.json");
    const std::vector<double> light = doubles(golden.at("light"));
    std::vector<double> a = doubles(visibility.at("cases").at(3).at("A"));
    a.resize(16);
    const DirectionGrid grid = gaussGrid(32, 64);
    for (const auto& test : golden.at("cases")) {
        const BrdfTerms terms = brdfTerms(brdfOfGolden(test.at("brdf")), grid, ViewMeasure::kCosine, 9, 2)[0];
        for (std::size_t v = 0; v < 3; ++v) {
            const Vec3d view = vec3(golden.at("views")[v]);
            const std::size_t rank = test.at("rpo_rank");
            EXPECT_NEAR(eq11(terms, rank, grid, light, a, view, true), test.at("rpo_even_A4")[v].get<double>(), 1e-9);
            EXPECT_NEAR(eq11(terms, rank, grid, light, a, view, false), test.at("rpo_zeroext_A4")[v].get<double>(),
                        1e-9);
        }
    }
}

// L is the integral of l V f cos on a 160 x 640 grid. The golden file asks for 3e-3.
TEST(BrdfTerms, BruteForceMatchesGolden) {
    const auto golden = readGolden("rpo.json"), visibility = readGolden("visibility_cases.json");
    const std::vector<double> light = doubles(golden.at("light"));
    const double azimuth = 70 * std::numbers::pi / 180, elevation = 50 * std::numbers::pi / 180;
    const Vec3d wall{-std::sin(elevation) * std::cos(azimuth), -std::sin(elevation) * std::sin(azimuth),
                     std::cos(elevation)};
    const auto grid = gaussHemisphere(160, 640);
    for (const auto& test : golden.at("cases")) {
        const RgbBrdf brdf = brdfOfGolden(test.at("brdf"));
        double sums[3] = {}, y[16];
        for (const auto& [direction, weight] : grid) {
            if (dot(direction, wall) < 0) continue;
            evalBasis(4, direction, y);
            double incoming = 0;
            for (std::size_t i = 0; i < 16; ++i) incoming += light[i] * y[i];
            for (std::size_t v = 0; v < 3; ++v)
                sums[v] += weight * incoming * direction.z * brdf.eval(direction, vec3(golden.at("views")[v])).x;
        }
        for (std::size_t v = 0; v < 3; ++v) {
            const double exact = test.at("exact")[v];
            EXPECT_NEAR(sums[v], exact, 3e-3 * std::abs(exact)) << test.at("brdf");
        }
    }
}

// Returns the sum over the first `rank` terms of U(i) W(o).
double sumOf(const BrdfTerms& terms, std::size_t rank, std::size_t i, std::size_t o) {
    double sum = 0;
    for (std::size_t b = 0; b < rank; ++b) sum += terms.u(b, i) * terms.w(b, o);
    return sum;
}

// Splitting the table by symmetry changes nothing but the time: values are equal, and so are sums that cut no pair.
TEST(BrdfTerms, SymmetryOnlySavesTime) {
    const DirectionGrid grid = gaussGrid(6, 16);
    for (const char* text : {"phong:exponent=10", "ggx:alpha=0.3", "ward:ax=0.3,ay=0.6", "ashikhmin-shirley"}) {
        RgbBrdf brdf = rgbBrdf(parseBrdf(text));
        const BrdfTerms split = brdfTerms(brdf, grid, ViewMeasure::kCosine, 12, 1)[0];
        brdf.symmetry = BrdfSymmetry::kGeneral;
        const BrdfTerms whole = brdfTerms(brdf, grid, ViewMeasure::kCosine, 12, 1)[0];
        expectNear(split.sigma, whole.sigma, 1e-12);
        std::size_t rank = 8;
        while (whole.sigma[rank] > 0.999 * whole.sigma[rank - 1]) --rank;
        for (std::size_t i = 0; i < grid.size(); i += 7)
            for (std::size_t o = 0; o < grid.size(); o += 5)
                EXPECT_NEAR(sumOf(split, rank, i, o), sumOf(whole, rank, i, o), 1e-10) << text;
    }
}

// For any k, the error of k terms in the measure of the SVD is what the left-out singular values say.
TEST(BrdfTerms, LeaveOutWhatTheSingularValuesSay) {
    const DirectionGrid grid = gaussGrid(6, 16);
    const RgbBrdf brdf = rgbBrdf(parseBrdf("ward:ax=0.3,ay=0.6"));
    const BrdfTerms terms = brdfTerms(brdf, grid, ViewMeasure::kCosine, 96, 2)[0];
    ASSERT_EQ(terms.sigma.size(), 96u);
    for (std::size_t rank : {1u, 5u, 96u}) {
        double error = 0, left = 0;
        for (std::size_t i = 0; i < grid.size(); ++i)
            for (std::size_t o = 0; o < grid.size(); ++o) {
                const Vec3d wi = grid.direction(i), wo = grid.direction(o);
                const double difference = brdf.eval(wi, wo).x * wi.z - sumOf(terms, rank, i, o);
                error += grid.weight(i) * grid.weight(o) * wo.z * difference * difference;
            }
        for (std::size_t b = rank; b < 96; ++b) left += terms.sigma[b] * terms.sigma[b];
        EXPECT_NEAR(error, left, 1e-12) << rank;
    }
}

TEST(BrdfTerms, ChannelsAreShared) {
    const DirectionGrid grid = gaussGrid(4, 8);
    const auto terms = brdfTerms(rgbBrdf(parseBrdf("ggx:color=0.5/1/0")), grid, ViewMeasure::kCosine, 3, 1);
    ASSERT_EQ(terms.size(), 3u);
    EXPECT_EQ(terms[0].w.values, terms[1].w.values);
    EXPECT_NEAR(terms[0].sigma[0], 0.5 * terms[1].sigma[0], 1e-15);
    EXPECT_EQ(terms[2].sigma[0], 0);
    EXPECT_EQ(channelFactors({1, 2, 4, 0.5, 1, 2}).factors, (std::vector<double>{0.25, 0.5, 1}));
    EXPECT_TRUE(channelFactors({1, 2, 4, 0.5, 1.1, 2}).factors.empty());
    EXPECT_EQ(channelFactors({0, 0, 0}).factors, (std::vector<double>{1, 0, 0}));
}

}  // namespace
}  // namespace penumbra::test_brdf_terms
