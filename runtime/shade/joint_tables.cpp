#include "runtime/shade/joint_tables.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <tuple>

#include "runtime/shade/light_tables.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

int azimuthOf(int index) { return index - bandOfIndex(index) * (bandOfIndex(index) + 1); }
int mirroredIndex(int index) { return index - 2 * azimuthOf(index); }

// Tells whether f turns with the eye about the normal: A couples equal m, and m as -m.
bool isIsotropic(const std::vector<ViewTerm>& views) {
    return std::ranges::all_of(views, [&](const ViewTerm& a) {
        if (azimuthOf(a.k) != azimuthOf(a.e)) return false;
        return std::ranges::any_of(views, [&](const ViewTerm& b) {
            return b.k == mirroredIndex(a.k) && b.e == mirroredIndex(a.e) && b.value == a.value;
        });
    });
}

}  // namespace

JointTables::JointTables(const AssetView& asset, std::span<const int> orders) {
    const Convention& convention = asset.model.convention;
    const SurfaceTerms terms = surfaceTermsOf(*asset.surface);
    number_order_ = convention.order;
    const std::vector<int> indices = convention.indices();
    const auto position = [&](int index) {
        const auto at = std::ranges::lower_bound(indices, index);
        assert(at != indices.end() && *at == index);
        return std::uint16_t(at - indices.begin());
    };
    for (const int index : indices) {
        const int m = azimuthOf(index), middle = index - m;
        coefficients_.push_back(
            {std::uint16_t(index), position(middle + std::abs(m)), position(middle - std::abs(m)), m});
    }
    int slice_order = convention.order;  // of the slopes
    for (std::size_t s = 0; s < asset.surface->slots.size(); ++s) slots_.push_back(slotOf(asset, s, terms));
    for (const Slot& slot : slots_)
        for (const Term& term : slot.terms) slice_order = std::max(slice_order, bandOfIndex(term.views.back().k) + 1);
    for (std::size_t axis = 0; axis < 2 && terms.slopes > 0; ++axis) {
        const MaterialTables tables = slopeTables(convention, orders.back(), int(axis));
        slopes_[axis].views.assign(tables.viewTermsOf(0).begin(), tables.viewTermsOf(0).end());
    }
    for (const int order : orders) {
        plain_.push_back(productOf(convention, order, slice_order, 0));
        sloped_.push_back(productOf(convention, order, slice_order, -1));
    }
}

// Makes the rows of every k from azimuth `least_m` on. One that nothing couples has a row of 0.
JointTables::Product JointTables::productOf(const Convention& convention, int light_order, int slice_order,
                                            int least_m) const {
    Product product;
    std::vector<bool> used(std::size_t(coefficientCount(kMaxOrder)));
    for (int k = 0; k < coefficientCount(slice_order); ++k) used[std::size_t(k)] = azimuthOf(k) >= least_m;
    std::vector<ProductEntry> entries = sliceProduct(convention, light_order, slice_order, used);
    for (std::size_t k = 0; k < used.size(); ++k)
        if (used[k] && std::ranges::find(entries, k, &ProductEntry::k) == entries.end())
            entries.push_back({0, 0, std::uint16_t(k), 0});
    std::ranges::sort(entries, {}, [](const ProductEntry& e) { return std::tuple(e.k, e.i, e.j); });
    for (const ProductEntry& e : entries) {
        if (product.rows.empty() || product.rows.back().k != e.k || product.rows.back().i != e.i)
            product.rows.push_back({e.k, e.i, 0});
        ++product.rows.back().terms;
        product.terms.push_back({coefficients_[e.j].index, e.value});
    }
    for (const TurnTerm& term : quarterTurn(light_order)) {
        product.turn.push_back({term.to, term.from, term.value});
        product.turn_back.push_back({term.from, term.to, term.value});
    }
    for (std::vector<SparseTerm>* terms : {&product.turn, &product.turn_back})
        std::ranges::stable_sort(*terms, {}, &SparseTerm::to);
    return product;
}

// Adds a material, or returns false where it cannot be shaded with others.
bool JointTables::addTerm(const MaterialView& material, std::size_t to, Slot& slot) {
    if (material.channels != 1 || material.isLive() || material.hasSteps() || material.membrane) return false;
    Term term{viewTerms(material, Reflectance::kSlices, 0), material.color, to};
    if (term.views.empty() || !isIsotropic(term.views)) return false;
    // At azimuth 0 functions with m < 0 are 0.
    std::erase_if(term.views, [](const ViewTerm& view) { return azimuthOf(view.k) < 0; });
    view_order_ = std::max(view_order_, material.view_order);
    slot.terms.push_back(std::move(term));
    return true;
}

JointTables::Slot JointTables::slotOf(const AssetView& asset, std::size_t slot, const SurfaceTerms& terms) {
    const SlotSurface& look = asset.surface->slots[slot];
    Slot out;
    out.has_slopes = look.use(TextureRole::kNormal).any();
    bool all = addTerm(asset.materials[look.materials.diffuse], 0, out);
    for (std::size_t step = 0; step < look.materials.steps; ++step) {
        const std::size_t to = 1 + terms.slopes + 2 * step;
        all = all && addTerm(asset.materials[look.materials.f0[step]], to, out) &&
              addTerm(asset.materials[look.materials.f90[step]], to + 1, out);
    }
    return all ? out : Slot();
}

ShadeTerms JointTables::view(std::size_t slot, std::size_t order, std::size_t vertices) const {
    assert(has(slot));
    const Slot& of = slots_[slot];
    const Product& product = (of.has_slopes ? sloped_ : plain_)[order];
    ShadeTerms out{};
    out.joint = {number_order_,        coefficients_.data(), product.rows.data(),      product.rows.size(),
                 product.terms.data(), product.turn.data(),  product.turn_back.data(), product.turn.size()};
    const auto termOf = [](const Term& term) -> ShadeTerm {
        return {term.views.data(), term.views.size(), {term.color.x, term.color.y, term.color.z}, term.to};
    };
    out.view_order = view_order_;
    out.vertices = vertices;
    out.count = of.terms.size();
    for (std::size_t n = 0; n < out.count; ++n) out.terms[n] = termOf(of.terms[n]);
    out.has_slopes = of.has_slopes;
    for (std::size_t axis = 0; axis < 2; ++axis) out.slopes[axis] = termOf(slopes_[axis]);
    return out;
}

}  // namespace penumbra
