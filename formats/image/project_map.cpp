#include "formats/image/project_map.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "formats/image/project_rows.h"
#include "sh/quadrature.h"
#include "sh/sh_rotation.h"

namespace penumbra {

using std::numbers::pi;

std::span<const Vec3> rowOf(const Image& image, int row) {
    return std::span(image.pixels).subspan(std::size_t(row) * std::size_t(image.width), std::size_t(image.width));
}

// --- Lat-long --------------------------------------------------------------------------------------------------------
RowWaves wavesOfRow(int pixels, int order) {
    RowWaves waves;
    const double width = 2 * pi / double(pixels);
    for (int m = 0; m < order; ++m) {
        // The integrals of cos mp and sin mp over a pixel are their values at its center times sin(m width/2) /
        // (m/2).
        const double chord = m == 0 ? width : std::sin(m * width / 2) / (m / 2.0);
        for (int x = 0; x < pixels; ++x) {
            const double p = width * (double(x) + 0.5) - pi;
            waves.cosine[std::size_t(m)].push_back(chord * std::cos(m * p));
            waves.sine[std::size_t(m)].push_back(-chord * std::sin(m * p));
        }
    }
    return waves;
}

namespace {

RowMoments momentsOfRow(std::span<const Vec3> row, int order, const RowWaves& waves) {
    RowMoments moments;
    for (std::size_t m = 0; m < std::size_t(order); ++m) {
        Vec3d cosine, sine;
        for (std::size_t x = 0; x < row.size(); ++x) {
            cosine += toDouble(row[x]) * waves.cosine[m][x];
            sine += toDouble(row[x]) * waves.sine[m][x];
        }
        moments.cosine[m] = cosine;
        moments.sine[m] = sine;
    }
    return moments;
}

// Integrates y(l, m >= 0; azimuth 0) sin t dt over [t0, t1] by 8 Gauss nodes in t. This is exact to rounding for rows
// of up to 45 degrees (a picture of 4 rows) at every order.
std::vector<double> rowIntegrals(double t0, double t1, int order) {
    static const std::vector<WeightedDirection> nodes = gaussSphere(8, 1);
    std::vector<double> sum(std::size_t(coefficientCount(order))), y(sum.size());
    for (const auto& [node, weight] : nodes) {
        const double t = (t0 + t1) / 2 + node.z * (t1 - t0) / 2;
        evalBasis(order, Vec3d{std::sin(t), 0, std::cos(t)}, y);
        const double w = weight / (2 * pi) * (t1 - t0) / 2 * std::sin(t);
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += w * y[i];
    }
    return sum;
}

}  // namespace

void addRowMoments(const RowMoments& moments, double t0, double t1, int order, PartialProjection& sum) {
    const std::vector<double> integrals = rowIntegrals(t0, t1, order);
    for (int l = 0; l < order; ++l)
        for (int m = 0; m <= l; ++m) {
            const double integral = integrals[std::size_t(shIndex(l, m))];
            sum.sh[std::size_t(shIndex(l, m))] += moments.cosine[std::size_t(m)] * integral;
            if (m > 0) sum.sh[std::size_t(shIndex(l, -m))] += moments.sine[std::size_t(m)] * integral;
        }
}

namespace {

void projectLatLongRow(const Image& image, int row, int order, const RowWaves& waves, PartialProjection& sum) {
    const double t0 = pi * row / image.height, t1 = pi * (row + 1) / image.height;
    const double solid_angle = 2 * pi / image.width * (std::cos(t0) - std::cos(t1));
    for (Vec3 p : rowOf(image, row)) sum.energy += solid_angle * dot(toDouble(p), toDouble(p));
    addRowMoments(momentsOfRow(rowOf(image, row), order, waves), t0, t1, order, sum);
}

// --- Cubes -----------------------------------------------------------------------------------------------------------

// Returns how many Gauss nodes along a side of a texel leave less than 1e-8 of band 7 of a uniform cube (the tests
// measure it).
int nodesOfTexel(int size) { return size < 8 ? 10 : size < 64 ? 5 : size < 256 ? 3 : 2; }

struct TexelRule {
    std::vector<double> at, weight;  // both in (0, 1); the weights sum to 1
};

TexelRule texelRule(int size) {
    TexelRule rule;
    for (const auto& [node, weight] : gaussSphere(nodesOfTexel(size), 1)) {
        rule.at.push_back((node.z + 1) / 2);
        rule.weight.push_back(weight / (4 * pi));
    }
    return rule;
}

// Integrates the basis over one texel of a face by Gauss nodes, whose weights add up to the exact solid angle.
void integrateTexel(const CubeFace& face, const TexelRule& rule, double s0, double t0, double step, int order,
                    std::span<double> integral) {
    std::array<double, coefficientCount(kMaxOrder)> y;
    const auto basis = std::span(y).first(integral.size());
    std::fill(integral.begin(), integral.end(), 0.0);
    double total = 0;
    for (std::size_t j = 0; j < rule.at.size(); ++j)
        for (std::size_t i = 0; i < rule.at.size(); ++i) {
            const Vec3d d = face.forward + (s0 + rule.at[i] * step) * face.right + (t0 + rule.at[j] * step) * face.down;
            const double square = dot(d, d), weight = rule.weight[i] * rule.weight[j] / (square * std::sqrt(square));
            evalBasis(order, d / std::sqrt(square), basis);
            for (std::size_t k = 0; k < integral.size(); ++k) integral[k] += weight * basis[k];
            total += weight;
        }
    const double solid_angle = cubeSolidAngle(s0, s0 + step, t0, t0 + step);
    for (double& value : integral) value *= solid_angle / total;
}

void projectCubeRow(const EnvironmentMap& map, int row, int order, PartialProjection& sum) {
    const int size = map.image.width / (map.layout == MapLayout::kVerticalCross ? 3 : 4);
    const double step = 2.0 / size;
    const TexelRule rule = texelRule(size);
    std::array<double, coefficientCount(kMaxOrder)> values;
    const auto integral = std::span(values).first(std::size_t(coefficientCount(order)));
    for (const CubeFace& face : cubeFaces(map.layout)) {
        if (row / size != face.row) continue;
        const double t0 = (row % size) * step - 1;
        for (int x = 0; x < size; ++x) {
            const Vec3d p = toDouble(rowOf(map.image, row)[std::size_t(face.column * size + x)]);
            const double s0 = x * step - 1;
            integrateTexel(face, rule, s0, t0, step, order, integral);
            for (std::size_t k = 0; k < integral.size(); ++k) sum.sh[k] += p * integral[k];
            sum.energy += dot(p, p) * cubeSolidAngle(s0, s0 + step, t0, t0 + step);
        }
    }
}

// --- All layouts -----------------------------------------------------------------------------------------------------

// Returns the rotation from the frame that a layout is projected in to the model frame. Lat-long: (x', y', z') -> (x,
// z, -y), where y' is the pole's side. Discs: (x', y', z') -> (-z, y, x).
Mat3d toModelFrame(MapLayout layout) {
    if (layout == MapLayout::kLatLong) return {{1, 0, 0, 0, 0, 1, 0, -1, 0}};
    if (layout == MapLayout::kAngular || layout == MapLayout::kBall) return {{0, 0, 1, 0, 1, 0, -1, 0, 0}};
    return {};
}

// Tables that all rows of a picture share.
struct RowTables {
    RowWaves waves;  // for lat-long pictures
    DiscBasis disc;  // for discs
};

RowTables tablesOf(const EnvironmentMap& map, int order) {
    RowTables tables;
    if (map.layout == MapLayout::kLatLong) tables.waves = wavesOfRow(map.image.width, order);
    tables.disc = makeDiscBasis(order);
    return tables;
}

void projectRow(const EnvironmentMap& map, int row, int order, const RowTables& tables, PartialProjection& sum) {
    if (map.layout == MapLayout::kLatLong)
        projectLatLongRow(map.image, row, order, tables.waves, sum);
    else if (map.layout == MapLayout::kAngular || map.layout == MapLayout::kBall)
        projectDiscRow(map, row, tables.disc, sum);
    else
        projectCubeRow(map, row, order, sum);
}

}  // namespace

MapProjection joinProjections(std::span<const PartialProjection> parts, MapLayout layout, int order) {
    MapProjection projection;
    const auto count = std::size_t(coefficientCount(order));
    const ShRotationD to_model = makeShRotation(order, toModelFrame(layout));
    projection.sh.resize(3 * count);
    for (const PartialProjection& part : parts) projection.energy += part.energy;
    std::vector<double> in(count), out(count);
    for (int channel = 0; channel < 3; ++channel) {
        std::fill(in.begin(), in.end(), 0.0);
        for (const PartialProjection& part : parts)
            for (std::size_t i = 0; i < count; ++i) in[i] += part.sh[i][channel];
        apply(to_model, in, out);
        for (std::size_t i = 0; i < count; ++i) projection.sh[3 * i + std::size_t(channel)] = out[i];
    }
    return projection;
}

MapProjection projectMap(const EnvironmentMap& map, int order, int threads) {
    assert(order >= 1 && order <= kMaxOrder);
    constexpr int kRowsPerTask = 8;
    const int rows = rowCount(map);
    const RowTables tables = tablesOf(map, order);
    std::vector<PartialProjection> parts(std::size_t((rows + kRowsPerTask - 1) / kRowsPerTask));
    parallelFor(parts.size(), threads, [&](std::size_t task) {
        throwIfInterrupted();
        const int begin = int(task) * kRowsPerTask;
        for (int row = begin; row < std::min(rows, begin + kRowsPerTask); ++row)
            projectRow(map, row, order, tables, parts[task]);
    });
    return joinProjections(parts, map.layout, order);
}

}  // namespace penumbra
