#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "sh/cast/log_visibility.h"
#include "sh/sh_product.h"
#include "sh/zonal.h"
#include "tests/difference.h"
#include "tests/sh/caster_scenes.h"

namespace penumbra::test_log_visibility {
namespace {

const double kOne = std::sqrt(4 * std::numbers::pi);
const ExpOptions kPlain = {ExpMethod::kHybPs2, false}, kSmooth = {};

std::vector<double> expOf(int order, const ExpOptions& options, const std::vector<double>& log) {
    std::vector<double> out(log.size());
    expOfLog(expTablesD(order), options, log, out);
    return out;
}

std::vector<double> expInFloats(int order, const ExpOptions& options, const std::vector<double>& log) {
    const std::vector<float> in(log.begin(), log.end());
    std::vector<float> out(log.size());
    expOfLog(expTables(order), options, in, out);
    return std::vector<double>(out.begin(), out.end());
}

double normOf(const std::vector<double>& log) {
    double sum = 0;
    for (std::size_t i = 1; i < log.size(); ++i) sum += log[i] * log[i];
    return std::sqrt(sum);
}

// RMS over the sphere of the difference of two visibilities.
double rmsV(const std::vector<double>& a, const std::vector<double>& b) { return distanceBetween(a, b) / kOne; }

// Cosine-weighted visibility / pi about `normal`.
double ambientOf(const std::vector<double>& v, Vec3d normal) {
    const int order = int(std::lround(std::sqrt(double(v.size()))));
    std::vector<double> z(std::size_t(order), 0.0), cosine(v.size());
    clampedCosineZonal(z);
    rotateZonal(z, normal, cosine);
    double sum = 0;
    for (std::size_t i = 0; i < v.size(); ++i) sum += cosine[i] * v[i];
    return sum / std::numbers::pi;
}

TEST(RepeatedProduct, IsTheProduct) {
    for (int order = 1; order <= kMaxRepeatedOrder; ++order) {
        const std::size_t n = std::size_t(coefficientCount(order));
        std::vector<double> a(n), b(n), expected(n), out(n);
        for (std::size_t i = 0; i < n; ++i) {
            a[i] = std::sin(double(i + 1));
            b[i] = std::cos(3 * double(i));
        }
        multiply(order, a, order, b, order, expected);
        multiply(repeatedProduct<double>(order), a.data(), b.data(), out.data());
        expectNear(out, expected, 1e-13);
        multiply(order, a, order, a, order, expected);
        square(repeatedProduct<double>(order), a.data(), a.data());  // in place
        expectNear(a, expected, 1e-13);
    }
}

TEST(ExpOfLog, MatchesGoldenOfOrders3And5) {
    const auto golden = readGolden("shexp_orders.json");
    ASSERT_EQ(golden.at("scenes").size(), 12u);
    for (const auto& scene : golden.at("scenes"))
        for (int order : {3, 5}) {
            SCOPED_TRACE(scene.at("kind").get<std::string>() + ", order " + std::to_string(order));
            const auto& expected = scene.at("order" + std::to_string(order));
            const std::vector<double> log = netLogOf(order, goldenCaps(scene.at("axis"), scene.at("theta")));
            EXPECT_NEAR(normOf(log), expected.at("norm").get<double>(), 1e-9);
            EXPECT_EQ(squaringCount(kPlain, normOf(log)), expected.at("p").get<int>());
            expectNear(expOf(order, kPlain, log), doubles(expected.at("hyb_ps2")), golden.at("tol"));
            expectNear(expInFloats(order, kPlain, log), doubles(expected.at("hyb_ps2")), golden.at("tol_float"));
        }
}

// The power series with very many terms is the exponential of the product matrix. The linear form's curves were made
// from an interpolated table for the golden file and are made from exact logarithms here: 2.9e-5 apart at the most.
TEST(ExpOfLog, MatchesGoldenOfOrders4And6) {
    const auto golden = readGolden("shexp.json");
    ASSERT_EQ(golden.at("scenes").size(), 5u);
    for (const auto& scene : golden.at("scenes"))
        for (int order : {4, 6}) {
            SCOPED_TRACE(scene.at("kind").get<std::string>() + ", order " + std::to_string(order));
            const auto& expected = scene.at("order" + std::to_string(order));
            const std::vector<double> log = doubles(expected.at("log"));
            EXPECT_EQ(squaringCount(kPlain, normOf(log)), expected.at("p").get<int>());
            expectNear(expOf(order, kPlain, log), doubles(expected.at("hyb_ps2")), 1e-12);
            expectNear(expInFloats(order, kPlain, log), doubles(expected.at("hyb_ps2")), 2e-5);
            expectNear(expOf(order, {ExpMethod::kPs, false, 100}, log), doubles(expected.at("exact_exp")), 1e-9);
            expectNear(expOf(order, {ExpMethod::kOl}, log), doubles(expected.at("ol_single")), 6e-5);
            std::vector<double> chain(log.size());
            productChain(order, goldenCaps(scene.at("axis"), scene.at("theta")), chain);
            expectNear(chain, doubles(expected.at("product_chain_largest_first")), 1e-12);
            const std::vector<double> truth = doubles(scene.at("ground_truth_order6"));
            const std::vector<double> bands(truth.begin(), truth.begin() + coefficientCount(order));
            EXPECT_LT(rmsV(expOf(order, kSmooth, log), bands), 0.08);
        }
}

// The spheres of a person, seen from five points of the ground. The golden file's table goes by the angle instead of
// sin(angle / 2), which makes up to 4.7e-5. Ten spheres block .023 too much from between the feet, the others less.
TEST(ExpOfLog, MatchesGoldenOfAPerson) {
    const auto golden = readGolden("sphere_set.json");
    for (const auto& receiver : golden.at("receivers"))
        for (const char* count : {"10", "15", "20"}) {
            const auto& set = golden.at("proxies").at(count);
            const std::vector<double> log =
                netLogAt(4, goldenSpheres(set.at("C"), set.at("R")), vec3(receiver.at("x")));
            const std::vector<double> v = expOf(4, kPlain, log);
            expectNear(v, doubles(receiver.at(std::string("hyb4_k") + count)), 1e-4);
            const double blocked = 1 - v[0] / kOne;
            EXPECT_NEAR(blocked, receiver.at("solid_blocked_fraction").get<double>(), 0.03);
        }
}

TEST(ExpOfLog, LinearCurvesMatchGolden) {
    const auto golden = readGolden("shexp.json").at("ol");
    for (int order = kMinLogOrder; order <= kMaxLogOrder; ++order) {
        const auto& expected = golden.at(std::to_string(order));
        const std::vector<double> norms = doubles(expected.at("grid_single")), a = doubles(expected.at("a_single")),
                                  b = doubles(expected.at("b_single"));
        for (std::size_t k = 0; k < norms.size(); ++k) {
            // The form is a(m) + b(m) f^, so a function with |f^| = m shows both.
            std::vector<double> log(std::size_t(coefficientCount(order)));
            log[2] = norms[k];
            const std::vector<double> v = expOf(order, {ExpMethod::kOl}, log);
            EXPECT_NEAR(v[0] / kOne, a[k], 1e-4) << order << ", " << norms[k];
            if (norms[k] > 0) {
                EXPECT_NEAR(v[2] / norms[k], b[k], 6e-4) << order << ", " << norms[k];
            }
        }
    }
}

TEST(ExpOfLog, OfNothingIsOne) {
    for (ExpMethod method : {ExpMethod::kHybPs2, ExpMethod::kHybOl, ExpMethod::kPs, ExpMethod::kOl})
        for (int order = kMinLogOrder; order <= kMaxLogOrder; ++order) {
            std::vector<double> one(std::size_t(coefficientCount(order)));
            const std::vector<double> out = expOf(order, {method}, one);
            one[0] = kOne;
            expectNear(out, one, 1e-15);
        }
}

// Methods against the exact exponential (a series of 100 terms), around a person, 0.2 to 2 m away. Measured: .004 to
// .016 (plain), .001 to .014 (smooth) and .004 to .026 (HYB-OL), growing with the order.
TEST(ExpOfLog, MethodsComeNearTheExactOne) {
    const std::vector<CasterSphereD> person = goldenPerson();
    for (int order = kMinLogOrder; order <= kMaxLogOrder; ++order) {
        Largest plain, smooth, linear;
        for (int k = 0; k < 40; ++k) {
            const double angle = 0.7 * k, distance = 0.2 + 0.045 * k;
            const Vec3d at{distance * std::cos(angle), distance * std::sin(angle), 0.04 * k};
            const std::vector<double> log = netLogAt(order, person, at);
            const std::vector<double> exact = expOf(order, {ExpMethod::kPs, false, 100}, log);
            plain.add(rmsV(expOf(order, kPlain, log), exact));
            smooth.add(rmsV(expOf(order, kSmooth, log), exact));
            linear.add(rmsV(expOf(order, {ExpMethod::kHybOl}, log), exact));
        }
        EXPECT_LT(plain, 0.025);
        EXPECT_LT(smooth, 0.02);
        EXPECT_LT(linear, 0.04);
    }
}

// Measured: 3.3e-6 to 1.1e-5.
TEST(ExpOfLog, FloatsComeNearDoubles) {
    const std::vector<CasterSphereD> person = goldenPerson();
    for (int order = kMinLogOrder; order <= kMaxLogOrder; ++order) {
        Largest worst;
        for (int k = 0; k < 200; ++k) {
            const double angle = 0.7 * k, distance = 0.01 * k;
            const Vec3d at{distance * std::cos(angle), distance * std::sin(angle), 0.009 * k};
            const std::vector<float> log = netLogAt(order, inFloats(person), toFloat(at));
            std::vector<float> out(log.size());
            expOfLog(expTables(order), kSmooth, log, out);
            const std::vector<double> exact = expOf(order, kSmooth, netLogAt(order, person, toDouble(toFloat(at))));
            for (std::size_t i = 0; i < out.size(); ++i) worst.add(std::abs(out[i] - exact[i]));
        }
        EXPECT_LT(worst, 5e-5);
    }
}

// A logarithm grows until the number of squarings changes. Measured there: V changes by .0001 to .0007 (RMS over the
// sphere), E by .0004 at the most. By the plain rule V changes by .007 to .030.
TEST(ExpOfLog, DoesNotStepWhereTheSquaringsChange) {
    const auto golden = readGolden("shexp.json");
    for (int order = kMinLogOrder; order <= kMaxLogOrder; ++order) {
        Largest plain, smooth, ambient;
        for (const auto& scene : golden.at("scenes")) {
            const std::vector<double> log = netLogOf(order, goldenCaps(scene.at("axis"), scene.at("theta")));
            for (const double edge : {0.5, 1.0, 2.0, 4.0, 8.0}) {
                if (edge > 4 * normOf(log)) continue;
                std::vector<double> below = log, above = log;
                for (double& f : below) f *= edge / normOf(log) * (1 - 1e-9);
                for (double& f : above) f *= edge / normOf(log) * (1 + 1e-9);
                ASSERT_EQ(squaringCount(kSmooth, normOf(above)), squaringCount(kSmooth, normOf(below)) + 1);
                const std::vector<double> v = expOf(order, kSmooth, below), w = expOf(order, kSmooth, above);
                smooth.add(rmsV(v, w));
                ambient.add(std::abs(ambientOf(v, {0, 0, 1}) - ambientOf(w, {0, 0, 1})));
                plain.add(rmsV(expOf(order, kPlain, below), expOf(order, kPlain, above)));
            }
        }
        EXPECT_LT(smooth, 0.002);
        EXPECT_LT(ambient, 0.001);
        EXPECT_GT(plain, 0.005);  // this is why the smooth rule is the default
    }
}

// Returns the largest change of the change of E between steps, as a sphere comes near until it touches the receiver.
// The half-angle of its cap grows evenly from 1 to 90 degrees.
double largestKink(int order, const ExpOptions& options) {
    const Vec3d direction = normalized(Vec3d{0.3, 0.1, 1});
    const int steps = 4000;
    Largest worst;
    double before = 0, change_before = 0;
    for (int step = 0; step <= steps; ++step) {
        const double angle = std::numbers::pi / 180 * (1 + 89.0 * step / steps);
        const std::vector<double> log = netLogAt(order, {{0.2 / std::sin(angle) * direction, 0.2}}, Vec3d{});
        const double e = ambientOf(expOf(order, options, log), {0, 0, 1});
        if (step > 1) worst.add(std::abs(e - before - change_before));
        change_before = e - before;
        before = e;
    }
    return worst;
}

// m passes 1/2, 1, 2 and 4 on the way. Measured: .0001 to .0007; by the plain rule .009 to .028.
TEST(ExpOfLog, AmbientHasNoStepAsASphereComesNear) {
    for (int order = kMinLogOrder; order <= kMaxLogOrder; ++order) {
        const double smooth = largestKink(order, kSmooth), plain = largestKink(order, kPlain);
        EXPECT_GT(normOf(netLogAt(order, {{{0, 0, 0.2}, 0.2}}, Vec3d{})), 4.5);
        EXPECT_LT(smooth, 0.0015);
        EXPECT_GT(plain, 0.005);
    }
}

// On the way into a sphere the shadow goes away without a step, and in the middle all is visible. A step here is
// 0.0001 of the radius. At the surface E falls as the square root of the way: measured .0046 to .0086 in a step.
TEST(ExpOfLog, AmbientFadesInsideASphere) {
    for (int order = kMinLogOrder; order <= kMaxLogOrder; ++order) {
        Largest worst;
        double before = -1;
        for (int step = 0; step <= 3000; ++step) {
            const double distance = 0.2 * (1.1 - 0.3 * step / 3000);
            const std::vector<double> log = netLogAt(order, {{{0, 0, distance}, 0.2}}, Vec3d{});
            const double e = ambientOf(expOf(order, kSmooth, log), {0, 0, 1});
            if (before >= 0) worst.add(std::abs(e - before));
            before = e;
        }
        EXPECT_LT(worst, 0.015);
        EXPECT_NEAR(
            before,
            ambientOf(expOf(order, kSmooth, std::vector<double>(std::size_t(coefficientCount(order)))), {0, 0, 1}),
            1e-12);
    }
}

}  // namespace
}  // namespace penumbra::test_log_visibility
