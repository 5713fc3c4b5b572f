#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "sh/cast/cap_visibility.h"
#include "sh/sh_product.h"
#include "sh/symmetric_eigen.h"
#include "sh/zonal.h"
#include "tests/sh/caster_scenes.h"

namespace penumbra::test_cap_visibility {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// V = U D U^T gives the matrix back, with orthonormal vectors.
TEST(SymmetricEigen, GivesTheMatrixBack) {
    for (std::size_t n : {1u, 2u, 6u}) {
        std::vector<double> matrix(n * n), vectors(n * n);
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j <= i; ++j)
                matrix[i * n + j] = matrix[j * n + i] = std::sin(double(7 * i + 3 * j + 1));
        std::vector<double> diagonal = matrix;
        diagonalise(n, diagonal, vectors);
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j < n; ++j) {
                double value = 0, product = 0;
                for (std::size_t k = 0; k < n; ++k) {
                    value += vectors[k * n + i] * diagonal[k * n + k] * vectors[k * n + j];
                    product += vectors[i * n + k] * vectors[j * n + k];
                }
                EXPECT_NEAR(value, matrix[i * n + j], 1e-14);
                EXPECT_NEAR(product, i == j, 1e-14);
            }
    }
}

// The closed form of the visibility past a sphere, from outside and, with the fade, from inside of it.
TEST(CapVisibility, PastASphereMatchesGolden) {
    const auto golden = readGolden("sphere_zh.json");
    ASSERT_EQ(golden.at("cases").size(), 13u);
    for (const auto& test : golden.at("cases")) {
        const bool inside = test.contains("d_over_r");
        const double distance = inside ? test.at("d_over_r").get<double>() : 1;
        const double radius = inside ? 1 : test.at("r_over_d").get<double>();
        const Cap cap = capOf({{0, 0, distance}, radius}, {});
        EXPECT_EQ(cap.axis, (Vec3d{0, 0, 1}));
        std::vector<double> z(6);
        capVisibilityZonal(cap.angle, z);
        expectNear(z, doubles(test.at(inside ? "zh_fade" : "zh")), 1e-13);
        if (inside) {
            EXPECT_NEAR(sineOfCap(distance, radius), test.at("rule_fade_sin").get<double>(), 1e-14);
            belowPlaneZonal(test.at("cos_full"), z);
            expectNear(z, doubles(test.at("zh_full")), 1e-13);
        }
    }
    const auto& rotated = golden.at("rotated");
    const double radius = rotated.at("r_over_d");
    const Cap cap = capOf({vec3(rotated.at("axis")), radius}, {});
    std::vector<double> z(6), sh(36);
    capVisibilityZonal(cap.angle, z);
    rotateZonal(z, cap.axis, sh);
    expectNear(sh, doubles(rotated.at("sh")), 1e-13);
}

// The product that logarithms are about, in files of this subject.
TEST(CapVisibility, ProductMatchesGolden) {
    const auto golden = readGolden("sh_product.json");
    std::vector<double> product(16);
    multiply(4, doubles(golden.at("a")), 4, doubles(golden.at("b")), 4, product);
    expectNear(product, doubles(golden.at("ab")), 1e-13);
    EXPECT_EQ(tripleProduct(4, 4, 4).size(), golden.at("gamma_nonzeros_order4").get<std::size_t>());
    EXPECT_EQ(tripleProduct(6, 6, 6).size(), golden.at("gamma_nonzeros_order6").get<std::size_t>());
    for (const auto& [name, value] : golden.at("gamma_samples").items()) {
        int i, j, k;
        ASSERT_EQ(std::sscanf(name.c_str(), "%d,%d,%d", &i, &j, &k), 3);
        double found = 0;
        for (const TripleProductEntry& e : tripleProduct(4, 4, 4))
            if (e.i == i && e.j == j && e.k == k) found = e.value;
        EXPECT_NEAR(found, value.get<double>(), 1e-14) << name;
    }
}

TEST(CapLog, RowsMatchGolden) {
    const auto golden = readGolden("shexp.json");
    for (int order = kMinLogOrder; order <= kMaxLogOrder; ++order) {
        const auto& rows = golden.at("tables").at(std::to_string(order)).at("zh_log");
        ASSERT_EQ(rows.size(), 65u);
        std::vector<double> z(std::size_t(order), 0.0);
        for (std::size_t e = 0; e < rows.size(); ++e) {
            capLogZonal(2 * std::asin(double(e) / 64 * std::sin(kMaxCapAngle / 2)), z);
            expectNear(z, doubles(rows[e]), 1e-9);
        }
    }
}

TEST(CapLog, TablesMatchGolden) {
    const auto golden = readGolden("shexp_orders.json");
    for (int order : {3, 5}) {
        const auto& rows = golden.at("tables").at(std::to_string(order));
        const CapLogTableD& table = capLogTableD(order);
        ASSERT_EQ(rows.size(), table.rows.size());
        for (std::size_t e = 0; e < rows.size(); ++e)
            for (std::size_t l = 0; l < std::size_t(order); ++l) {
                const double scale = std::sqrt(4 * std::numbers::pi / double(2 * l + 1)), value = rows[e][l];
                ASSERT_NEAR(table.rows[e][l] / scale, value, golden.at("tol_table").get<double>()) << e << ", " << l;
            }
        for (const double zero : table.rows[0]) EXPECT_EQ(zero, 0);
    }
}

// 1e-9 is the golden files' tolerance for interpolated tables, in `shexp_orders.json` of orders 3 and 5. Those of
// orders 4 and 6 (`shexp.json`) are sums of exact rows; interpolation was measured to be within 8.9e-5 of them.
TEST(NetLog, MatchesGolden) {
    const auto golden = readGolden("shexp_orders.json");
    std::size_t spheres = 0;
    for (const auto& scene : golden.at("scenes"))
        for (int order : {3, 5}) {
            const auto& expected = scene.at("order" + std::to_string(order));
            const std::vector<double> log = netLogOf(order, goldenCaps(scene.at("axis"), scene.at("theta")));
            expectNear(log, doubles(expected.at("log")), golden.at("tol"));
            if (!scene.contains("centres")) continue;
            ++spheres;
            const std::vector<CasterSphereD> set = goldenSpheres(scene.at("centres"), scene.at("radii"));
            expectNear(netLogAt(order, set, vec3(scene.at("receiver"))), doubles(expected.at("log")), golden.at("tol"));
            const std::vector<float> floats = netLogAt(order, inFloats(set), toFloat(vec3(scene.at("receiver"))));
            expectNear(std::vector<double>(floats.begin(), floats.end()), doubles(expected.at("log")),
                       golden.at("tol_float"));
        }
    EXPECT_EQ(spheres, 14u);
}

TEST(NetLog, OfExactRowsMatchesGolden) {
    const auto golden = readGolden("shexp.json");
    for (const auto& scene : golden.at("scenes"))
        for (int order : {4, 6}) {
            const std::vector<Cap> caps = goldenCaps(scene.at("axis"), scene.at("theta"));
            const std::vector<double> expected = doubles(scene.at("order" + std::to_string(order)).at("log"));
            std::vector<double> z(std::size_t(order), 0.0), turned(expected.size()), sum(expected.size());
            for (const Cap& cap : caps) {
                capLogZonal(cap.angle, z);
                rotateZonal(z, cap.axis, turned);
                for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += turned[i];
            }
            expectNear(sum, expected, 1e-12);
            expectNear(netLogOf(order, caps), expected, 2e-4);
        }
}

// A receiver that enters a sphere sees it fade: the cap is half the sphere at the surface, shrinks on the way in, and
// is gone at 85% of the radius.
TEST(NetLog, OfASphereFadesInside) {
    EXPECT_EQ(sineOfCap(1.0f, 1.0f), 1);
    EXPECT_NEAR(sineOfCap(0.9999999, 1.0), 1, 1e-6);
    for (int order = kMinLogOrder; order <= kMaxLogOrder; ++order) {
        const std::vector<CasterSphere> sphere = {{{0, 0, 0}, 0.2f}};
        float before = 0;
        for (int step = 0; step <= 400; ++step) {
            const float distance = 0.2f * float(step) / 400;
            const std::vector<float> log = netLogAt(order, sphere, {distance, 0, 0});
            if (distance < 0.2f * 0.8499f) {
                for (const float f : log) EXPECT_EQ(f, 0) << distance;
            } else {
                EXPECT_LE(log[0], before) << distance;
            }
            before = log[0];
        }
        EXPECT_LT(before, -5);
    }
}

TEST(NetLog, IgnoresWhatHidesNothing) {
    const std::vector<CasterSphere> nothing = {{{0, 0, 0}, 1}, {{0, 0, 1e-7f}, 1e-8f}, {{1, 0, 0}, 0}};
    for (const float f : netLogAt(5, nothing, {0, 0, 0})) EXPECT_EQ(f, 0);
    for (const float f : netLogAt(5, std::vector<CasterSphere>{}, {0, 0, 0})) EXPECT_EQ(f, 0);
}

// Caps above 165 degrees count as that.
TEST(NetLog, EndsWithTheTable) {
    const std::vector<double> most = netLogOf(5, {{{0, 0.6, 0.8}, kMaxCapAngle}}),
                              more = netLogOf(5, {{{0, 0.6, 0.8}, 179 * kDegree}});
    EXPECT_EQ(most, more);
}

}  // namespace
}  // namespace penumbra::test_cap_visibility
