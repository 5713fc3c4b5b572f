#include "sh/cosine_product.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sh/quadrature.h"
#include "sh/sh_basis.h"
#include "sh/sh_product.h"

namespace penumbra {

CosineProduct::CosineProduct(int order) {
    // x, y and z are the functions of band 1 over sqrt(3 / 4 pi), in the order -y, z, -x.
    const double scale = std::sqrt(4 * std::numbers::pi / 3);
    std::array<std::vector<double>, 3> axes;
    for (int axis = 0; axis < 3; ++axis) {
        std::array<double, 4> u{};
        u[axis == 0 ? 3 : axis == 1 ? 1 : 2] = axis == 2 ? scale : -scale;
        axes[std::size_t(axis)] = productMatrix(order + 1, u, 2);
    }
    const int rows = coefficientCount(order), columns = coefficientCount(order + 1);
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) {
            const auto at = std::size_t(i * columns + j);
            const Vec3 value{float(axes[0][at]), float(axes[1][at]), float(axes[2][at])};
            if (value.x != 0 || value.y != 0 || value.z != 0)
                entries_.push_back({std::uint16_t(i), std::uint16_t(j), value});
        }
}

void CosineProduct::apply(std::span<const float> moments, Vec3 normal, std::span<float> transfer) const {
    std::fill(transfer.begin(), transfer.end(), 0.0f);
    for (const Entry& entry : entries_) transfer[entry.i] += dot(entry.value, normal) * moments[entry.j];
}

std::vector<double> cosineMatrix(int rows, int columns) {
    const auto n = std::size_t(coefficientCount(rows)), m = std::size_t(coefficientCount(columns));
    const int order = std::max(rows, columns);
    std::vector<double> matrix(n * m), y(std::size_t(coefficientCount(order)));
    for (const WeightedDirection& sample : gaussHemisphere(2 * order + 1, 4 * order + 2)) {
        evalBasis(order, sample.direction, std::span(y));
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j < m; ++j) matrix[i * m + j] += sample.weight * sample.direction.z * y[i] * y[j];
    }
    return matrix;
}

}  // namespace penumbra
