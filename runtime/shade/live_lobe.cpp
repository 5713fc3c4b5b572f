#include "runtime/shade/live_lobe.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "runtime/shade/light_tables.h"

namespace penumbra {

namespace {

// Returns G for numbers of a mirrored convention.
std::vector<SparseTerm> gramTerms(int order, const Convention& convention) {
    const MirrorLobeSum sum(order, convention.order);
    std::vector<double> moments, values(sum.entries().size());
    for (std::size_t k = 0; k < sum.momentCount(); ++k) moments.push_back(1 / double(k + 1));
    sum.evaluate(moments, values);
    const std::vector<int> indices = convention.indices();
    std::vector<SparseTerm> gram;
    for (std::size_t e = 0; e < values.size(); ++e) {
        const auto at = std::lower_bound(indices.begin(), indices.end(), int(sum.entries()[e].j));
        if (std::abs(values[e]) > 1e-12 && at != indices.end() && *at == sum.entries()[e].j)
            gram.push_back({sum.entries()[e].i, std::uint16_t(at - indices.begin()), float(values[e])});
    }
    return gram;
}

}  // namespace

MomentForm momentForm(const Convention& convention) {
    const bool mirrored = convention.below == BelowHorizon::kMirrored;
    MomentForm form{mirrored ? std::min(convention.order + 1, kMaxOrder) : convention.order, {}, {}, {}};
    form.offset.resize(std::size_t(coefficientCount(form.order)));
    std::vector<double> below(form.offset.size());
    belowHorizonCoefficients(form.order, below);
    const double root = std::sqrt(4 * std::numbers::pi);
    for (int l = 0; l < form.order; ++l)
        form.sky.push_back(float(root * ((l == 0 ? root : 0) - below[std::size_t(shIndex(l, 0))])));
    if (mirrored) {
        form.terms = gramTerms(form.order, convention);
        return form;
    }
    for (int i = 0; i < coefficientCount(form.order); ++i)
        form.terms.push_back({std::uint16_t(i), std::uint16_t(i), 1});
    if (convention.below == BelowHorizon::kBlocked) return form;
    for (std::size_t i = 0; i < below.size(); ++i) form.offset[i] = -float(below[i]);
    return form;
}

LiveLobe::LiveLobe(const Convention& convention, int light_order, const BrdfLobe& lobe)
    : moment_form_(momentForm(convention)), sum_(light_order, moment_form_.order) {
    assert(isMirrorLobe(lobe.model));
    for (const TurnTerm& term : quarterTurn(moment_form_.order)) {
        turn_.push_back({term.to, term.from, term.value});
        turn_back_.push_back({term.from, term.to, term.value});
    }
    for (std::vector<SparseTerm>* terms : {&turn_, &turn_back_})
        std::stable_sort(terms->begin(), terms->end(),
                         [](const SparseTerm& a, const SparseTerm& b) { return a.to < b.to; });
    for (const auto& [i, j] : sum_.entries()) matrix_.push_back({i, j, 0});
    moments_.resize(sum_.momentCount());
    values_.resize(matrix_.size());
    albedo_.resize(moment_form_.sky.size());
    set(lobe);
}

void LiveLobe::set(const BrdfLobe& lobe) {
    mirrorLobeMoments(lobe.model, double(lobe.parameters[0]), moments_);
    sum_.evaluate(moments_, values_);
    for (std::size_t e = 0; e < matrix_.size(); ++e) matrix_[e].value = float(values_[e]);
    // Row 0 of M has the bands of m = 0 alone, in their order.
    for (std::size_t l = 0; l < albedo_.size(); ++l) albedo_[l] = moment_form_.sky[l] * matrix_[l].value;
}

ShadeLive LiveLobe::view() const {
    return {moment_form_.order,
            moment_form_.offset.data(),
            moment_form_.terms.data(),
            moment_form_.terms.size(),
            turn_.data(),
            turn_.size(),
            turn_back_.data(),
            turn_back_.size(),
            matrix_.data(),
            matrix_.size(),
            albedo_.data()};
}

}  // namespace penumbra
