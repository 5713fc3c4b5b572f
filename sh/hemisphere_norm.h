#pragma once
// E_transfer of Nowrouzezahrai 2007 (section 6): how far predicted transfer is from the truth, independent of any
// light.
#include <array>
#include <span>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

// E = integral over s.N >= 0 of (sum_i t_i y_i)^2 ds of a transfer vector t, or of the difference of two.
class HemisphereNorm {
public:
    explicit HemisphereNorm(int order);
    // Both vectors have n^2 numbers in the model frame. A normal of zero, which sees nothing, gives zeros.
    std::array<double, 2> squared(std::span<const double> a, std::span<const double> b, Vec3 normal) const;

    // The same for one vector in a frame whose z is the normal.
    double ofLocal(std::span<const double> local) const;

private:
    struct Entry {
        int i, j;
        double value;  // H_ij = integral over z >= 0 of y_i y_j, doubled off the diagonal
    };
    int order_;
    std::vector<Entry> entries_;  // i <= j
};

}  // namespace penumbra
