#include "sh/cast/cast_visibility.h"

#include <cassert>

namespace penumbra {

static_assert(sizeof(CasterSphere) == 4 * sizeof(float) && sizeof(CapLogTable{}.rows[0]) == 8 * sizeof(float),
              "the kernel reads them as floats");

void castVisibility(int order, std::span<const CasterSphere> spheres, std::span<const Vec3> positions,
                    std::span<float> out, const CastPath& path) {
    assert(out.size() == positions.size() * std::size_t(coefficientCount(order)));
    const BasicRepeatedProduct<float>& product = repeatedProduct<float>(order);
    const CastTables tables = {order, capLogTable(order).rows[0].data(), product.terms.data(), product.first.data()};
    const auto* floats = reinterpret_cast<const float*>(spheres.data());
    path.visibility(tables, {floats, spheres.size(), positions.data(), positions.size()}, out.data());
}

}  // namespace penumbra
