#include "sh/cast/repeated_product.h"

#include <mutex>

#include "sh/sh_product.h"

namespace penumbra {

namespace {

template <class T>
BasicRepeatedProduct<T> makeRepeatedProduct(int order) {
    BasicRepeatedProduct<T> product;
    product.order = order;
    const int n = coefficientCount(order);
    for (const TripleProductEntry& e : tripleProduct(order, order, order)) {  // sorted by i
        if (e.j <= e.k) {
            const int before = e.j * n - e.j * (e.j - 1) / 2;  // pairs of a smaller j
            product.terms.push_back({std::uint16_t(before + e.k - e.j), T(e.value)});
        }
        product.first[std::size_t(e.i) + 1] = std::uint16_t(product.terms.size());
    }
    return product;
}

}  // namespace

template <class T>
const BasicRepeatedProduct<T>& repeatedProduct(int order) {
    assert(order >= 1 && order <= kMaxRepeatedOrder);
    static std::array<std::once_flag, kMaxRepeatedOrder + 1> made;
    static std::array<BasicRepeatedProduct<T>, kMaxRepeatedOrder + 1> products;
    const std::size_t n = std::size_t(order);
    std::call_once(made[n], [&] { products[n] = makeRepeatedProduct<T>(order); });
    return products[n];
}

template const BasicRepeatedProduct<float>& repeatedProduct(int order);
template const BasicRepeatedProduct<double>& repeatedProduct(int order);

}  // namespace penumbra
