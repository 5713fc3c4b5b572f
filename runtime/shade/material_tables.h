#pragma once
// Holds what the shading kernel reads of one material, without entries that are zero. It is made once, when an asset
// is opened.
#include <optional>
#include <string_view>
#include <vector>

#include "formats/asset/asset_file.h"
#include "runtime/shade/live_lobe.h"
#include "runtime/shade/shade_kernel.h"

namespace penumbra {

// Tells how radiance is computed from a material (docs/formulas.md, section 3).
enum class Reflectance {
    kSlices,     // L = l . (f x v), f = C y_even(omega_o), the product exact
    kOperators,  // L = sum over b of (w^b . y_even(omega_o)) l^T M^b v, Nowrouzezahrai 2009 eq 11
};
// Tells whether the material has what the form needs: kOperators needs operators. A live material has every form.
bool hasReflectance(const MaterialView& material, Reflectance reflectance);

// A parameter that may change while a program runs: of a live material, or of one with steps.
struct ChangingParameter {
    std::string_view name;
    std::size_t index = 0;  // among parametersOf() of the lobe
    double least = 0, most = 0;
    std::size_t lobe = 0;    // the first of the material that has it
    std::uint8_t lobes = 1;  // bit i: lobe i has it
};
// Returns it, or nothing for a material that stays as it is.
std::optional<ChangingParameter> changingParameter(const MaterialView& material);

// Returns A in f_k = sum over e of A_ke y_e(omega_o): the entries of C, or w^b with k = b, of one channel without its
// colour. e is an SH index. Entries below 1e-7 of the largest are rounding errors of what symmetry makes zero (for an
// isotropic material only entries that couple equal m remain). They are left out where every channel and every step
// has them so.
std::vector<ViewTerm> viewTerms(const MaterialView& material, Reflectance reflectance, int channel);
// Returns the values of these terms at every step of a material, [steps, terms].
std::vector<float> stepTerms(const MaterialView& material, int channel);

// An entry of B in t_i = sum over j of v_j sum over k of B_ijk f_k, sorted by (i, j, k). j is a position among the
// numbers.
struct ProductEntry {
    std::uint16_t i, j, k;
    float value;
};
// Returns the entries of Gamma for every k below `slice_order`^2 that is in `used`.
std::vector<ProductEntry> sliceProduct(const Convention& convention, int light_order, int slice_order,
                                       const std::vector<bool>& used);
// Returns M^k_ij of one channel of the operators, for every k in `used`. Entries that are as small as rounding in
// every channel are left out.
std::vector<ProductEntry> operatorProduct(const Convention& convention, int light_order, const MaterialView& material,
                                          int channel, const std::vector<bool>& used);

// Groups B for the kernel: every (i, j) stands once, together with (j, i) where both are there with the same values.
struct ProductRows {
    std::vector<ProductRow> rows;  // rows with a mirror come first
    std::size_t mirrored = 0;
    std::vector<std::size_t> first;  // [row] the row's first entry in the list that was grouped
};
ProductRows groupRows(const Convention& convention, const std::vector<ProductEntry>& entries);

class MaterialTables {
public:
    MaterialTables(const Convention& convention, int light_order, const MaterialView& material,
                   Reflectance reflectance);
    ShadeMaterial view() const;
    // Changes the lobe of a live material. Allocates nothing.
    void setLobe(const BrdfLobe& lobe) { live_->set(lobe); }
    const LiveLobe& live() const { return *live_; }
    // Interpolates the view terms of a material with steps. Allocates nothing.
    void setStep(double value);
    // For what reflects with signs: what bounces is then not held above 0.
    void allowNegative();
    // A of one channel, with a parameter as it is set.
    std::span<const ViewTerm> viewTermsOf(std::size_t channel) const { return views_[channel]; }

private:
    int view_order_, channels_;
    Vec3 color_;
    std::vector<ViewTerm> views_[3];
    std::vector<double> steps_;
    std::vector<float> step_terms_[3];  // [steps, views_]
    ProductRows rows_;
    std::optional<LiveLobe> live_;                     // set for a live material, which has no terms
    std::size_t albedo_first_ = 0, albedo_terms_ = 0;  // terms of the row (0, 0)
    float least_hidden_ = 0;
    std::vector<ProductTerm> products_[3];  // products_: for slices only the first is filled, as the channels share it
};

}  // namespace penumbra
