#include "formats/image/project_disc.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <vector>

#include "sh/quadrature.h"

namespace penumbra {

using std::numbers::pi;

using Sums = std::array<double, coefficientCount(kMaxOrder)>;  // at shIndex(l, +-m)

DiscBasis makeDiscBasis(int order) {
    DiscBasis basis;
    basis.order = order;
    std::vector<double> equator(std::size_t(coefficientCount(order)));
    evalBasis(order, Vec3d{1, 0, 0}, equator);
    for (int m = 0; m < order; ++m) {
        basis.start[std::size_t(m)] = equator[std::size_t(shIndex(m, m))];
        // The ratio of the normalisations of bands l + 1 and l.
        const auto ratio = [m](int l) {
            return std::sqrt((2 * l + 3.0) * (l + 1 - m) / ((2 * l + 1.0) * (l + 1 + m)));
        };
        for (int l = m; l + 1 < order; ++l) {
            const double divisor = double(l - m + 1) * (l + 2);
            basis.from_basis[std::size_t(l)][std::size_t(m)] = (2 * l + 1) / divisor * ratio(l);
            if (l > m)
                basis.from_before[std::size_t(l)][std::size_t(m)] =
                    double(l - 1) * (l + m) / divisor * ratio(l) * ratio(l - 1);
        }
    }
    integrateBasis(basis, pi, basis.whole);
    return basis;
}

void integrateBasis(const DiscBasis& basis, double polar, std::span<double> out) {
    const double sine = std::sin(polar), cosine = std::cos(polar);
    Sums y;
    evalBasis(basis.order, Vec3d{sine, 0, cosine}, std::span(y).first(std::size_t(coefficientCount(basis.order))));
    // S_k is the integral of sin^k from 0: S_0 = t, S_1 = 1 - cos t, S_k = ((k-1) S_k-2 - cos t sin^(k-1) t) / k.
    std::array<double, kMaxOrder + 1> power_integral{polar, 2 * std::sin(polar / 2) * std::sin(polar / 2)};
    double power = sine;
    for (std::size_t k = 2; k <= std::size_t(basis.order); ++k, power *= sine)
        power_integral[k] = (double(k - 1) * power_integral[k - 2] - cosine * power) / double(k);
    for (int m = 0; m < basis.order; ++m) {
        out[std::size_t(shIndex(m, m))] = basis.start[std::size_t(m)] * power_integral[std::size_t(m + 1)];
        for (int l = m; l + 1 < basis.order; ++l) {
            const double before = l > m ? out[std::size_t(shIndex(l - 1, m))] : 0;
            out[std::size_t(shIndex(l + 1, m))] =
                basis.from_basis[std::size_t(l)][std::size_t(m)] * sine * sine * y[std::size_t(shIndex(l, m))] +
                basis.from_before[std::size_t(l)][std::size_t(m)] * before;
        }
    }
}

namespace {

struct DiscPoint {
    double u, v;
};

double radiusOf(DiscPoint p) { return std::hypot(p.u, p.v); }
DiscPoint between(DiscPoint a, DiscPoint b, double t) { return {a.u + (b.u - a.u) * t, a.v + (b.v - a.v) * t}; }

// Adds a border outside of the disc. I is constant there, so its integral is that of {cos, sin}(mq).
void addOutside(const DiscBasis& basis, DiscPoint a, DiscPoint b, Sums& sum) {
    const double qa = std::atan2(a.v, a.u), turn = std::atan2(a.u * b.v - a.v * b.u, a.u * b.u + a.v * b.v);
    const double qb = std::atan2(b.v, b.u);
    sum[0] += basis.whole[0] * turn;  // I_l0(pi) = 0 for other l
    for (int m = 1; m < basis.order; ++m) {
        const double cosine = (std::sin(m * qb) - std::sin(m * qa)) / m,
                     sine = (std::cos(m * qa) - std::cos(m * qb)) / m;
        for (int l = m; l < basis.order; ++l) {
            const double whole = basis.whole[std::size_t(shIndex(l, m))];
            sum[std::size_t(shIndex(l, m))] += whole * cosine;
            sum[std::size_t(shIndex(l, -m))] += whole * sine;
        }
    }
}

void addInside(const DiscBasis& basis, MapLayout layout, std::span<const WeightedDirection> nodes, DiscPoint a,
               DiscPoint b, Sums& sum) {
    const double area = a.u * b.v - a.v * b.u;  // r^2 dq per unit of the parameter, which is the same all along
    if (area == 0) return;                      // towards the center: the azimuth stays
    Sums integral;
    for (const auto& [node, weight] : nodes) {
        const DiscPoint p = between(a, b, (node.z + 1) / 2);
        const double square = p.u * p.u + p.v * p.v, r = std::sqrt(square);
        integrateBasis(basis, layout == MapLayout::kAngular ? pi * r : 2 * std::asin(std::min(1.0, r)), integral);
        const double w = weight / (4 * pi) * area / square, c1 = p.u / r, s1 = p.v / r;
        double cosine = w, sine = 0;  // w cos mq, w sin mq
        for (int m = 0; m < basis.order; ++m) {
            for (int l = m; l < basis.order; ++l) {
                sum[std::size_t(shIndex(l, m))] += integral[std::size_t(shIndex(l, m))] * cosine;
                if (m > 0) sum[std::size_t(shIndex(l, -m))] += integral[std::size_t(shIndex(l, m))] * sine;
            }
            const double next = cosine * c1 - sine * s1;
            sine = cosine * s1 + sine * c1;
            cosine = next;
        }
    }
}

// Finds where a border crosses the rim: |a + t (b - a)| = 1, t in (0, 1), ascending.
int crossings(DiscPoint a, DiscPoint b, double t[2]) {
    const double du = b.u - a.u, dv = b.v - a.v, aa = du * du + dv * dv, ab = a.u * du + a.v * dv,
                 c = a.u * a.u + a.v * a.v - 1, discriminant = ab * ab - aa * c;
    if (discriminant <= 0) return 0;
    int count = 0;
    for (double root : {(-ab - std::sqrt(discriminant)) / aa, (-ab + std::sqrt(discriminant)) / aa})
        if (root > 0 && root < 1) t[count++] = root;
    return count;
}

struct DiscGrid {
    const EnvironmentMap& map;
    const DiscBasis& basis;
    std::vector<WeightedDirection> nodes;
    int size;

    // Grid lines and pixels count along u' and downwards.
    DiscPoint corner(int i, int j) const { return {2.0 * i / size - 1, 1 - 2.0 * j / size}; }
    Vec3d pixel(int i, int j) const {
        if (i < 0 || j < 0 || i >= size || j >= size) return {};
        const double u = std::max(0.0, std::abs(2.0 * i + 1 - size) - 1),
                     v = std::max(0.0, std::abs(2.0 * j + 1 - size) - 1);
        if (u * u + v * v >= double(size) * size) return {};  // the pixel's nearest corner is outside of the disc
        const int column = map.layout == MapLayout::kAngular ? size - 1 - i : i;
        return toDouble(map.image.pixels[std::size_t(j) * std::size_t(size) + std::size_t(column)]);
    }
};

// Adds the integral along the border from a to b, times the pixel on its left minus the pixel on its right.
void addBorder(const DiscGrid& grid, DiscPoint a, DiscPoint b, Vec3d left, Vec3d right, PartialProjection& total) {
    const Vec3d step = left - right;
    const double energy = dot(left, left) - dot(right, right);
    if (step == Vec3d{} && energy == 0) return;
    Sums sum{};
    double t[4] = {0};
    const int count = crossings(a, b, t + 1);
    t[count + 1] = 1;
    for (int i = 0; i <= count; ++i) {
        const DiscPoint from = between(a, b, t[i]), to = between(a, b, t[i + 1]);
        if (radiusOf(between(from, to, 0.5)) >= 1)
            addOutside(grid.basis, from, to, sum);
        else
            addInside(grid.basis, grid.map.layout, grid.nodes, from, to, sum);
    }
    for (std::size_t k = 0; k < std::size_t(coefficientCount(grid.basis.order)); ++k) total.sh[k] += step * sum[k];
    total.energy += energy * sum[0] * std::sqrt(4 * pi);  // divided by y_0: the solid angle
}

}  // namespace

int rowCount(const EnvironmentMap& map) {
    const bool disc = map.layout == MapLayout::kAngular || map.layout == MapLayout::kBall;
    return map.image.height + (disc ? 1 : 0);
}

void projectDiscRow(const EnvironmentMap& map, int row, const DiscBasis& basis, PartialProjection& sum) {
    const int size = map.image.width;
    const DiscGrid grid{map, basis, gaussSphere(size < 32 ? 8 : size < 256 ? 4 : size < 1024 ? 3 : 2, 1), size};
    for (int i = 0; i < size; ++i)  // rightwards: the pixel above is on the left
        addBorder(grid, grid.corner(i, row), grid.corner(i + 1, row), grid.pixel(i, row - 1), grid.pixel(i, row), sum);
    for (int i = 0; i <= size && row < size; ++i)  // upwards
        addBorder(grid, grid.corner(i, row + 1), grid.corner(i, row), grid.pixel(i - 1, row), grid.pixel(i, row), sum);
}

}  // namespace penumbra
