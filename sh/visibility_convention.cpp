#include "sh/visibility_convention.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sh/reflectance.h"
#include "sh/zonal.h"

namespace penumbra {

int Convention::size() const {
    return below == BelowHorizon::kMirrored ? order * (order + 1) / 2 : coefficientCount(order);
}

std::vector<int> Convention::indices() const {
    if (below == BelowHorizon::kMirrored) return evenIndices(order);
    std::vector<int> all(coefficientCount(order));
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = int(i);
    return all;
}

std::string Convention::name() const { return char(below) + std::to_string(order); }

Convention parseConvention(std::string_view name) {
    const bool known = name.size() == 2 && (name[0] == 'A' || name[0] == 'B' || name[0] == 'D') && name[1] >= '1' &&
                       name[1] <= '0' + kMaxOrder;
    if (!known)
        throw std::invalid_argument("convention must be A, B or D and an order from 1 to " + std::to_string(kMaxOrder) +
                                    " (such as D5), not '" + std::string(name) + "'");
    return {BelowHorizon(name[0]), name[1] - '0'};
}

void fromMoments(const Convention& convention, std::span<const float> local_moments, std::span<float> out) {
    assert(int(local_moments.size()) >= coefficientCount(convention.order) && int(out.size()) == convention.size());
    if (convention.below == BelowHorizon::kMirrored) {
        std::size_t e = 0;
        for (int l = 0; l < convention.order; ++l)
            for (int m = -l; m <= l; m += 2) out[e++] = 2 * local_moments[shIndex(l, m)];
        return;
    }
    std::copy_n(local_moments.begin(), out.size(), out.begin());
    if (convention.below == BelowHorizon::kBlocked) return;
    std::array<double, kMaxOrder> delta;
    belowPlaneZonal(0, std::span(delta).first(convention.order));
    for (int l = 0; l < convention.order; ++l) out[shIndex(l, 0)] += float(delta[l]);
}

void fullCoefficients(const Convention& convention, std::span<const float> coefficients, std::span<float> out) {
    assert(int(coefficients.size()) == convention.size() && int(out.size()) == coefficientCount(convention.order));
    if (convention.below != BelowHorizon::kMirrored) {
        std::copy(coefficients.begin(), coefficients.end(), out.begin());
        return;
    }
    std::fill(out.begin(), out.end(), 0.0f);
    std::size_t e = 0;
    for (int l = 0; l < convention.order; ++l)
        for (int m = -l; m <= l; m += 2) out[shIndex(l, m)] = coefficients[e++];
}

void belowHorizonCoefficients(int order, std::span<double> out) {
    assert(order >= 1 && order <= kMaxProductOrder && int(out.size()) == coefficientCount(order));
    std::array<double, kMaxProductOrder> zonal;
    belowPlaneZonal(0, std::span(zonal).first(order));
    std::fill(out.begin(), out.end(), 0.0);
    for (int l = 0; l < order; ++l) out[shIndex(l, 0)] = zonal[l];
}

double binaryEnergy(const Convention& convention, double moment0) {
    const double above = std::sqrt(4 * std::numbers::pi) * moment0;
    switch (convention.below) {
        case BelowHorizon::kOpen:
            return above + 2 * std::numbers::pi;
        case BelowHorizon::kBlocked:
            return above;
        case BelowHorizon::kMirrored:
            return 2 * above;
    }
    return above;
}

// A takes the projected clamped cosine. D takes half of |cos|, which has the even bands of the clamped cosine and no
// odd ones. B takes cos itself, because V is 0 below the horizon; cos is in band 1, so this is exact. (Order 1 has no
// band 1 and takes the mean of V.)
void ambientWeights(const Convention& convention, std::span<float> w) {
    assert(int(w.size()) == convention.size());
    std::fill(w.begin(), w.end(), 0.0f);
    if (convention.below == BelowHorizon::kBlocked) {
        if (convention.order == 1)
            w[0] = float(1 / std::sqrt(std::numbers::pi));
        else
            w[shIndex(1, 0)] = float(2 / std::sqrt(3 * std::numbers::pi));
        return;
    }
    std::array<double, kMaxOrder> cosine;
    clampedCosineZonal(std::span(cosine).first(convention.order));
    std::size_t i = 0;  // counts as indices() does, but without an allocation, because this runs for every frame
    for (int band = 0; band < convention.order; ++band)
        for (int m = -band; m <= band; ++m) {
            if (convention.below == BelowHorizon::kMirrored && (band + m) % 2 != 0) continue;
            if (m == 0) w[i] = float(cosine[band] / std::numbers::pi);
            ++i;
        }
}

}  // namespace penumbra
