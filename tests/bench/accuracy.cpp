// The accuracy of reflectance, light and shading on fixed scenes: prints every row of the tables of docs/formulas.md
// and docs/accuracy.md and exits non-zero when a figure misses its bound.
//   ninja -C build/release accuracy
#include <gtest/gtest.h>

#include "tests/accuracy/extent.h"

int main(int argc, char** argv) {
    testing::InitGoogleTest(&argc, argv);
    penumbra::every_row = true;
    return RUN_ALL_TESTS();
}
