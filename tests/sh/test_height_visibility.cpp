#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numbers>

#include "sh/height/analytic_heights.h"
#include "sh/height/height_visibility.h"
#include "sh/mirrored_product.h"
#include "sh/quadrature.h"
#include "sh/sh_rotation.h"
#include "sh/tangent.h"
#include "tests/sh/golden.h"
#include "tests/sh/height_samples.h"
#include "tests/sh/horizon_reference.h"

namespace penumbra::test_height_visibility {
namespace {

HeightField goldenField() {
    const nlohmann::json golden = readGolden("heightfield.json");
    std::vector<float> heights;
    for (const nlohmann::json& row : golden["heights"])
        for (const double z : doubles(row)) heights.push_back(float(z));
    return HeightField({33, 33, 1, 1, HeightBorder::kOpen}, heights);
}

double rmsOf(std::span<const double> a, std::span<const float> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - double(b[i])) * (a[i] - double(b[i]));
    return std::sqrt(sum / (4 * std::numbers::pi));
}

TEST(Horizon, TracedHorizonsAreTheGoldenOnes) {
    const nlohmann::json golden = readGolden("heightfield.json");
    const HeightField field = goldenField();
    for (std::size_t r = 0; r < 4; ++r) {
        const std::vector<double> at = doubles(golden["receivers"][r]), expected = doubles(golden["horizon"][r]);
        std::vector<double> tangents(16);
        traceHorizon(field, float(at[0]), float(at[1]), 0.25f, tangents);
        for (double& t : tangents) t = std::atan(t);
        expectNear(tangents, expected, 1e-5);
    }
}

TEST(Horizon, ThetasAreTheGoldenOnes) {
    const nlohmann::json golden = readGolden("heightfield.json");
    for (const auto& [omega, expected] : golden.at("theta_closed").items()) {
        std::vector<double> thetas(10);
        horizonThetas(4, std::tan(std::stod(omega)), thetas);
        for (int l = 0, i = 0; l < 4; ++l)
            for (int m = 0; m <= l; ++m, ++i)
                EXPECT_NEAR(thetas[std::size_t(i)], expected[std::size_t(l)][std::size_t(m)].get<double>(), 1e-12)
                    << omega << " " << l << " " << m;
    }
}

// A trapezoid over 64 azimuths of a constant horizon is exact, and Gauss' nodes are for polynomials between two
// heights.
TEST(Horizon, ThetasOfOrder5AreTheIntegralsOfTheBasis) {
    for (const double omega : {-1.4, -0.3, 0.0, 0.4, 1.1}) {
        std::vector<double> out(25), expected(25), y(25);
        horizonVisibility(5, std::vector<double>(64, std::tan(omega)), out);
        const double low = std::sin(omega);
        for (const WeightedNumber& node : gaussInterval(24)) {
            const double z = low + (1 - low) * node.x, flat = std::sqrt(1 - z * z);
            for (int a = 0; a < 64; ++a) {
                const double phi = 2 * std::numbers::pi * a / 64;
                evalBasis(5, Vec3d{flat * std::cos(phi), flat * std::sin(phi), z}, y);
                for (std::size_t i = 0; i < 25; ++i)
                    expected[i] += y[i] * node.weight * (1 - low) * 2 * std::numbers::pi / 64;
            }
        }
        expectNear(out, expected, 1e-9);
    }
}

TEST(Horizon, TrapezoidIsTheGoldenOne) {
    const nlohmann::json golden = readGolden("heightfield.json");
    for (std::size_t r = 0; r < 4; ++r) {
        std::vector<double> tangents = doubles(golden["horizon"][r]), out(16);
        for (double& t : tangents) t = std::tan(t);
        horizonVisibility(4, tangents, out);
        expectNear(out, doubles(golden["sh4_trapezoid"][r]), 1e-9);
    }
}

// Measured: 3e-7 to 1.1e-6 of V, which is at most 3.5.
TEST(HeightVisibility, IsThePlainFormOnEveryPathAndBorder) {
    for (const HeightBorder border : {HeightBorder::kOpen, HeightBorder::kClamped, HeightBorder::kPeriodic})
        for (const auto& [rows, columns] : {std::pair{48, 40}, {1, 33}, {17, 1}}) {
            const HeightField field({rows, columns, 0.5f, 1.25f, border}, fractalHeights(rows, columns, 1.8, 4));
            std::vector<float> at_row, at_column, at_height;
            for (int k = 0; k < 59; ++k) {  // the last block is not full
                at_row.push_back(float(k * 7 % (10 * rows)) / 10);
                at_column.push_back(float(k * 13 % (10 * columns)) / 10);
                at_height.push_back(field.at(at_row.back(), at_column.back()) + float(k % 3));
            }
            const HorizonTaps taps = horizonTaps(field);
            for (const HeightPath& path : pathsOf<HeightPath>())
                for (int order = 4; order <= 5; ++order) {
                    const std::size_t n = std::size_t(coefficientCount(order));
                    std::vector<float> out(59 * n);
                    HeightTables(field, order, order, path)
                        .visibility(field, {at_row.data(), at_column.data(), at_height.data(), 59}, n, out);
                    for (std::size_t p = 0; p < 59; ++p) {
                        std::vector<float> tangents(kHorizonAzimuths);
                        horizonTangents(field, taps, at_row[p], at_column[p], at_height[p], tangents);
                        std::vector<double> expected(n);
                        horizonVisibility(order, std::vector<double>(tangents.begin(), tangents.end()), expected);
                        for (std::size_t i = 0; i < n; ++i)
                            EXPECT_NEAR(out[p * n + i], expected[i], 2e-5)
                                << path.name << " " << int(border) << " " << rows << " " << p << " " << i;
                    }
                }
        }
}

// Half of the sphere, to the last digit: every horizon is 0, whatever the height and the cells.
TEST(HeightVisibility, OfALevelFieldIsExactlyAHemisphereAndItsNumbersAreFreeSight) {
    for (const HeightPath& path : pathsOf<HeightPath>())
        for (const HeightBorder border : {HeightBorder::kClamped, HeightBorder::kPeriodic}) {
            const HeightField field({19, 23, 0.3f, 0.7f, border}, std::vector<float>(19 * 23, 1234.567f));
            std::vector<float> tangents(kHorizonAzimuths);
            horizonTangents(field, horizonTaps(field), 3.3f, 7.7f, 1234.567f, tangents);
            for (const float t : tangents) EXPECT_EQ(t, 0);
            HeightVisibility visibility(field, 5, 4, path);
            visibility.evaluate(field, 0, visibility.receiverRows());
            std::vector<double> below(25);
            belowHorizonCoefficients(5, below);
            for (std::size_t i = 0; i < 25; ++i)
                EXPECT_NEAR(double(visibility.receiver(2, 2)[i]),
                            (i == 0 ? 2 * std::sqrt(std::numbers::pi) : 0.0) - below[i], 1e-6);
            std::array<Vec3, 23> normals, tangent;
            std::array<float, 23 * 16> coefficients;
            for (int row = 0; row < 19; ++row) {
                visibility.coefficients(field, row, 0, normals, tangent, 16, coefficients);
                for (std::size_t p = 0; p < 23; ++p)
                    for (std::size_t i = 0; i < 15; ++i)
                        EXPECT_NEAR(coefficients[16 * p + i], i == 0 ? 2 * std::sqrt(std::numbers::pi) : 0, 3e-6);
            }
        }
}

struct Quality {
    double rms, bias;  // of V over the sphere; of its mean
};

// Against traced horizons at 128 azimuths.
Quality qualityOf(const HeightField& field, int order, int receivers) {
    const HeightTables tables(field, order, order);
    const std::size_t n = std::size_t(coefficientCount(order));
    Quality out{};
    for (int k = 0; k < receivers; ++k) {
        const float row = float(16 + k * 37 % (field.grid().rows - 32)),
                    column = float(16 + k * 101 % (field.grid().columns - 32)), height = field.at(row, column);
        std::vector<float> v(n);
        tables.visibility(field, {&row, &column, &height, 1}, n, v);
        std::vector<double> tangents(128), truth(n);
        traceHorizon(field, row, column, 0.25f, tangents);
        horizonVisibility(order, tangents, truth);
        out.rms += std::pow(rmsOf(truth, v), 2) / receivers;
        out.bias += (double(v[0]) - truth[0]) / std::sqrt(4 * std::numbers::pi) / receivers;
    }
    out.rms = std::sqrt(out.rms);
    return out;
}

// The bounds are those of the formulas for order 4. Order 5 holds them, too: its fifth band errs as the others do.
TEST(HeightVisibility, IsNearTracedHorizonsOnRoughAndOnSmoothGround) {
    for (const auto& [beta, deviation, most] : {std::array{1.6, 10.0, 0.0125}, {2.2, 20.0, 0.015}}) {
        const HeightField field({256, 256, 1, 1, HeightBorder::kOpen}, fractalHeights(256, 256, beta, deviation));
        const Quality quality = qualityOf(field, 4, 64), five = qualityOf(field, 5, 64);
        EXPECT_LT(quality.rms, most) << beta << ", bias " << quality.bias;
        EXPECT_LT(five.rms, most) << beta << ", bias " << five.bias;
        std::printf("1/f^%.1f: rms V %.4f of order 4, %.4f of order 5\n", beta, quality.rms, five.rms);
    }
}

// What the coefficients of a point say, made step by step from V.
TEST(HeightVisibility, NumbersAreVInTheFrameOfThePointMirroredAtItsHorizon) {
    const HeightField field({24, 24, 0.5f, 0.5f}, fractalHeights(24, 24, 2, 1));
    std::vector<float> rows, columns, heights;
    std::vector<Vec3> normals, tangents;
    for (int k = 0; k < 27; ++k) {
        rows.push_back(float(k % 24)), columns.push_back(float(5 * k % 24));
        heights.push_back(field.at(rows.back(), columns.back()) + 0.3f);
        const double z = k == 0 ? 1 : k == 1 ? -1 : std::cos(0.35 * k), flat = std::sqrt(1 - z * z);
        normals.push_back(toFloat(Vec3d{flat * std::cos(2.4 * k), flat * std::sin(2.4 * k), z}));
        tangents.push_back(tangentOf(normals.back(), {float(std::sin(k)), float(std::cos(3 * k)), 0.3f}));
    }
    for (const HeightPath& path : pathsOf<HeightPath>())
        for (int order = 4; order <= 5; ++order) {
            const std::size_t n = std::size_t(coefficientCount(order));
            for (const bool on_field : {false, true}) {
                const HeightTables tables(field, order, 6, path);
                std::vector<float> v(27 * n), out(27 * 21);
                tables.visibility(field, {rows.data(), columns.data(), heights.data(), 27}, n, v);
                tables.mirror(v, n, {normals.data(), tangents.data()},
                              on_field ? HeightReceiver::kOnField : HeightReceiver::kAbove, 21, out);
                std::vector<double> below(n);
                belowHorizonCoefficients(order, below);
                std::vector<float> weights(21), local(n), wide(36), expected(21);
                ambientWeights({BelowHorizon::kMirrored, 6}, weights);
                float norm2 = 0;
                for (const float w : weights) norm2 += w * w;
                for (std::size_t p = 0; p < 27; ++p) {
                    const Mat3 q = fromRows(tangents[p], cross(normals[p], tangents[p]), normals[p]);
                    apply(makeShRotation(order, q), std::span(v).subspan(p * n, n), local);
                    for (std::size_t i = 0; i < n; ++i) wide[i] = local[i] + (on_field ? float(below[i]) : 0);
                    mirrorAtHorizon(6, wide, expected);
                    clampAmbient(weights, norm2, expected);
                    for (std::size_t i = 0; i < 21; ++i)
                        EXPECT_NEAR(out[p * 21 + i], expected[i], 2e-5)
                            << path.name << " " << order << " " << on_field << " " << p << " " << i;
                }
            }
        }
}

TEST(HeightVisibility, AfterAnEditIsThatOfTheWholeAndFewReceiversWoke) {
    for (const HeightBorder border : {HeightBorder::kOpen, HeightBorder::kClamped, HeightBorder::kPeriodic}) {
        std::vector<float> heights = fractalHeights(160, 128, 2, 4);
        HeightField field({160, 128, 1, 1, border}, heights);
        HeightVisibility visibility(field, 5, 2);
        visibility.evaluate(field, 0, visibility.receiverRows());
        EXPECT_EQ(visibility.awake(), 0u);
        for (const TexelBox box : {TexelBox{60, 70, 66, 75}, TexelBox{0, 100, 3, 128}, TexelBox{155, 0, 160, 4}}) {
            std::vector<float> bump;
            for (int r = box.first_row; r < box.end_row; ++r)
                for (int c = box.first_column; c < box.end_column; ++c)
                    bump.push_back(heights[std::size_t(r * 128 + c)] += 0.4f);
            visibility.wake(field, field.set(box, bump));
            const double share = double(visibility.awake()) / double(visibility.receiverCount());
            EXPECT_GT(share, 0);
            EXPECT_LT(share, 0.995) << int(border);    // measured: at most 0.989
            if (bump.size() == 30) {                   // away from the edge
                EXPECT_LT(share, 0.8) << int(border);  // measured: 0.57 to 0.75; the bump is higher than all around it
            }
            visibility.evaluate(field, 0, visibility.receiverRows());
            HeightVisibility whole(field, 5, 2);
            whole.evaluate(field, 0, whole.receiverRows());
            for (std::size_t r = 0; r < whole.receiverRows(); ++r)
                for (std::size_t c = 0; c < 64; ++c)
                    EXPECT_TRUE(std::ranges::equal(visibility.receiver(r, c), whole.receiver(r, c)))
                        << int(border) << " " << r << " " << c;
        }
    }
}

TEST(HeightVisibility, OfExtremeReliefIsFinite) {
    for (const float relief : {1e6f, 1e7f}) {
        std::vector<float> heights(33 * 65);
        for (std::size_t i = 0; i < heights.size(); ++i) heights[i] = i % 7 == 3 ? relief : -relief;
        for (const HeightBorder border : {HeightBorder::kOpen, HeightBorder::kClamped, HeightBorder::kPeriodic}) {
            const HeightField field({33, 65, kMinCell, 10, border}, heights);
            for (const HeightPath& path : pathsOf<HeightPath>()) {
                HeightVisibility visibility(field, 5, 4, path);
                visibility.evaluate(field, 0, visibility.receiverRows());
                std::array<Vec3, 65> normals, tangents;
                std::array<float, 65 * 16> coefficients;
                for (int row = 0; row < 33; ++row) {
                    visibility.coefficients(field, row, 0, normals, tangents, 16, coefficients);
                    for (std::size_t p = 0; p < 65; ++p) {
                        EXPECT_NEAR(length(normals[p]), 1, 1e-5);
                        for (std::size_t i = 0; i < 15; ++i) EXPECT_LT(std::abs(coefficients[16 * p + i]), 8);
                    }
                }
            }
        }
    }
}

TEST(HeightVisibility, OfTheWidestFieldIsThePlainForm) {
    std::vector<float> heights;
    for (int i = 0; i < kMaxHeightSide; ++i) heights.push_back(float(i % 977) * 0.1f);
    const HeightField field({1, kMaxHeightSide}, heights);
    HeightVisibility visibility(field, 4, 8);
    visibility.evaluate(field, 0, 1);
    const HorizonTaps taps = horizonTaps(field);
    for (const std::size_t c : {std::size_t(0), std::size_t(4111), visibility.receiverCount() - 1}) {
        const float column = float(visibility.receivers().lines(1)[c]);
        std::vector<float> tangents(kHorizonAzimuths);
        horizonTangents(field, taps, 0, column, field.at(0, column), tangents);
        std::vector<double> expected(16);
        horizonVisibility(4, std::vector<double>(tangents.begin(), tangents.end()), expected);
        EXPECT_LT(rmsOf(expected, visibility.receiver(0, c)), 2e-3) << c;  // places have 1/128 of a point there
    }
}

TEST(AnalyticHeights, AreDefinedByWordsAndRefuseOthers) {
    EXPECT_EQ(parseAnalyticHeights("waves:height=0.5,count=3+ripples").size(), 2u);
    EXPECT_EQ(parseAnalyticHeights("waves:length=1e+03+ripples")[0].length, 1000);
    for (const char* wrong : {"", "hills", "waves:height", "waves:height=-1", "waves:count=0", "dunes:spread=3",
                              "waves+", "waves+1", "ripples:length=nan", "ripples:angle=30"})
        EXPECT_THROW(parseAnalyticHeights(wrong), std::invalid_argument) << wrong;
}

TEST(AnalyticHeights, MoveAndStayWithinTheirHeight) {
    const HeightGrid grid{40, 50, 0.25f, 0.25f};
    for (const char* text : {"waves:height=0.3", "dunes:height=2", "ripples:height=0.1"}) {
        const std::vector<AnalyticHeights> fields = parseAnalyticHeights(text);
        std::vector<float> a(grid.size()), b(grid.size()), half(grid.size());
        analyticHeights(fields, grid, 1, 0, 40, a);
        analyticHeights(fields, grid, 1.5, 0, 40, b);
        EXPECT_NE(a, b) << text;
        analyticHeights(fields, grid, 1, 0, 20, half);
        analyticHeights(fields, grid, 1, 20, 40, half);
        EXPECT_EQ(a, half) << text;
        const double most = 3 * fields[0].height;
        for (const float z : a) EXPECT_LE(std::abs(z), most) << text;
    }
}

// Second differences along rows and columns: those across a border, and all others.
std::pair<double, double> bendsAt(const HeightGrid& grid, const std::vector<float>& heights) {
    double border = 0, inside = 0;
    const auto at = [&](int r, int c) {
        return double(heights[std::size_t((r + grid.rows) % grid.rows) * std::size_t(grid.columns) +
                              std::size_t((c + grid.columns) % grid.columns)]);
    };
    for (int r = 0; r < grid.rows; ++r)
        for (int c = 0; c < grid.columns; ++c) {
            const double x = std::abs(at(r - 1, c) - 2 * at(r, c) + at(r + 1, c)),
                         y = std::abs(at(r, c - 1) - 2 * at(r, c) + at(r, c + 1));
            (r == 0 || r == grid.rows - 1 ? border : inside) =
                std::max(r == 0 || r == grid.rows - 1 ? border : inside, x);
            (c == 0 || c == grid.columns - 1 ? border : inside) =
                std::max(c == 0 || c == grid.columns - 1 ? border : inside, y);
        }
    return {border, inside};
}

TEST(AnalyticHeights, CloseAtAPeriodicBorder) {
    for (const char* text : {"waves", "waves:length=30,seed=4", "dunes", "dunes:length=3,angle=37", "dunes:length=90",
                             "ripples:length=2"}) {
        HeightGrid grid{150, 190, 0.1f, 0.08f, HeightBorder::kPeriodic};
        std::vector<float> heights(grid.size());
        analyticHeights(parseAnalyticHeights(text), grid, 1.7, 0, grid.rows, heights);
        const auto [border, inside] = bendsAt(grid, heights);
        EXPECT_LE(border, 1.05 * inside) << text;
        EXPECT_GT(inside, 0) << text;
    }
}

}  // namespace
}  // namespace penumbra::test_height_visibility
