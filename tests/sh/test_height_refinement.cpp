// More receivers where those of a cell do not tell what its points see.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numbers>

#include "sh/height/analytic_heights.h"
#include "sh/height/height_visibility.h"
#include "tests/difference.h"
#include "tests/sh/height_samples.h"

namespace penumbra::test_height_refinement {
namespace {

struct Looked {
    std::vector<float> coefficients;  // [points, 16]
    std::size_t finer = 0;            // receivers
};

Looked lookedAt(const HeightField& field, HeightVisibility& visibility) {
    const HeightGrid& grid = field.grid();
    const auto columns = std::size_t(grid.columns);
    Looked out{std::vector<float>(grid.size() * 16)};
    std::vector<Vec3> normals(64), tangents(64);
    const auto refined = std::make_unique<HeightRefined>();
    visibility.evaluate(field, 0, visibility.receiverRows());
    for (int band = 0; band < grid.rows; band += visibility.step())
        for (int c = 0; c < grid.columns; c += HeightRefined::kColumns) {
            const int end = std::min(c + HeightRefined::kColumns, grid.columns);
            const auto count = std::size_t(end - c);
            visibility.refine(field, band, c, end, *refined);
            if (refined->any) out.finer += refined->count;
            for (int r = band; r < std::min(band + visibility.step(), grid.rows); ++r)
                visibility.coefficients(
                    field, r, c, std::span(normals).first(count), std::span(tangents).first(count), 16,
                    std::span(out.coefficients).subspan((std::size_t(r) * columns + std::size_t(c)) * 16),
                    refined.get());
        }
    visibility.freshen();
    return out;
}

Looked lookedAt(const HeightField& field, int order, int step, float tolerance,
                const HeightPath& path = fastestHeightPath()) {
    HeightVisibility visibility(field, order, step, path);
    visibility.setTolerance(tolerance);
    return lookedAt(field, visibility);
}

TEST(HeightRefinement, ErrorIsHalfAGeometricMeanAndFinerFadesInFromTheTolerance) {
    EXPECT_EQ(cellError(0, 0), 0);
    EXPECT_FLOAT_EQ(cellError(0.1f, 0.1f), 0.5f * 0.11f);
    EXPECT_FLOAT_EQ(cellError(0.1f, 0), 0.5f * std::sqrt(0.001f));
    EXPECT_FLOAT_EQ(cellError(0, 0.1f), cellError(0.1f, 0));
    EXPECT_EQ(refinementOf(0.02f, 0.02f), 0);
    EXPECT_FLOAT_EQ(refinementOf(0.025f, 0.02f), 0.5f);
    EXPECT_EQ(refinementOf(0.031f, 0.02f), 1);
}

// Where a tolerance is next to nothing every point looks for itself, and sees to the last bit what it sees at full
// resolution.
TEST(HeightRefinement, OfAllCellsIsFullResolution) {
    for (const HeightBorder border : {HeightBorder::kClamped, HeightBorder::kPeriodic, HeightBorder::kOpen})
        for (const auto& [rows, columns] : {std::pair{41, 70}, {40, 131}, {38, 67}, {1, 70}, {29, 1}, {3, 3}})
            for (const int order : {4, 5}) {
                const HeightField field({rows, columns, 1, 1.5f, border}, fractalHeights(rows, columns, 1.6, 6));
                const Looked full = lookedAt(field, order, 1, 0);
                for (const int step : {2, 4, 8})
                    EXPECT_EQ(lookedAt(field, order, step, 1e-7f).coefficients, full.coefficients)
                        << int(border) << " " << rows << " " << columns << " " << order << " " << step;
                EXPECT_GT(largestDifference(lookedAt(field, order, 8, 0).coefficients, full.coefficients), 0.05)
                    << int(border) << " " << rows << " " << columns;
            }
}

TEST(HeightRefinement, OfALevelFieldAndOfSmoothWavesHasNoFinerReceivers) {
    const HeightGrid grid{160, 160, 0.05f, 0.05f};
    std::vector<float> heights(grid.size(), 3.0f);
    EXPECT_EQ(lookedAt(HeightField(grid, heights), 5, 4, 1e-3f).finer, 0u);
    const std::vector<AnalyticHeights> waves = parseAnalyticHeights("waves:height=0.25,length=4,count=5");
    for (const double seconds : {0.0, 1.0, 2.5}) {
        analyticHeights(waves, grid, seconds, 0, grid.rows, heights);
        EXPECT_EQ(lookedAt(HeightField(grid, heights), 5, 4, kHeightTolerance).finer, 0u) << seconds;
    }
}

// Of spectra from rough to smooth. Measured at the tolerance of 0.025: 0.0000 to 0.0225, where step 4 has 0.035 to
// 0.21.
TEST(HeightRefinement, ErrorStaysBelowTheToleranceOnEverySpectrum) {
    for (const auto& [beta, deviation] : {std::pair{1.6, 10.0}, {1.8, 5.0}, {2.2, 20.0}, {2.0, 5.0}}) {
        const HeightField field({96, 128, 1, 1}, fractalHeights(96, 128, beta, deviation, 7));
        const Looked full = lookedAt(field, 5, 1, 0), coarse = lookedAt(field, 5, 4, 0),
                     refined = lookedAt(field, 5, 4, kHeightTolerance);
        const auto rms = [&](const Looked& one) {
            double sum = 0;
            for (std::size_t i = 0; i < full.coefficients.size(); ++i)
                sum += std::pow(double(one.coefficients[i] - full.coefficients[i]), 2);
            return std::sqrt(sum / double(field.grid().size()) / (4 * std::numbers::pi));
        };
        std::printf("1/f^%.1f: rms of mirrored V %.4f, without more receivers %.4f; %.2f of all points\n", beta,
                    rms(refined), rms(coarse), double(refined.finer) / double(field.grid().size()));
        EXPECT_LT(rms(refined), double(kHeightTolerance)) << beta;
        EXPECT_LT(rms(refined), 0.7 * rms(coarse)) << beta;
    }
}

// What moves a little sees a little else: a tenth of a step in time changes no number by more than a fifth of what the
// whole step does. A threshold without a fade jumps by as much in any step. Measured: 0.10 to 0.11.
TEST(HeightRefinement, FadesInAnAnimationWithoutPopping) {
    const HeightGrid grid{64, 96, 0.1f, 0.1f};
    const std::vector<AnalyticHeights> dunes =
        parseAnalyticHeights("dunes:height=0.6,length=3,speed=1+waves:height=0.1");
    std::vector<float> heights(grid.size());
    analyticHeights(dunes, grid, 0, 0, grid.rows, heights);
    HeightField field(grid, heights);
    HeightVisibility visibility(field, 5, 4);
    visibility.setTolerance(kHeightTolerance);
    const auto largestStep = [&](double seconds) {
        Largest most;
        std::vector<float> before;
        std::size_t least_finer = grid.size(), most_finer = 0;
        for (int k = 0; k < 40; ++k) {
            analyticHeights(dunes, grid, k * seconds, 0, grid.rows, heights);
            visibility.wake(field, field.set(heights));
            const Looked now = lookedAt(field, visibility);
            if (k > 0) most.add(largestDifference(now.coefficients, before));
            before = now.coefficients;
            least_finer = std::min(least_finer, now.finer);
            most_finer = std::max(most_finer, now.finer);
        }
        EXPECT_LT(least_finer, most_finer);  // cells come and go
        return most.value();
    };
    const double whole = largestStep(2e-3), tenth = largestStep(2e-4);
    std::printf("largest step %.4f, of a tenth of the time %.4f\n", whole, tenth);
    EXPECT_LT(tenth, 0.2 * whole);
}

TEST(HeightRefinement, OfEveryPathIsThePortableOne) {
    const HeightField field({50, 90, 1, 1}, fractalHeights(50, 90, 2.3, 4));
    for (const int order : {4, 5}) {
        const Looked portable = lookedAt(field, order, 4, kHeightTolerance, HeightPath::portable);
        EXPECT_GT(portable.finer, 100u);
        EXPECT_LT(portable.finer, field.grid().size() * 9 / 10);
        // A share moves by 100 times what V does, in units of V. Measured: 4e-6.
        EXPECT_LT(largestDifference(lookedAt(field, order, 4, kHeightTolerance).coefficients, portable.coefficients),
                  1e-4);
    }
}

// Only stale cells are looked at again after an edit.
TEST(HeightRefinement, AfterAnEditCellsThatAreNotStaleSeeWhatTheySaw) {
    for (const HeightBorder border : {HeightBorder::kOpen, HeightBorder::kClamped, HeightBorder::kPeriodic})
        for (const int step : {2, 4, 8}) {
            std::vector<float> heights = fractalHeights(70, 90, 2.1, 5);
            const HeightGrid grid{70, 90, 1, 1, border};
            HeightField field(grid, heights);
            HeightVisibility visibility(field, 4, step);
            visibility.setTolerance(kHeightTolerance);
            Looked before = lookedAt(field, visibility);
            std::size_t stale = 0, kept = 0;
            for (const TexelBox box : {TexelBox{33, 41, 35, 42}, {0, 0, 2, 3}, {68, 88, 70, 90}, {20, 89, 21, 90}}) {
                std::vector<float> bump;
                for (int r = box.first_row; r < box.end_row; ++r)
                    for (int c = box.first_column; c < box.end_column; ++c)
                        bump.push_back(heights[std::size_t(r * grid.columns + c)] += 0.7f);
                visibility.wake(field, field.set(box, bump));
                visibility.evaluate(field, 0, visibility.receiverRows());
                std::vector<char> is_stale(grid.size());
                for (int r = 0; r < grid.rows; ++r)
                    for (int c = 0; c < grid.columns; ++c)
                        is_stale[std::size_t(r * grid.columns + c)] =
                            visibility.isStale(field, std::size_t(r / step), std::size_t(c / step));
                const Looked after = lookedAt(field, visibility), whole = lookedAt(field, 4, step, kHeightTolerance);
                EXPECT_EQ(after.coefficients, whole.coefficients) << int(border) << " " << step;
                for (std::size_t p = 0; p < grid.size(); ++p) {
                    stale += is_stale[p];
                    kept += !is_stale[p];
                    if (is_stale[p]) continue;
                    EXPECT_TRUE(std::ranges::equal(std::span(after.coefficients).subspan(16 * p, 16),
                                                   std::span(before.coefficients).subspan(16 * p, 16)))
                        << int(border) << " " << step << " " << p;
                }
                before = after;
            }
            EXPECT_GT(stale, 0u);
            EXPECT_GT(kept, grid.size() / 4) << step;
        }
}

}  // namespace
}  // namespace penumbra::test_height_refinement
