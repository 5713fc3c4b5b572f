#include "runtime/shade/exact_light_lobes.h"

#include <cmath>
#include <numbers>

#include "sh/sh_basis.h"

namespace penumbra {

namespace {

// Returns the upper half of a spherical Fibonacci set. A direction and its opposite tell the same about a band.
std::vector<Vec3d> hemisphereDirections(int count) {
    std::vector<Vec3d> directions;
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (i + 0.5) / count, r = std::sqrt(1 - z * z);
        const double azimuth = i * std::numbers::pi * (3 - std::sqrt(5.0));
        directions.push_back({r * std::cos(azimuth), r * std::sin(azimuth), z});
    }
    return directions;
}

// Solves G X = B in place by Cholesky, for a symmetric positive definite G [n, n]. B [n, 3] becomes X.
void solvePositive(std::vector<double>& g, std::vector<Vec3d>& b) {
    const std::size_t n = b.size();
    for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t i = j; i < n; ++i) {
            double sum = g[i * n + j];
            for (std::size_t k = 0; k < j; ++k) sum -= g[i * n + k] * g[j * n + k];
            g[i * n + j] = i == j ? std::sqrt(sum) : sum / g[j * n + j];
        }
    }
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < i; ++k) b[i] -= b[k] * g[i * n + k];
        b[i] = b[i] / g[i * n + i];
    }
    for (std::size_t i = n; i-- > 0;) {
        for (std::size_t k = i + 1; k < n; ++k) b[i] -= b[k] * g[k * n + i];
        b[i] = b[i] / g[i * n + i];
    }
}

}  // namespace

LightLobes makeLightLobes(const LightView& light) {
    const int order = light.order, count = 2 * order - 1;
    // 1. Evaluate all bands at the fixed directions.
    const std::vector<Vec3d> directions = hemisphereDirections(count);
    std::vector<std::vector<double>> basis;  // [D][n^2]
    for (const Vec3d& direction : directions)
        evalBasis(order, direction, basis.emplace_back(std::size_t(coefficientCount(order))));

    LightLobes lobes;
    for (const Vec3d& direction : directions) lobes.directions.push_back(toFloat(direction));
    lobes.weights.resize(std::size_t(count) * std::size_t(order));
    // 2. In each band there are more directions than equations, so that many weights would do.
    for (int band = 0; band < order; ++band) {
        // Take the shortest w with Y w = l, Y [2 band + 1, D]: w = Y^T (Y Y^T)^-1 l.
        const std::size_t n = std::size_t(2 * band + 1), first = std::size_t(band) * std::size_t(band);
        std::vector<double> gram(n * n);
        std::vector<Vec3d> x(n);
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t j = 0; j < n; ++j)
                for (const std::vector<double>& y : basis) gram[i * n + j] += y[first + i] * y[first + j];
            x[i] = {light.sh[3 * (first + i)], light.sh[3 * (first + i) + 1], light.sh[3 * (first + i) + 2]};
        }
        solvePositive(gram, x);
        for (std::size_t d = 0; d < basis.size(); ++d) {
            Vec3d w;
            for (std::size_t i = 0; i < n; ++i) w += x[i] * basis[d][first + i];
            lobes.weights[d * std::size_t(order) + std::size_t(band)] = toFloat(w);
        }
    }
    return lobes;
}

}  // namespace penumbra
