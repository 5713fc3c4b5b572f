#include "sh/cast/cast_visibility.h"

#include <cassert>

#include "sh/far/far_tables.h"

namespace penumbra {

static_assert(sizeof(CasterSphere) == 4 * sizeof(float) && sizeof(CapLogTable{}.rows[0]) == 8 * sizeof(float),
              "the kernel reads them as floats");
static_assert(kMirroredCast == kFarCoefficients);

namespace {

CastTables tablesOf(int order) {
    const BasicRepeatedProduct<float>& product = repeatedProduct<float>(order);
    return {order, capLogTable(order).rows[0].data(), product.terms.data(), product.first.data(),
            &productConstants(kFieldOrder)};
}

const float* floatsOf(std::span<const CasterSphere> spheres) { return reinterpret_cast<const float*>(spheres.data()); }

}  // namespace

void castVisibility(int order, std::span<const CasterSphere> spheres, std::span<const Vec3> positions,
                    std::span<float> out, const CastPath& path) {
    assert(out.size() == positions.size() * std::size_t(coefficientCount(order)));
    path.visibility(tablesOf(order),
                    {floatsOf(spheres), spheres.size(), positions.data(), positions.size(), nullptr, nullptr, 0, 0},
                    out.data());
}

void castMirrored(std::span<const CasterSphere> spheres, const CastPoints& points, const CastFade& fade,
                  std::span<float> out, const CastPath& path) {
    castMirrored(spheres, {}, points, fade, out, path);
}

void castMirrored(std::span<const CasterSphere> spheres, const FarAnchors& anchors, const CastPoints& points,
                  const CastFade& fade, std::span<float> out, const CastPath& path) {
    const std::size_t count = points.positions.size();
    assert(out.size() == count * kMirroredCast && points.normals.size() == count && points.tangents.size() == count);
    assert(!anchors.values || spheres.size() <= kMaxNearParts);
    path.visibility(tablesOf(kCastOrder),
                    {floatsOf(spheres), spheres.size(), points.positions.data(), count, points.normals.data(),
                     points.tangents.data(), fade.least, fade.full, 0, anchors},
                    out.data());
}

void castAnchors(std::span<const CasterSphere> spheres, std::span<const Vec3> positions, float spacing,
                 const CastFade& fade, std::span<float> out, const CastPath& path) {
    assert(out.size() == positions.size() * anchorStride(spheres.size()));
    path.anchors(tablesOf(kCastOrder),
                 {floatsOf(spheres), spheres.size(), positions.data(), positions.size(), nullptr, nullptr, fade.least,
                  fade.full, spacing},
                 out.data());
}

}  // namespace penumbra
