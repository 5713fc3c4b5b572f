#include "sh/hemisphere_norm.h"

#include <cmath>

#include "sh/quadrature.h"
#include "sh/sh_basis.h"
#include "sh/sh_rotation.h"

namespace penumbra {

namespace {

// Returns a rotation that takes +z to the normal. Which one makes no difference, because H is symmetric about z.
Mat3d frameOf(Vec3d normal) {
    const Vec3d axis = std::abs(normal.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0};
    const Vec3d t = normalized(cross(axis, normal)), b = cross(normal, t);
    return {{t.x, b.x, normal.x, t.y, b.y, normal.y, t.z, b.z, normal.z}};
}

}  // namespace

HemisphereNorm::HemisphereNorm(int order) : order_(order) {
    const int n = coefficientCount(order);
    std::vector<double> h(std::size_t(n * n)), y(static_cast<std::size_t>(n));
    for (const WeightedDirection& sample : gaussHemisphere(2 * order, 4 * order)) {
        evalBasis(order, sample.direction, std::span(y));
        for (int i = 0; i < n; ++i)
            for (int j = i; j < n; ++j)
                h[std::size_t(i * n + j)] += sample.weight * y[std::size_t(i)] * y[std::size_t(j)];
    }
    for (int i = 0; i < n; ++i)
        for (int j = i; j < n; ++j) {
            const double value = h[std::size_t(i * n + j)];
            if (std::abs(value) > 1e-12) entries_.push_back({i, j, i == j ? value : 2 * value});
        }
}

double HemisphereNorm::ofLocal(std::span<const double> local) const {
    double sum = 0;
    for (const Entry& entry : entries_) sum += entry.value * local[std::size_t(entry.i)] * local[std::size_t(entry.j)];
    return sum;
}

std::array<double, 2> HemisphereNorm::squared(std::span<const double> a, std::span<const double> b, Vec3 normal) const {
    if (normal == Vec3{}) return {0, 0};
    const ShRotationD rotation = makeShRotation(order_, frameOf(normalized(toDouble(normal))));
    std::array<double, coefficientCount(kMaxOrder)> values;
    const std::span<double> local = std::span(values).first(a.size());
    applyTransposed(rotation, a, local);
    const double of_a = ofLocal(local);
    applyTransposed(rotation, b, local);
    return {of_a, ofLocal(local)};
}

}  // namespace penumbra
