#include "sh/mirrored_product.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <tuple>
#include <utility>
#include <vector>

#include "sh/mutex.h"
#include "sh/quadrature.h"
#include "sh/reflectance.h"
#include "sh/sh_product.h"

namespace penumbra {

namespace {

// One term of the mirror: out_even += value * in_index.
struct MirrorTerm {
    std::uint16_t even, index;
    float value;
};

// An even and an odd function meet only where m is the same; two even ones are orthogonal on a hemisphere.
std::vector<MirrorTerm> makeMirrorTerms(int order) {
    const std::vector<int> even = evenIndices(order);
    // The integrand has degree 2 order - 2 in x, y and z.
    const std::vector<WeightedDirection> nodes = gaussHemisphere(2 * order + 1, 4 * order + 1);
    std::vector<double> gram(std::size_t(coefficientCount(order) * coefficientCount(order)));
    std::vector<double> y(std::size_t(coefficientCount(order)));
    for (const WeightedDirection& node : nodes) {
        evalBasis(order, node.direction, y);
        for (int i : even)
            for (std::size_t j = 0; j < y.size(); ++j)
                gram[std::size_t(i) * y.size() + j] += 2 * node.weight * y[std::size_t(i)] * y[j];
    }
    std::vector<MirrorTerm> terms;
    for (std::size_t e = 0; e < even.size(); ++e)
        for (std::size_t j = 0; j < y.size(); ++j)
            if (const double value = gram[std::size_t(even[e]) * y.size() + j]; std::abs(value) > 1e-9)
                terms.push_back({std::uint16_t(e), std::uint16_t(j), float(value)});
    return terms;
}

// One term of a product: out_i += value a_j b_k.
struct EvenTerm {
    std::uint16_t i, j, k;
    float value;
};

std::vector<EvenTerm> makeEvenTerms(int order_out, int order_a, int order_b) {
    const auto places = [](int order) {
        std::map<int, std::uint16_t> place;
        for (int i : evenIndices(order)) place.emplace(i, std::uint16_t(place.size()));
        return place;
    };
    const std::map<int, std::uint16_t> out = places(order_out), a = places(order_a), b = places(order_b);
    std::vector<EvenTerm> terms;
    for (const TripleProductEntry& e : tripleProduct(order_out, order_a, order_b))
        if (out.contains(e.i) && a.contains(e.j) && b.contains(e.k))
            terms.push_back({out.at(e.i), a.at(e.j), b.at(e.k), float(e.value)});
    return terms;
}

}  // namespace

void mirrorAtHorizon(int order, std::span<const float> coefficients, std::span<float> out) {
    assert(order >= 1 && order <= kMaxOrder && int(coefficients.size()) == coefficientCount(order) &&
           int(out.size()) == mirroredCount(order));
    static const std::array<std::vector<MirrorTerm>, kMaxOrder + 1> tables = [] {
        std::array<std::vector<MirrorTerm>, kMaxOrder + 1> all;
        for (int n = 1; n <= kMaxOrder; ++n) all[std::size_t(n)] = makeMirrorTerms(n);
        return all;
    }();
    std::fill(out.begin(), out.end(), 0.0f);
    for (const MirrorTerm& term : tables[std::size_t(order)]) out[term.even] += term.value * coefficients[term.index];
}

namespace {

const std::vector<EvenTerm>& evenTerms(int order_out, int order_a, int order_b) {
    static Mutex mutex;
    static std::array<std::unique_ptr<std::vector<EvenTerm>>, (kMaxOrder + 1) * (kMaxOrder + 1) * (kMaxOrder + 1)>
        cache;
    const std::lock_guard lock(mutex);
    auto& slot = cache[std::size_t((order_out * (kMaxOrder + 1) + order_a) * (kMaxOrder + 1) + order_b)];
    if (!slot) slot = std::make_unique<std::vector<EvenTerm>>(makeEvenTerms(order_out, order_a, order_b));
    return *slot;
}

}  // namespace

void multiplyMirrored(int order_out, std::span<const float> a, int order_a, std::span<const float> b, int order_b,
                      std::span<float> out) {
    assert(int(a.size()) == mirroredCount(order_a) && int(b.size()) == mirroredCount(order_b) &&
           int(out.size()) == mirroredCount(order_out));
    std::fill(out.begin(), out.end(), 0.0f);
    for (const EvenTerm& term : evenTerms(order_out, order_a, order_b))
        out[term.i] += term.value * a[term.j] * b[term.k];
}

}  // namespace penumbra
