#include "sh/brdf/phong_matrix.h"

#include <cassert>
#include <cmath>

namespace penumbra {

namespace {

// The 20 different entries of appendix A, where a1 = alpha + 1 and so on. M_0C, M_6C and M_BB are corrected, and M_66
// is added.
struct PhongEntry {
    int i, j;
    double value;
};

std::vector<PhongEntry> phongEntries(double a) {
    const double a1 = a + 1, a2 = a + 2, a3 = a + 3, a4 = a + 4, a5 = a + 5, a6 = a + 6, a7 = a + 7;
    const auto root = [](double x) { return std::sqrt(x); };
    return {{0, 0, 1 / (2 * a1)},
            {0, 2, root(3) / (2 * a2)},
            {0, 6, root(5) * a / (2 * a1 * a3)},
            {0, 12, root(7) * (a - 1) / (2 * a2 * a4)},
            {2, 2, 3 / (2 * a3)},
            {2, 6, root(15) * a1 / (2 * a2 * a4)},
            {2, 12, root(21) * a / (2 * a3 * a5)},
            {6, 6, 5 * (a * a + 2 * a + 3) / (2 * a1 * a3 * a5)},
            {6, 12, root(35) * (a * a + 2 * a + 6) / (2 * a2 * a4 * a6)},
            {12, 12, 7 * (a * a + 2 * a + 15) / (2 * a3 * a5 * a7)},
            {1, 1, 3 / (2 * a1 * a3)},
            {1, 5, 3 * root(5) / (2 * a2 * a4)},
            {1, 11, 3 * root(14) * a / (2 * a1 * a3 * a5)},
            {5, 5, 15 / (2 * a3 * a5)},
            {5, 11, 3 * root(70) * a1 / (2 * a2 * a4 * a6)},
            {11, 11, 21 * (2 * a * a + 4 * a + 5) / (2 * a1 * a3 * a5 * a7)},
            {4, 4, 15 / (2 * a1 * a3 * a5)},
            {4, 10, 15 * root(7) / (2 * a2 * a4 * a6)},
            {10, 10, 105 / (2 * a3 * a5 * a7)},
            {9, 9, 105 / (2 * a1 * a3 * a5 * a7)}};
}

// Returns the index of (l, -m) for that of (l, m).
int mirrored(int index) {
    int band = 0;
    while ((band + 1) * (band + 1) <= index) ++band;
    return 2 * band * (band + 1) - index;
}

}  // namespace

std::vector<double> phongMatrix(double alpha) {
    assert(alpha >= 0);
    constexpr int kCount = kPhongOrder * kPhongOrder;
    std::vector<double> matrix(kCount * kCount);
    for (const auto& [i, j, value] : phongEntries(alpha))
        for (const auto& [row, column] : {std::pair(i, j), {mirrored(i), mirrored(j)}})
            matrix[std::size_t(row * kCount + column)] = matrix[std::size_t(column * kCount + row)] = value;
    return matrix;
}

}  // namespace penumbra
