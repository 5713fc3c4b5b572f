#pragma once
// What the shading kernel reads where all terms of a surface are shaded at once (shade_terms_lanes.h). It is made once,
// when an asset is opened.
#include <vector>

#include "formats/asset/asset_file.h"
#include "runtime/shade/material_tables.h"
#include "runtime/shade/surface_terms.h"

namespace penumbra {

class JointTables {
public:
    JointTables() = default;
    // Makes the tables of the slots of asset.surface. `orders` are those of the lights, ascending.
    JointTables(const AssetView& asset, std::span<const int> orders);

    // Tells whether the terms of a slot are shaded at once: there are more than one, and all are isotropic, grey and
    // without a parameter that changes.
    bool has(std::size_t slot) const { return slot < slots_.size() && slots_[slot].count() > 1; }
    // Returns what the kernel reads for a slot that has() them, under a light of orders[order].
    ShadeTerms view(std::size_t slot, std::size_t order, std::size_t vertices) const;

private:
    struct Product {
        std::vector<JointRow> rows;
        std::vector<JointTerm> terms;
        std::vector<SparseTerm> turn, turn_back;
    };
    struct Term {
        std::vector<ViewTerm> views;
        Vec3 color{1, 1, 1};
        std::size_t to = 0;
    };
    struct Slot {
        std::vector<Term> terms;
        bool has_slopes = false;
        std::size_t count() const { return terms.size() + (has_slopes ? 3 : 0); }
    };
    int number_order_ = 0, view_order_ = 1;
    std::vector<JointCoefficient> coefficients_;
    std::vector<Product> plain_, sloped_;  // [orders]; sloped_ has what slopes need besides
    std::vector<Slot> slots_;
    Term slopes_[2];

    Product productOf(const Convention& convention, int light_order, int slice_order, int least_m) const;
    bool addTerm(const MaterialView& material, std::size_t to, Slot& slot);
    Slot slotOf(const AssetView& asset, std::size_t slot, const SurfaceTerms& terms);
};

}  // namespace penumbra
