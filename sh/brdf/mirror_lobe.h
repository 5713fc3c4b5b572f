#pragma once
// Lobes about the mirror direction r of the view whose radiance depends on the angle to r alone: the 1-D BRDFs of
// Nowrouzezahrai 2008. Such a lobe f of light l and visibility v has the radiance
//   integral over r.s >= 0 of f(r.s) l(s) v(s) = l^T M v,  M_ij = integral over z >= 0 of f(z) y_i(s) y_j(s)
// in any frame whose z is r. M depends on the lobe alone, not on light, view or visibility. The lobe ends at the plane
// across r and not at the surface, so v must be 0 below the surface (convention B).
//
// y_lm y_l'm is a polynomial in z once the azimuth is integrated. So M follows from the moments of f, the integrals of
// f(z) z^k over (0, 1), by a short sum with constant coefficients (docs/formulas.md, "A lobe that changes").
#include <cstdint>
#include <span>
#include <vector>

#include "sh/brdf/brdf.h"

namespace penumbra {

// Tells whether the model is such a lobe (phong-live, ggx-live). Each has one parameter.
bool isMirrorLobe(BrdfModel model);

// Returns the integrals of f(z) z^k over (0, 1), k < moments.size(). The parameter must be in the model's range.
void mirrorLobeMoments(BrdfModel model, double parameter, std::span<double> moments);

// The entries of M that are not zero: y_lm and y_l'm of equal m share an azimuth, and m and -m share a value.
class MirrorLobeSum {
public:
    struct Entry {
        std::uint16_t i, j;  // SH indices
    };
    // M has rows i of order `rows` and columns j of order `columns`, both 1..kMaxOrder.
    MirrorLobeSum(int rows, int columns);

    std::span<const Entry> entries() const { return entries_; }           // sorted by (i, j)
    std::size_t momentCount() const { return std::size_t(degree_) + 1; }  // moments that evaluate() reads
    // Writes the value of every entry. Allocates nothing.
    void evaluate(std::span<const double> moments, std::span<double> values) const;

private:
    int degree_;
    std::vector<Entry> entries_;
    std::vector<double> coefficients_;  // [entries, degree + 1] of z^k
};

// The same as a dense matrix, row-major [rows^2, columns^2].
std::vector<double> mirrorLobeMatrix(int rows, int columns, std::span<const double> moments);

}  // namespace penumbra
