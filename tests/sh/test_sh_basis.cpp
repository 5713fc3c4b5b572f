#include <algorithm>
#include <numbers>

#include "sh/quadrature.h"
#include "sh/sh_basis.h"
#include "tests/sh/golden.h"
#include "tests/sh/sh_project.h"

namespace penumbra::test_sh_basis {

TEST(ShBasis, IndexAndBandAgree) {
    for (int band = 0; band < kMaxProductOrder; ++band)
        for (int m = -band; m <= band; ++m) EXPECT_EQ(bandOfIndex(shIndex(band, m)), band);
}

TEST(ShBasis, MatchesGolden) {
    const auto golden = readGolden("sh_basis.json");
    const double tolerance = golden.at("tol");
    for (std::size_t q = 0; q < golden.at("dir").size(); ++q) {
        const Vec3d d = vec3(golden["dir"][q]);
        std::vector<double> fast(64), reference(64);
        std::vector<float> single(64);
        evalBasis(8, d, fast);
        evalBasisReference(8, d, reference);
        evalBasis(8, toFloat(d), single);
        expectNear(fast, doubles(golden["y"][q]), tolerance);
        expectNear(reference, doubles(golden["y"][q]), tolerance);
        // The accuracy table asks single precision for 1e-5; 1.5e-6 was measured.
        expectNear(std::vector<double>(single.begin(), single.end()), doubles(golden["y"][q]), 1e-5);
    }
}

// Over 20000 directions 1.3e-14 was measured in double and 4.2e-6 in single precision, which includes rounding the
// direction.
TEST(ShBasis, FastPathsMatchTheReferenceForEveryOrder) {
    for (int order = 1; order <= kMaxOrder; ++order) {
        std::vector<double> fast(coefficientCount(order)), reference(fast.size());
        std::vector<float> single(fast.size());
        for (Vec3d d : fibonacciSphere(2000)) {
            evalBasis(order, d, fast);
            evalBasis(order, toFloat(d), single);
            evalBasisReference(order, d, reference);
            for (std::size_t i = 0; i < fast.size(); ++i) {
                ASSERT_NEAR(fast[i], reference[i], 1e-13) << "order " << order << " index " << i;
                ASSERT_NEAR(single[i], reference[i], 1e-5) << "order " << order << " index " << i;
            }
        }
    }
}

TEST(ShBasis, ReferenceIsOrthonormalToTheProductOrder) {
    const int n = coefficientCount(kMaxProductOrder);
    std::vector<double> gram(n * n), y(n);
    for (const auto& [direction, weight] : gaussSphere(16, 32)) {
        evalBasisReference(kMaxProductOrder, direction, y);
        for (int i = 0; i < n; ++i)
            for (int j = i; j < n; ++j) gram[i * n + j] += weight * y[i] * y[j];
    }
    for (int i = 0; i < n; ++i)
        for (int j = i; j < n; ++j) ASSERT_NEAR(gram[i * n + j], i == j, 1e-13) << i << " " << j;
}

TEST(ShBasis, BandOneHasTheCondonShortleySign) {
    std::array<float, 4> y;
    evalBasis(2, Vec3{0.6f, 0.0f, 0.8f}, y);
    const float c = std::sqrt(0.75f / std::numbers::pi_v<float>);
    EXPECT_FLOAT_EQ(y[shIndex(1, 0)], c * 0.8f);
    EXPECT_FLOAT_EQ(y[shIndex(1, 1)], -c * 0.6f);
    EXPECT_EQ(y[shIndex(1, -1)], 0);
}

TEST(ShProject, BandLimitedFunctionComesBack) {
    std::vector<double> f(coefficientCount(kMaxProductOrder)), back(f.size()), y(f.size());
    for (std::size_t i = 0; i < f.size(); ++i) f[i] = std::sin(1.0 + double(i * i));
    const auto value = [&](Vec3d d) {
        evalBasisReference(kMaxProductOrder, d, y);
        double sum = 0;
        for (std::size_t i = 0; i < f.size(); ++i) sum += f[i] * y[i];
        return sum;
    };
    project(kMaxProductOrder, gaussSphere(16, 32), value, back);
    expectNear(back, f, 1e-12);
}

// A blocked cap of half-angle a around +z has v(0,0) = sqrt(pi) (1 + cos a) and v(1,0) = -sqrt(3 pi)/2 sin^2 a, and
// every term with m != 0 is zero. 65536 directions come within 6.5e-5 of that; the bound is 3 times as wide.
TEST(ShProject, CapBlockerMatchesClosedForm) {
    const double a = 0.6, pi = std::numbers::pi;
    const std::vector<Vec3d> directions = fibonacciSphere(1 << 16);
    std::vector<std::uint8_t> visible;
    for (Vec3d d : directions) visible.push_back(d.z < std::cos(a));
    std::array<double, coefficientCount(4)> v;
    projectVisibility(4, directions, visible, v);
    EXPECT_NEAR(v[shIndex(0, 0)], std::sqrt(pi) * (1 + std::cos(a)), 2e-4);
    EXPECT_NEAR(v[shIndex(1, 0)], -std::sqrt(3 * pi) / 2 * std::pow(std::sin(a), 2), 2e-4);
    for (auto [band, m] : {std::pair(1, 1), {2, 1}, {2, 2}, {3, 1}, {3, 2}, {3, 3}})
        EXPECT_NEAR(std::hypot(v[shIndex(band, m)], v[shIndex(band, -m)]), 0, 2e-4) << "band " << band << " m " << m;
}

TEST(Quadrature, WeightsSumToTheSolidAngle) {
    for (int n : {1, 2, 7, 64}) {
        double sphere = 0, hemisphere = 0;
        for (const auto& sample : gaussSphere(n, 4)) sphere += sample.weight;
        for (const auto& sample : gaussHemisphere(n, 4)) {
            hemisphere += sample.weight;
            EXPECT_GT(sample.direction.z, 0);
        }
        EXPECT_NEAR(sphere, 4 * std::numbers::pi, 1e-12);
        EXPECT_NEAR(hemisphere, 2 * std::numbers::pi, 1e-12);
    }
}

TEST(Quadrature, MortonOrderIsAPermutationOfNeighbours) {
    const std::vector<Vec3d> plain = fibonacciSphere(2048), sorted = mortonSorted(plain);
    const auto less = [](Vec3d a, Vec3d b) { return a.z < b.z; };
    std::vector<Vec3d> a = plain, b = sorted;
    std::sort(a.begin(), a.end(), less);
    std::sort(b.begin(), b.end(), less);
    EXPECT_EQ(a, b);
    const auto meanStep = [](const std::vector<Vec3d>& d) {
        double sum = 0;
        for (std::size_t i = 1; i < d.size(); ++i) sum += std::acos(std::clamp(dot(d[i], d[i - 1]), -1.0, 1.0));
        return sum / double(d.size() - 1);
    };
    // Neighbours in a Fibonacci set of 2048 are 0.078 apart. Along the curve the mean step measures 0.115.
    EXPECT_LT(meanStep(sorted), 0.15);
    EXPECT_GT(meanStep(plain), 0.5);
}

}  // namespace penumbra::test_sh_basis
