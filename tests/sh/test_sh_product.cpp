#include <algorithm>
#include <numbers>
#include <tuple>

#include "sh/quadrature.h"
#include "sh/sh_product.h"
#include "sh/zonal.h"
#include "tests/sh/golden.h"
#include "tests/sh/sh_project.h"

namespace penumbra::test_sh_product {

namespace {

std::vector<double> asVector(const std::vector<TripleProductEntry>& entries, int n) {
    std::vector<double> dense(std::size_t(n) * n * n);
    for (const auto& e : entries) dense[(e.i * n + e.j) * n + e.k] = e.value;
    return dense;
}

}  // namespace

TEST(TripleProduct, MatchesGolden) {
    for (int order : {3, 4}) {
        const auto golden = readGolden("gamma_n" + std::to_string(order) + ".json");
        const int n = coefficientCount(order);
        std::vector<double> expected(std::size_t(n) * n * n);
        for (const auto& e : golden.at("entries")) {
            std::array<int, 3> ijk{e[0], e[1], e[2]};
            std::sort(ijk.begin(), ijk.end());
            do expected[(ijk[0] * n + ijk[1]) * n + ijk[2]] = e[3];
            while (std::next_permutation(ijk.begin(), ijk.end()));
        }
        const auto& gamma = tripleProduct(order, order, order);
        EXPECT_EQ(gamma.size(), golden.at("nnz_full").get<std::size_t>());
        expectNear(asVector(gamma, n), expected, golden.at("tol"));
        std::vector<double> product(n);
        multiply(order, doubles(golden.at("a")), order, doubles(golden.at("b")), order, product);
        expectNear(product, doubles(golden.at("a_times_b")), golden.at("tol"));
    }
}

TEST(TripleProduct, CountsMatchGolden) {
    const auto golden = readGolden("gamma_counts.json");
    for (const auto& row : golden.at("rows")) {
        const bool mixed = row.contains("n1");
        const int a = row.at(mixed ? "n1" : "n"), b = row.at(mixed ? "n2" : "n"), c = row.at(mixed ? "n3" : "n");
        std::size_t i_le_j = 0, sorted = 0, j_le_k = 0;
        for (const auto& e : tripleProduct(a, b, c)) {
            i_le_j += e.i <= e.j;
            j_le_k += e.j <= e.k;
            sorted += e.i <= e.j && e.j <= e.k;
        }
        EXPECT_EQ(tripleProduct(a, b, c).size(), row.at("nnz_full").get<std::size_t>());
        if (mixed)
            EXPECT_EQ(i_le_j, row.at("nnz_i_le_j").get<std::size_t>());
        else {
            EXPECT_EQ(sorted, row.at("nnz_sorted").get<std::size_t>());
            EXPECT_EQ(j_le_k, row.at("nnz_pairs_jk").get<std::size_t>());
        }
    }
}

// Compares the factorised integral with the definition, on a product grid that is exact for degree 28.
TEST(TripleProduct, MatchesDirectQuadrature) {
    const int order_i = 4, order_j = 6, order_k = 9;
    const int ni = coefficientCount(order_i), nj = coefficientCount(order_j), nk = coefficientCount(order_k);
    std::vector<double> dense(std::size_t(ni) * nj * nk), y(nk);
    for (const auto& [direction, weight] : gaussSphere(15, 30)) {
        evalBasisReference(order_k, direction, y);
        for (int i = 0; i < ni; ++i)
            for (int j = 0; j < nj; ++j)
                for (int k = 0; k < nk; ++k) dense[(i * nj + j) * nk + k] += weight * y[i] * y[j] * y[k];
    }
    const auto& gamma = tripleProduct(order_i, order_j, order_k);
    for (const auto& e : gamma) {
        double& value = dense[(e.i * nj + e.j) * nk + e.k];
        ASSERT_NEAR(e.value, value, 1e-13);
        value = 0;
    }
    for (double value : dense) ASSERT_NEAR(value, 0, 1e-13);  // pairs that are left out are zero
    EXPECT_TRUE(std::is_sorted(gamma.begin(), gamma.end(), [](const auto& a, const auto& b) {
        return std::tie(a.i, a.j, a.k) < std::tie(b.i, b.j, b.k);
    }));
}

TEST(TripleProduct, LargestTensorIsComputedOnce) {
    const auto& gamma = tripleProduct(8, 8, 15);
    EXPECT_EQ(&gamma, &tripleProduct(8, 8, 15));
}

TEST(ProductMatrix, MatchesGolden) {
    const auto golden = readGolden("product_matrix.json");
    const double tolerance = golden.at("tol");
    const std::vector<double> u = doubles(golden.at("u")), v = doubles(golden.at("v")), l = doubles(golden.at("l"));
    const auto flat = [](const nlohmann::json& rows) {
        std::vector<double> values;
        for (const auto& row : rows)
            for (double value : row) values.push_back(value);
        return values;
    };
    const std::vector<double> truncated = productMatrix(4, std::span(u).first(16), 4), exact = productMatrix(4, u, 7);
    expectNear(truncated, flat(golden.at("M_trunc")), tolerance);
    expectNear(exact, flat(golden.at("M_exact")), tolerance);
    std::vector<double> p(49);
    multiply(7, l, 4, v, 4, p);
    expectNear(p, doubles(golden.at("p")), tolerance);
    double lmv = 0, up = 0;
    for (int i = 0; i < 16; ++i)
        for (int j = 0; j < 16; ++j) lmv += l[i] * exact[16 * i + j] * v[j];
    for (int k = 0; k < 49; ++k) up += u[k] * p[k];
    EXPECT_NEAR(lmv, golden.at("lMev").get<double>(), 1e-11);
    EXPECT_NEAR(up, lmv, 1e-11);
}

TEST(ProductMatrix, ClampedCosineMatchesGolden) {
    const auto golden = readGolden("cosine_matrix.json");
    const double tolerance = golden.at("tol");
    std::vector<double> zonal(13);
    clampedCosineZonal(zonal);
    expectNear(zonal, doubles(golden.at("cos_zh")), tolerance);
    for (int order : {4, 6}) {
        const int n = coefficientCount(order);
        for (bool exact : {true, false}) {
            const int order_u = exact ? 2 * order - 1 : order;
            std::vector<double> u(coefficientCount(order_u));
            rotateZonal(std::span(zonal).first(order_u), {0, 0, 1}, u);
            const auto& entries = golden.at((exact ? "exact_n" : "trunc_n") + std::to_string(order));
            expectNear(productMatrix(order, u, order_u), symmetricMatrix(entries, n), tolerance);
        }
    }
    for (const auto& entry : golden.at("closed_n4"))
        EXPECT_NEAR(entry[3].get<double>(),
                    symmetricMatrix(golden["exact_n4"], 16)[entry[0].get<int>() * 16 + entry[1].get<int>()], 1e-14);
}

namespace {

// M_ij = integral over z >= 0 of z^alpha y_i y_j is the product matrix of the projected z^alpha. With alpha = 0 it is
// the Gram matrix of the hemisphere, else a golden Phong matrix.
std::vector<double> powerMatrix(int order, double alpha) {
    std::vector<double> u(coefficientCount(2 * order - 1));
    project(
        2 * order - 1, gaussHemisphere(64, 4 * order), [alpha](Vec3d d) { return std::pow(d.z, alpha); }, u);
    return productMatrix(order, u, 2 * order - 1);
}

}  // namespace

TEST(ProductMatrix, HemisphereGramMatchesGolden) {
    const auto golden = readGolden("hemi_gram.json");
    expectNear(powerMatrix(4, 0), symmetricMatrix(golden.at("n4"), 16), golden.at("tol"));
    expectNear(powerMatrix(6, 0), symmetricMatrix(golden.at("n6"), 36), golden.at("tol"));
}

TEST(ProductMatrix, PhongMatricesMatchGolden) {
    const auto golden = readGolden("phong_matrix.json");
    const std::vector<double> v = doubles(golden.at("v"));
    for (const auto& [alpha, value] : golden.at("values").items()) {
        const double a = std::stod(alpha);
        const std::vector<double> matrix = powerMatrix(4, a);
        expectNear(matrix, symmetricMatrix(value.at("entries"), 16), golden.at("tol"));
        std::vector<double> t(16);
        for (int i = 0; i < 16; ++i)
            for (int j = 0; j < 16; ++j) t[i] += (a + 1) / (2 * std::numbers::pi) * matrix[16 * i + j] * v[j];
        expectNear(t, doubles(value.at("t")), golden.at("tol"));
    }
}

TEST(Zonal, MatchesGolden) {
    const auto golden = readGolden("zh_rotation.json");
    for (const auto& test : golden.at("cases")) {
        std::vector<double> sh(36);
        rotateZonal(doubles(golden.at("z")), vec3(test.at("axis")), sh);
        expectNear(sh, doubles(test.at("sh")), golden.at("tol"));
    }
}

TEST(Zonal, CapIsThatOfTheClosedForm) {
    // Nowrouzezahrai 2011 eq. 23, corrected, is sqrt(pi) (1 + c), -sqrt(3pi)/2 s^2, -sqrt(5pi)/2 c s^2, ...
    const double angle = 0.7, c = std::cos(angle), s2 = 1 - c * c, pi = std::numbers::pi;
    std::array<double, 4> z;
    capVisibilityZonal(angle, z);
    EXPECT_NEAR(z[0], std::sqrt(pi) * (1 + c), 1e-14);
    EXPECT_NEAR(z[1], -std::sqrt(3 * pi) / 2 * s2, 1e-14);
    EXPECT_NEAR(z[2], -std::sqrt(5 * pi) / 2 * c * s2, 1e-14);
    EXPECT_NEAR(z[3], -std::sqrt(7 * pi) / 8 * (5 * c * c - 1) * s2, 1e-14);
}

}  // namespace penumbra::test_sh_product
