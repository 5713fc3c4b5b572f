// Compares slices by the shortcuts that a BRDF's symmetries allow with plain integration.
#include <gtest/gtest.h>

#include <string>

#include "formats/brdf/slice_table.h"
#include "sh/quadrature.h"
#include "sh/sh_basis.h"
#include "tests/accuracy/extent.h"

namespace penumbra::test_symmetry_table {
namespace {

// Compares the shortcuts (rotation for isotropic BRDFs, mirrors for the others) with a table without them.
TEST(FitBrdf, SymmetriesMatchDirectIntegration) {
    for (const char* text : {"phong:exponent=20", "ward:ax=0.2,ay=0.5", "ashikhmin-shirley"}) {
        if (!every_row && text == std::string("ashikhmin-shirley")) continue;  // it has the mirrors of Ward's model
        const BrdfSpec spec = parseBrdf(text);
        const SliceTable table = tabulateSlices(rgbBrdf(spec), 5, 16, 8, 1);
        const auto incident = gaussHemisphere(16, 32);
        std::vector<double> y(25), slice(25);
        for (std::size_t o = 0; o < table.views.size(); ++o) {
            std::fill(slice.begin(), slice.end(), 0.0);
            for (const auto& [direction, weight] : incident) {
                evalBasis(5, direction, y);
                for (std::size_t i = 0; i < 25; ++i)
                    slice[i] += weight * direction.z * brdfFunction(spec)(direction, table.views[o]) * y[i];
            }
            // The azimuths of views are on those of the incident grid, so both sums have the same terms.
            for (std::size_t i = 0; i < 25; ++i) ASSERT_NEAR(table.slices[(o * 25 + i) * 3], slice[i], 1e-11) << text;
        }
    }
}

}  // namespace
}  // namespace penumbra::test_symmetry_table
