#include "runtime/shade/material_tables.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

#include "sh/brdf/reflection_operator.h"
#include "sh/reflectance.h"
#include "sh/sh_product.h"

namespace penumbra {

constexpr float kRounding = 1e-7f;  // as a share of the largest entry

bool hasReflectance(const MaterialView& material, Reflectance reflectance) {
    return material.isLive() || reflectance == Reflectance::kSlices || material.operators.count > 0;
}

std::optional<ChangingParameter> changingParameter(const MaterialView& material) {
    if (!material.isLive() && !material.hasSteps()) return std::nullopt;
    const std::size_t index = material.isLive() ? 0 : material.step_parameter;
    const std::uint8_t lobes = material.isLive() ? 1 : material.step_lobes;
    const auto first = std::size_t(std::countr_zero(lobes));
    const BrdfParameter& known = parametersOf(material.lobes[first].model)[index];
    if (material.isLive()) return ChangingParameter{known.name, index, known.least, known.most};
    return ChangingParameter{known.name, index, material.steps.front(), material.steps.back(), first, lobes};
}

namespace {

// Returns the entries of a channel's matrix that are not rounding errors.
std::vector<std::size_t> keptEntries(const MaterialView& material, std::span<const float> values,
                                     std::size_t per_channel) {
    // Every channel of every step has a say.
    std::vector<float> size(per_channel);
    for (const std::span<const float> all : {values, material.step_slices})
        for (std::size_t i = 0; i < all.size(); ++i)
            size[i % per_channel] = std::max(size[i % per_channel], std::abs(all[i]));
    const float largest = *std::max_element(size.begin(), size.end());
    std::vector<std::size_t> kept;
    for (std::size_t at = 0; at < per_channel; ++at)
        if (size[at] > kRounding * largest) kept.push_back(at);
    return kept;
}

}  // namespace

std::vector<ViewTerm> viewTerms(const MaterialView& material, Reflectance reflectance, int channel) {
    const bool slices = reflectance == Reflectance::kSlices;
    const std::vector<int> even = evenIndices(material.view_order);
    const std::span<const float> values = slices ? material.slices : material.operators.w;
    const std::size_t count = std::size_t(slices ? coefficientCount(material.slice_order) : material.operators.count);
    const std::size_t per_channel = count * even.size();
    std::vector<ViewTerm> terms;
    for (const std::size_t at : keptEntries(material, values, per_channel))
        terms.push_back({std::uint16_t(at / even.size()), std::uint16_t(even[at % even.size()]),
                         values[std::size_t(channel) * per_channel + at]});
    return terms;
}

std::vector<float> stepTerms(const MaterialView& material, int channel) {
    const std::size_t channels = std::size_t(material.channels), per_channel = material.slices.size() / channels;
    const std::vector<std::size_t> kept = keptEntries(material, material.slices, per_channel);
    std::vector<float> terms;
    for (std::size_t s = 0; s < material.steps.size(); ++s)
        for (const std::size_t at : kept)
            terms.push_back(material.step_slices[(s * channels + std::size_t(channel)) * per_channel + at]);
    return terms;
}

std::vector<ProductEntry> sliceProduct(const Convention& convention, int light_order, int slice_order,
                                       const std::vector<bool>& used) {
    const std::vector<int> indices = convention.indices();
    std::array<int, coefficientCount(kMaxOrder)> position;
    position.fill(-1);
    for (std::size_t j = 0; j < indices.size(); ++j) position[std::size_t(indices[j])] = int(j);
    std::vector<ProductEntry> entries;
    for (const TripleProductEntry& e : tripleProduct(light_order, convention.order, slice_order))
        if (position[e.j] >= 0 && used[e.k])
            entries.push_back({e.i, std::uint16_t(position[e.j]), e.k, float(e.value)});
    return entries;
}

std::vector<ProductEntry> operatorProduct(const Convention& convention, int light_order, const MaterialView& material,
                                          int channel, const std::vector<bool>& used) {
    const OperatorsView& operators = material.operators;
    const std::size_t k = std::size_t(operators.count), coefficients = std::size_t(convention.size());
    // 1. Expand all operators of all channels to matrices, since an entry stays if any channel has it.
    const std::size_t u_size = std::size_t(coefficientCount(operators.order));
    std::vector<std::vector<float>> m;  // [channel, k][light_order^2, numbers]
    float largest = 0;
    for (std::size_t set = 0; set < std::size_t(material.channels) * k; ++set) {
        m.push_back(reflectionOperator(light_order, convention, operators.u.subspan(set * u_size, u_size)));
        for (const float value : m.back()) largest = std::max(largest, std::abs(value));
    }
    // 2. Keep the entries that matter, in the order (i, j, k).
    std::vector<ProductEntry> entries;
    for (std::size_t at = 0; at < m.front().size(); ++at)
        for (std::size_t b = 0; b < k; ++b) {
            float size = 0;
            for (std::size_t set = b; set < m.size(); set += k) size = std::max(size, std::abs(m[set][at]));
            if (used[b] && size > kRounding * largest)
                entries.push_back({std::uint16_t(at / coefficients), std::uint16_t(at % coefficients), std::uint16_t(b),
                                   m[std::size_t(channel) * k + b][at]});
        }
    return entries;
}

namespace {

// Lists every (i, j) once, in the order of the entries. `first` gets the first entry of each.
std::vector<ProductRow> plainRows(const std::vector<ProductEntry>& entries, std::vector<std::size_t>& first) {
    std::vector<ProductRow> rows;
    for (std::size_t at = 0; at < entries.size(); ++at) {
        const ProductEntry& e = entries[at];
        if (rows.empty() || rows.back().i != e.i || rows.back().j != e.j) {
            rows.push_back({e.i, e.j, 0, 0, 0});
            first.push_back(at);
        }
        ++rows.back().terms;
    }
    return rows;
}

}  // namespace

ProductRows groupRows(const Convention& convention, const std::vector<ProductEntry>& entries) {
    const std::vector<int> indices = convention.indices();
    std::vector<std::size_t> first;
    const std::vector<ProductRow> all = plainRows(entries, first);
    constexpr int kCount = coefficientCount(kMaxOrder);
    std::vector<int> row_of(kCount * kCount, -1);  // by both SH indices
    for (std::size_t r = 0; r < all.size(); ++r) row_of[std::size_t(all[r].i * kCount + indices[all[r].j])] = int(r);
    // Rows go by diagonals of (i, j). Rows that follow one another then add to different t, so that no sum waits for
    // the one before.
    std::vector<int> visit(all.size());
    std::iota(visit.begin(), visit.end(), 0);
    std::stable_sort(visit.begin(), visit.end(), [&](int a, int b) {
        const auto diagonal = [&](int r) { return indices[all[std::size_t(r)].j] - int(all[std::size_t(r)].i); };
        return diagonal(a) < diagonal(b);
    });
    ProductRows result;
    for (const bool mirrored : {true, false})
        for (const int r : visit) {
            ProductRow row = all[std::size_t(r)];
            // The mirror is the row of (index of j, position of i). It has the same terms, as Gamma_ijk = Gamma_jik.
            const int mirror = row_of[std::size_t(indices[row.j] * kCount + row.i)];
            const bool has_mirror = mirror >= 0 && mirror != r;
            if (has_mirror != mirrored || (mirrored && mirror < r)) continue;
            if (mirrored) row.mirror_i = all[std::size_t(mirror)].i, row.mirror_j = all[std::size_t(mirror)].j;
            result.rows.push_back(row);
            result.first.push_back(first[std::size_t(r)]);
            result.mirrored += mirrored;
        }
    return result;
}

MaterialTables::MaterialTables(const Convention& convention, int light_order, const MaterialView& material,
                               Reflectance reflectance)
    : view_order_(material.view_order),
      channels_(material.channels),
      color_(material.color),
      steps_(material.steps.begin(), material.steps.end()) {
    assert(hasReflectance(material, reflectance));
    if (material.isLive()) {
        live_.emplace(convention, light_order, material.lobes.front());
        return;
    }
    // Only k that some view term produces can count.
    std::vector<bool> used(std::size_t(coefficientCount(kMaxOrder)));
    for (int c = 0; c < channels_; ++c) {
        views_[c] = viewTerms(material, reflectance, c);
        if (material.hasSteps()) step_terms_[c] = stepTerms(material, c);
        for (const ViewTerm& term : views_[c]) used[term.k] = true;
    }
    const bool slices = reflectance == Reflectance::kSlices;
    // Slices share one Gamma among the channels; operators have matrices for each channel.
    for (int c = 0; c < (slices ? 1 : channels_); ++c) {
        const std::vector<ProductEntry> entries =
            slices ? sliceProduct(convention, light_order, material.slice_order, used)
                   : operatorProduct(convention, light_order, material, c, used);
        if (c == 0) rows_ = groupRows(convention, entries);
        for (std::size_t r = 0; r < rows_.rows.size(); ++r) {
            if (rows_.rows[r].i == 0 && rows_.rows[r].j == 0) {
                albedo_first_ = products_[c].size();
                albedo_terms_ = rows_.rows[r].terms;
            }
            for (std::size_t at = rows_.first[r]; at < rows_.first[r] + rows_.rows[r].terms; ++at)
                products_[c].push_back({entries[at].k, entries[at].value});
        }
    }
}

void MaterialTables::setStep(double value) {
    const auto high = std::size_t(std::upper_bound(steps_.begin() + 1, steps_.end() - 1, value) - steps_.begin());
    const auto t = float((value - steps_[high - 1]) / (steps_[high] - steps_[high - 1]));
    for (int c = 0; c < channels_; ++c) {
        const std::size_t terms = views_[c].size();
        const float* const low = step_terms_[c].data() + (high - 1) * terms;
        for (std::size_t i = 0; i < terms; ++i) views_[c][i].value = std::lerp(low[i], low[terms + i], t);
    }
}

void MaterialTables::allowNegative() { least_hidden_ = -std::numeric_limits<float>::infinity(); }

ShadeMaterial MaterialTables::view() const {
    ShadeMaterial view{};
    view.view_order = view_order_;
    view.channels = std::size_t(channels_);
    for (int c = 0; c < channels_; ++c) {
        view.views[c] = views_[c].data();
        view.view_terms[c] = views_[c].size();
        view.products[c] = (products_[c].empty() ? products_[0] : products_[c]).data();
    }
    view.rows = rows_.rows.data();
    view.mirrored_rows = rows_.mirrored;
    view.row_count = rows_.rows.size();
    view.albedo_first = albedo_first_;
    view.albedo_terms = albedo_terms_;
    for (int c = 0; c < 3; ++c) view.color[c] = color_[c];
    view.least_hidden = least_hidden_;
    view.is_live = live_.has_value();
    if (live_) view.live = live_->view();
    return view;
}

}  // namespace penumbra
