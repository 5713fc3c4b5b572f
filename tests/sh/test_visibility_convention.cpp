#include <cmath>
#include <numbers>

#include "sh/quadrature.h"
#include "sh/visibility_convention.h"
#include "sh/zonal.h"
#include "tests/sh/golden.h"
#include "tests/sh/sh_project.h"

namespace penumbra::test_visibility_convention {

namespace {

std::vector<float> toSingle(const std::vector<double>& values) { return {values.begin(), values.end()}; }
std::vector<double> toDoubles(const std::vector<float>& values) { return {values.begin(), values.end()}; }

std::vector<double> coefficients(const std::string& convention, const std::vector<double>& moments) {
    const Convention c = parseConvention(convention);
    std::vector<float> coefficients(c.size()), out(coefficientCount(c.order));
    fromMoments(c, toSingle(moments), coefficients);
    fullCoefficients(c, coefficients, out);
    return toDoubles(out);
}

}  // namespace

TEST(VisibilityConvention, MatchesGolden) {
    const auto golden = readGolden("visibility_cases.json");
    std::vector<double> delta(36);
    belowHorizonCoefficients(6, delta);
    expectNear(delta, doubles(golden.at("Delta")), golden.at("tol"));
    for (const auto& test : golden.at("cases")) {
        const std::vector<double> b = doubles(test.at("b"));
        // All is single precision; 2.4e-7 relative to values up to 4 was measured.
        expectNear(coefficients("A6", b), doubles(test.at("A")), 1e-6);
        expectNear(coefficients("B6", b), b, 1e-6);
        expectNear(coefficients("D6", b), doubles(test.at("D")), 1e-6);
    }
}

// Compares the moments themselves with 262144 Fibonacci directions. The edges of walls and caps leave up to 1.2e-4.
TEST(VisibilityConvention, ClosedFormMomentsMatchProjection) {
    const auto golden = readGolden("visibility_cases.json");
    const std::vector<Vec3d> directions = fibonacciSphere(1 << 18);
    const auto expectMoments = [&](std::size_t index, auto blocked) {
        const auto& test = golden.at("cases").at(index);
        std::vector<std::uint8_t> visible;
        for (Vec3d d : directions) visible.push_back(d.z > 0 && !blocked(d));
        std::vector<double> b(36);
        projectVisibility(6, directions, visible, b);
        expectNear(b, doubles(test.at("b")), 5e-4);
    };
    const auto wall = [](double azimuth, double elevation) {
        const double a = azimuth * std::numbers::pi / 180, e = elevation * std::numbers::pi / 180;
        const Vec3d n{-std::sin(e) * std::cos(a), -std::sin(e) * std::sin(a), std::cos(e)};
        return [n](Vec3d d) { return dot(d, n) < 0; };
    };
    expectMoments(0, [](Vec3d) { return false; });
    expectMoments(1, wall(0, 30));
    expectMoments(2, wall(0, 90));
    expectMoments(3, wall(70, 50));
    const Vec3d axis = normalized(Vec3d{0.3, -0.2, 1});
    expectMoments(4, [axis](Vec3d d) { return dot(d, axis) > std::cos(std::numbers::pi / 6); });
}

TEST(VisibilityConvention, NamesRoundTripAndBadOnesAreRefused) {
    for (const char* name : {"A4", "B1", "D5", "A8"}) EXPECT_EQ(parseConvention(name).name(), name);
    EXPECT_EQ(parseConvention("D5").size(), 15);
    EXPECT_EQ(parseConvention("A4").size(), 16);
    EXPECT_EQ(parseConvention("D5"), Convention{});
    for (const char* name : {"", "A", "C4", "A0", "A9", "D55", "a4", "E4"})
        EXPECT_THROW(parseConvention(name), std::invalid_argument) << name;
}

namespace {

double ambient(const Convention& convention, const std::vector<double>& moments) {
    std::vector<float> coefficients(convention.size()), w(convention.size());
    fromMoments(convention, toSingle(moments), coefficients);
    ambientWeights(convention, w);
    double sum = 0;
    for (std::size_t i = 0; i < w.size(); ++i) sum += double(w[i]) * coefficients[i];
    return sum;
}

}  // namespace

TEST(VisibilityConvention, AmbientOfTheOpenHorizonIsOne) {
    std::vector<double> open(64), below(64);
    belowHorizonCoefficients(8, below);
    for (int i = 0; i < 64; ++i) open[i] = (i == 0 ? std::sqrt(4 * std::numbers::pi) : 0) - below[i];
    for (char letter : {'A', 'B', 'D'})
        for (int order = 1; order <= kMaxOrder; ++order)
            EXPECT_NEAR(ambient({BelowHorizon(letter), order}, open), 1, 1e-6) << letter << order;
}

// A vertical wall leaves half of the cosine-weighted sky. B is exact; A and D lose what they cut off.
TEST(VisibilityConvention, AmbientOfAVerticalWallIsHalf) {
    const std::vector<double> b = doubles(readGolden("visibility_cases.json").at("cases").at(2).at("b"));
    EXPECT_NEAR(ambient(parseConvention("B6"), b), 0.5, 1e-6);
    EXPECT_NEAR(ambient(parseConvention("A6"), b), 0.5, 0.01);
    EXPECT_NEAR(ambient(parseConvention("D6"), b), 0.5, 0.01);
}

// A cap around the normal is blocked, z > cos a. Every function is then zonal, so its numbers follow from the moments.
// The part outside the convention's bands is 2 pi times the integral over z of (V - projection)^2, which is summed here
// numerically between the jumps of V. Measured: 5e-6.
TEST(VisibilityConvention, BinaryEnergyLessTheNumbersIsTheTruncation) {
    const double top = std::cos(0.7), pi = std::numbers::pi;
    const auto sum = [](double from, double to, auto value) {
        const int steps = 2000;
        double total = 0;
        for (int i = 0; i < steps; ++i) total += value(from + (i + 0.5) * (to - from) / steps);
        return total * (to - from) / steps;
    };
    const auto basisAt = [](double z, int order) {
        std::vector<float> y(std::size_t(coefficientCount(order)));
        evalBasis(order, Vec3{float(std::sqrt(1 - z * z)), 0, float(z)}, y);
        return y;
    };
    for (const std::string name : {"A1", "A4", "A6", "B4", "B5", "D4", "D5"}) {
        const Convention convention = parseConvention(name);
        std::vector<float> moments(std::size_t(coefficientCount(convention.order)), 0.0f);
        for (int l = 0; l < convention.order; ++l)
            moments[std::size_t(shIndex(l, 0))] = float(sum(
                0, top, [&](double z) { return 2 * pi * basisAt(z, convention.order)[std::size_t(shIndex(l, 0))]; }));
        std::vector<float> coefficients(std::size_t(convention.size())), projected(moments.size());
        fromMoments(convention, moments, coefficients);
        fullCoefficients(convention, coefficients, projected);
        const auto squared = [&](double z) {
            const double height = convention.below == BelowHorizon::kMirrored ? std::abs(z) : z;
            double error = height < 0 ? convention.below == BelowHorizon::kOpen : height < top;
            const std::vector<float> y = basisAt(z, convention.order);
            for (int l = 0; l < convention.order; ++l)
                error -= double(projected[std::size_t(shIndex(l, 0))]) * y[std::size_t(shIndex(l, 0))];
            return 2 * pi * error * error;
        };
        double outside = binaryEnergy(convention, moments[0]);
        for (float number : coefficients) outside -= double(number) * number;
        const double expected =
            sum(-1, -top, squared) + sum(-top, 0, squared) + sum(0, top, squared) + sum(top, 1, squared);
        EXPECT_NEAR(outside, expected, 2e-5) << name;
        EXPECT_GT(outside, 0.01) << name;
    }
}

}  // namespace penumbra::test_visibility_convention
