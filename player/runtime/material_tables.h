#pragma once
// What the shading kernel reads of one material, and which of it is not zero: made once, when an asset is opened.
#include <vector>

#include "formats/asset/asset_file.h"
#include "player/runtime/shade_kernel.h"

namespace penumbra {

// How radiance is had from a material; docs/formulas.md section 3.
enum class Reflectance {
    kSlices,     // L = l . (f x v), f = C y_even(omega_o), the product exact
    kOperators,  // L = sum over b of (w^b . y_even(omega_o)) l^T M^b v, paper 000 eq 11
};
bool hasReflectance(const MaterialView& material, Reflectance reflectance);

// A in f_k = sum over e of A_ke y_e(omega_o): the entries of C, or w^b with k = b, of a channel without its colour. e
// is an SH index. Entries below 1e-7 of the largest are rounding of what symmetry has as zero (of an isotropic material
// only entries that couple equal m remain), and left out where every channel has them so.
std::vector<ViewTerm> viewTerms(const MaterialView& material, Reflectance reflectance, int channel);

// B in t_i = sum over j of v_j sum over k of B_ijk f_k, sorted by (i, j, k); j is a position among the numbers.
struct ProductEntry {
    std::uint16_t i, j, k;
    float value;
};
// Gamma, for every k below `slice_order`^2 that is in `used`.
std::vector<ProductEntry> sliceProduct(const Convention& convention, int light_order, int slice_order,
                                       const std::vector<bool>& used);
// M^k_ij of one channel of the operators, for every k in `used`; entries as small as rounding in every channel left
// out.
std::vector<ProductEntry> operatorProduct(const Convention& convention, int light_order, const MaterialView& material,
                                          int channel, const std::vector<bool>& used);

// B grouped for the kernel: every (i, j) once, together with (j, i) where both are there with the same values.
struct ProductRows {
    std::vector<ProductRow> rows;  // those with a mirror first
    std::size_t mirrored = 0;
    std::vector<std::size_t> first;  // [row] its first entry in what was grouped
};
ProductRows groupRows(const Convention& convention, const std::vector<ProductEntry>& entries);

class MaterialTables {
public:
    MaterialTables(const Convention& convention, int light_order, const MaterialView& material,
                   Reflectance reflectance);
    ShadeMaterial view() const;

private:
    int view_order_, channels_;
    Vec3 color_;
    std::vector<ViewTerm> views_[3];
    ProductRows rows_;
    std::vector<ProductTerm> products_[3];  // of slices only the first: the channels share it
};

}  // namespace penumbra
