#include "sh/brdf/reflection_operator.h"

#include <array>
#include <cassert>

#include "sh/sh_product.h"

namespace penumbra {

std::vector<double> reflectionOperator(int light_order, const Convention& convention, std::span<const double> u) {
    assert(!u.empty());
    const int order_u = bandOfIndex(int(u.size()) - 1) + 1;
    assert(int(u.size()) == coefficientCount(order_u));
    const std::vector<int> indices = convention.indices();
    std::array<int, coefficientCount(kMaxOrder)> column;
    column.fill(-1);
    for (std::size_t j = 0; j < indices.size(); ++j) column[std::size_t(indices[j])] = int(j);
    std::vector<double> m(std::size_t(coefficientCount(light_order)) * indices.size());
    for (const TripleProductEntry& e : tripleProduct(light_order, convention.order, order_u))
        if (column[e.j] >= 0) m[e.i * indices.size() + std::size_t(column[e.j])] += u[e.k] * e.value;
    return m;
}

std::vector<float> reflectionOperator(int light_order, const Convention& convention, std::span<const float> u) {
    const std::vector<double> m = reflectionOperator(light_order, convention, std::vector<double>(u.begin(), u.end()));
    return {m.begin(), m.end()};
}

}  // namespace penumbra
