// Tests lobes about the mirror direction: their moments and the matrix that these give.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sh/brdf/mirror_lobe.h"
#include "sh/brdf/phong_matrix.h"
#include "sh/quadrature.h"
#include "sh/sh_basis.h"
#include "tests/sh/golden.h"

namespace penumbra::test_mirror_lobe {
namespace {

constexpr double kPi = std::numbers::pi;

// Order 6 at the exponents 0, 1, 2.7, 5, 10, 50 and 300, made from exact fractions.
TEST(MirrorLobe, PhongMatrixOfOrderSixMatchesGolden) {
    const auto golden = readGolden("phong_from_d5.json");
    for (const auto& [text, values] : golden.at("values").items()) {
        const std::vector<double> matrix = phongMatrix(std::stod(text), 6);
        std::size_t at = 0, zeros = 0;
        for (const auto& entry : golden.at("entries")) {
            const int l = entry[0], k = entry[1], m = entry[2];
            for (const int sign : {1, -1})
                EXPECT_NEAR(matrix[std::size_t(shIndex(l, sign * m) * 36 + shIndex(k, sign * m))],
                            values[at].get<double>(), 1e-12)
                    << text << " " << entry;
            ++at;
        }
        for (const double value : matrix) zeros += value == 0;
        EXPECT_GE(zeros, 36u * 36 - 146) << "146 entries of order 6 can be other than zero";
    }
}

// At alpha = 0 the matrix is the Gram matrix of the hemisphere that turns mirrored numbers into moments.
TEST(MirrorLobe, GramMatchesGolden) {
    const auto golden = readGolden("phong_from_d5.json");
    std::vector<double> moments;
    for (int k = 0; k < 10; ++k) moments.push_back(1 / double(k + 1));
    const std::vector<double> gram = mirrorLobeMatrix(6, 5, moments);
    for (const auto& entry : golden.at("gram"))
        EXPECT_NEAR(gram[entry[0].get<std::size_t>() * 25 + entry[1].get<std::size_t>()], entry[2].get<double>(),
                    1e-12);
}

// M of either model is the integral of the BRDF times the cosine times y_i y_j, seen along the normal, where the mirror
// direction is the normal. The grid is exact for polynomials; z^2.7 and GGX come within 1e-9.
TEST(MirrorLobe, MatrixIsTheIntegralOfTheBrdf) {
    for (const char* text : {"phong-live:exponent=2.7", "phong-live:exponent=0", "ggx-live:alpha=0.3",
                             "ggx-live:alpha=0.999999", "ggx-live:alpha=1"}) {
        const BrdfSpec spec = parseBrdf(text);
        const BrdfFunction f = brdfFunction(spec);
        std::vector<double> sums(16 * 36), y(36), moments(9);
        for (const auto& [direction, weight] : gaussHemisphere(400, 16)) {
            evalBasis(6, direction, y);
            const double value = weight * f(direction, {0, 0, 1}) * direction.z;
            for (std::size_t i = 0; i < 16; ++i)
                for (std::size_t j = 0; j < 36; ++j) sums[i * 36 + j] += value * y[i] * y[j];
        }
        mirrorLobeMoments(modelOf(spec), f.parameters[0], moments);
        expectNear(mirrorLobeMatrix(4, 6, moments), sums, 1e-9);
    }
}

// Below the plane across the mirror direction is nothing, also of the widest lobe.
TEST(MirrorLobe, AnExponentOfZeroIsTheLimitOfSmallOnes) {
    const Vec3d eye = normalized(Vec3d{0.9, 0, 0.4});
    const BrdfFunction zero = brdfFunction(parseBrdf("phong-live:exponent=0")),
                       small = brdfFunction(parseBrdf("phong-live:exponent=1e-9"));
    for (const auto& [direction, weight] : gaussHemisphere(12, 24))
        EXPECT_NEAR(zero(direction, eye), small(direction, eye), 1e-6 * (1 + zero(direction, eye)));
    EXPECT_EQ(zero(normalized(Vec3d{0.9, 0, 0.2}), eye), 0);
}

// However narrow, a lobe sends back what it should: (a + 1)/2pi z^a integrates to 1 over the hemisphere; GGX's lobe
// loses only what lies below the plane, (1 - a^2) / (1 + a^2) there is left to 1.
TEST(MirrorLobe, EnergyIsThatOfTheLobe) {
    std::vector<double> moments(13);
    for (const double exponent : {0.0, 2.7, 50.0, 1000.0}) {
        mirrorLobeMoments(BrdfModel::kPhongLive, exponent, moments);
        EXPECT_NEAR(2 * kPi * moments[0], 1, 1e-14) << exponent;
    }
    for (const double alpha : {0.01, 0.1, 0.3, 1.0}) {
        mirrorLobeMoments(BrdfModel::kGgxLive, alpha, moments);
        const double a2 = alpha * alpha;
        EXPECT_NEAR(2 * kPi * moments[0], 1 / (1 + a2), 1e-12) << alpha;
        for (std::size_t k = 1; k < moments.size(); ++k) EXPECT_LT(moments[k], moments[k - 1]);
    }
}

// The parameter is refused by name and range.
TEST(MirrorLobe, WrongParametersAreNamed) {
    for (const auto& [text, words] : {std::pair("phong-live:exponent=-1", "exponent must be a number from 0 to 1000"),
                                      {"phong-live:exponent=nan", "exponent must be a number from 0 to 1000"},
                                      {"phong-live:exponent=1e5", "exponent must be a number from 0 to 1000"},
                                      {"ggx-live:alpha=0", "alpha must be a number from 0.01 to 1"}}) {
        try {
            parseBrdf(text);
            FAIL() << text;
        } catch (const std::invalid_argument& error) {
            EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
        }
    }
    EXPECT_THROW(checkParameter(BrdfModel::kPhongLive, 0, std::nan(""), 0, 1000), std::invalid_argument);
    EXPECT_THROW(checkParameter(BrdfModel::kPhongLive, 0, -1e-9, 0, 1000), std::invalid_argument);
    EXPECT_NO_THROW(checkParameter(BrdfModel::kPhongLive, 0, 1000, 0, 1000));
}

}  // namespace
}  // namespace penumbra::test_mirror_lobe
