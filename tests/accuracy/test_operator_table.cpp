// Operators M^b of Nowrouzezahrai 2009 three ways and slices in three conventions, on the scenes of docs/formulas.md
// section 3.
#include <gtest/gtest.h>

#include <cstdio>

#include "fit/papers/operators/brdf_operators.h"
#include "fit/reflectance/fit_brdf.h"
#include "tests/accuracy/extent.h"
#include "tests/fit/multiply_adds.h"
#include "tests/fit/reference_brdfs.h"

namespace penumbra::test_operator_table {
namespace {

const Convention kA4{BelowHorizon::kOpen, 4}, kD5{BelowHorizon::kMirrored, 5};

// The table of docs/formulas.md section 3: shading errors of the four ways, and their costs.
struct Row {
    const char* brdf;
    double literal, table, slices, a4, d4, d5;     // bounds
    double literal_seen, table_seen, slices_seen;  // measured values, which must hold within 1% or 5e-4
};

TEST(BrdfOperators, ShadingErrorsAreThoseOfTheTable) {
    // The bound of `literal` is the value of the reference implementation to three digits. Those of `table` and `d5`
    // are the bounds asked for; for Phong 50 and Ward GMD from the table there are none, so they are the measured value
    // plus 5%. Those of `slices`, `a4` and `d4` are the measured values plus 5%.
    const Row rows[] = {{kReferenceBrdfs[0], .136, .016, .0165, .0165, .0197, .006, .1362, .0157, .0156},
                        {kReferenceBrdfs[1], .203, .17, .126, .097, .0983, .072, .2026, .1535, .1198},
                        {kReferenceBrdfs[2], .584, .46, .32, .195, .195, .17, .5843, .4387, .3049},
                        {kReferenceBrdfs[3], .218, .143, .136, .102, .0952, .072, .2183, .1297, .1295},
                        {kReferenceBrdfs[4], .175, .14, .111, .091, .0933, .072, .1751, .1203, .1053},
                        {kReferenceBrdfs[5], .235, .20, .115, .083, .0754, .060, .2345, .1841, .1094},
                        {kReferenceBrdfs[6], .179, .095, .091, .065, .0672, .050, .1787, .0843, .0860}};
    std::printf(
        "%-44s %7s %7s %7s %7s %7s  ratio   bytes: literal, D5; multiply-adds: literal dense, without zeros, D5\n", "",
        "literal", "table", "slices", "C, A4", "C, D5");
    for (const Row& row : rows) {
        if (!every_row && &row != &rows[0] && &row != &rows[6]) continue;
        const RgbBrdf brdf = rgbBrdf(parseBrdf(row.brdf));
        BrdfFile file = fitBrdf(brdf, {}, 2);
        const ShadingTruth truth = shadingTruth(brdf, 2);
        measureShading(truth, file);
        double errors[3];
        std::size_t bytes = 0, dense = 0, sparse = 0;
        for (OperatorSource from : {OperatorSource::kTable, OperatorSource::kSlices, OperatorSource::kLiteral}) {
            file.operators = fitOperators(brdf, file, from, 8, 2);
            measureOperators(truth, file);
            errors[int(from)] = file.errors.at("shading_operators");
            bytes = expandedBytes(file.operators, 4, kA4) / 3;
            dense = multiplyAdds(file.operators, 4, kA4, true).total(4);
            sparse = multiplyAdds(file.operators, 4, kA4, false).total(4);
            EXPECT_LE(bytes, 10'000u) << row.brdf;
        }
        const double literal = errors[int(OperatorSource::kLiteral)], table = errors[int(OperatorSource::kTable)],
                     slices = errors[int(OperatorSource::kSlices)], a4 = file.errors.at("shading_a4"),
                     d5 = file.errors.at("shading_d5"),
                     d4 = shadingError(truth, {BelowHorizon::kMirrored, 4},
                                       slicesOfViews(truth.test.scenes.views, file.slices, file.even_index), 5);
        const std::size_t slice_bytes = file.slices.size() / 3 * sizeof(float),
                          slice_work = multiplyAdds(file, 4, kD5).total(4);
        std::printf("%-44s %7.4f %7.4f %7.4f %7.4f %7.4f  %4.1fx  %zu %zu; %zu %zu %zu\n", row.brdf, literal, table,
                    slices, a4, d5, literal / d5, bytes, slice_bytes, dense, sparse, slice_work);
        EXPECT_NEAR(literal, row.literal, 6e-4) << row.brdf;
        EXPECT_LE(table, row.table) << row.brdf;
        EXPECT_LE(slices, row.slices) << row.brdf;
        EXPECT_LE(a4, row.a4) << row.brdf;
        EXPECT_LE(d4, row.d4) << row.brdf;
        EXPECT_LE(d5, row.d5) << row.brdf;
        EXPECT_NEAR(literal, row.literal_seen, 5e-4);
        EXPECT_NEAR(table, row.table_seen, 5e-4);
        EXPECT_NEAR(slices, row.slices_seen, 5e-4);
        EXPECT_GE(literal, (std::string(row.brdf) == "phong:exponent=50" ? 3 : 2) * d5) << row.brdf;
        EXPECT_LE(slice_bytes, 1536u);
        if (file.operators.count > 1) {
            EXPECT_LT(slice_work, dense) << row.brdf;
        }
    }
}

}  // namespace
}  // namespace penumbra::test_operator_table
