// SPDX-License-Identifier: Apache-2.0
#include "player/runtime/shading.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "sh/reflectance.h"
#include "sh/sh_product.h"
#include "sh/sh_rotation.h"

namespace penumbra {

// Normalised associated Legendre recurrences in z, divided by sin^m, with the Condon-Shortley sign and the factor
// sqrt 2 of real harmonics in the start value.
static void basisRecurrence(std::vector<float>& a, std::vector<float>& b) {
    a.assign(kMaxOrder * kMaxOrder, 0);
    b.assign(kMaxOrder * kMaxOrder, 0);
    double start = std::sqrt(1 / (4 * std::numbers::pi));
    for (int m = 0; m < kMaxOrder; ++m) {
        if (m > 0) start *= -std::sqrt((2 * m + 1) / (2.0 * m));
        a[std::size_t(m * kMaxOrder + m)] = float(m > 0 ? std::numbers::sqrt2 * start : start);
        for (int l = m + 1; l < kMaxOrder; ++l) {
            const double scale = std::sqrt((4.0 * l * l - 1) / (double(l) * l - m * m));
            const double previous = std::sqrt(((l - 1.0) * (l - 1) - m * m) / (4.0 * (l - 1) * (l - 1) - 1));
            a[std::size_t(l * kMaxOrder + m)] = float(scale);
            b[std::size_t(l * kMaxOrder + m)] = float(scale * previous);
        }
    }
}

// 2n-1 axes, a Fibonacci set over half the sphere: together they span every band below n (a light of order 8 comes back
// to 3e-6 in single precision).
static std::vector<Vec3> lobeAxes(int order) {
    const int count = 2 * order - 1;
    std::vector<Vec3> axes;
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (i + 0.5) / count, r = std::sqrt(1 - z * z);
        const double azimuth = i * std::numbers::pi * (3 - std::sqrt(5.0));
        axes.push_back({float(r * std::cos(azimuth)), float(r * std::sin(azimuth)), float(z)});
    }
    return axes;
}

// x = A^-1 b in place, A symmetric positive definite [n, n]; b has `columns` columns. Gauss without pivoting.
static void solveInPlace(std::vector<double>& a, std::vector<double>& b, int n, int columns) {
    for (int p = 0; p < n; ++p)
        for (int r = 0; r < n; ++r) {
            if (r == p) continue;
            const double factor = a[std::size_t(r * n + p)] / a[std::size_t(p * n + p)];
            for (int c = p; c < n; ++c) a[std::size_t(r * n + c)] -= factor * a[std::size_t(p * n + c)];
            for (int c = 0; c < columns; ++c)
                b[std::size_t(r * columns + c)] -= factor * b[std::size_t(p * columns + c)];
        }
    for (int r = 0; r < n; ++r)
        for (int c = 0; c < columns; ++c) b[std::size_t(r * columns + c)] /= a[std::size_t(r * n + r)];
}

// One band: the shortest g with sum_d g_d y_lm(a_d) = light_lm, that is g = Y^T (Y Y^T)^-1 light. basis: [axis, n^2].
static void bandLobes(int band, int order, const std::vector<std::vector<double>>& basis, std::span<const float> light,
                      std::vector<float>& lobes) {
    const int rows = 2 * band + 1, first = band * band;
    std::vector<double> gram(std::size_t(rows * rows)), right(std::size_t(rows * 3));
    for (int r = 0; r < rows; ++r) {
        for (int c = 0; c < rows; ++c)
            for (const auto& y : basis) gram[std::size_t(r * rows + c)] += y[first + r] * y[first + c];
        for (int c = 0; c < 3; ++c) right[std::size_t(r * 3 + c)] = light[std::size_t((first + r) * 3 + c)];
    }
    solveInPlace(gram, right, rows, 3);
    for (std::size_t d = 0; d < basis.size(); ++d)
        for (int c = 0; c < 3; ++c) {
            double g = 0;
            for (int r = 0; r < rows; ++r) g += basis[d][std::size_t(first + r)] * right[std::size_t(r * 3 + c)];
            lobes[(d * std::size_t(order) + std::size_t(band)) * 3 + std::size_t(c)] = float(g);
        }
}

void VertexShader::addLobes(const MaterialView& material, const LightView& light) {
    axes_ = lobeAxes(light.order);
    std::vector<std::vector<double>> basis;
    for (Vec3 axis : axes_) {
        basis.emplace_back(coefficientCount(light.order));
        evalBasis(light.order, toDouble(axis), basis.back());
    }
    lobes_.resize(axes_.size() * std::size_t(light.order) * 3);
    for (int band = 0; band < light.order; ++band) bandLobes(band, light.order, basis, light.sh, lobes_);
    if (material.channels == 1)
        for (std::size_t i = 0; i < lobes_.size(); ++i) lobes_[i] *= material.color[int(i % 3)];
}

// The entries of C that are not zero: of an isotropic material only those that couple equal m. Entries below 1e-7 of
// the largest are rounding.
void VertexShader::addSlices(const MaterialView& material) {
    const std::vector<int> even = evenIndices(material.view_order);
    const std::size_t per_channel = std::size_t(coefficientCount(material.slice_order)) * even.size();
    float largest = 0;
    for (float c : material.slices) largest = std::max(largest, std::abs(c));
    for (int channel = 0; channel < material.channels; ++channel)
        for (std::size_t at = 0; at < per_channel; ++at) {
            const float scale = material.channels == 3 ? material.color[channel] : 1;
            const float value = material.slices[std::size_t(channel) * per_channel + at];
            if (std::abs(value) <= 1e-7f * largest) continue;
            slices_[channel].push_back(
                {std::uint16_t(at / even.size()), std::uint16_t(even[at % even.size()]), scale * value});
        }
}

void VertexShader::addProduct() {
    std::array<bool, coefficientCount(kMaxOrder)> used{};
    for (const auto& slice : slices_)
        for (const SliceTerm& term : slice) used[term.k] = true;
    const std::vector<int> indices = convention_.indices();
    std::array<int, coefficientCount(kMaxOrder)> position;
    position.fill(-1);
    for (std::size_t j = 0; j < indices.size(); ++j) position[std::size_t(indices[j])] = int(j);
    for (const TripleProductEntry& entry : tripleProduct(light_order_, convention_.order, slice_order_)) {
        if (position[entry.j] < 0 || !used[entry.k]) continue;
        const auto j = std::uint16_t(position[entry.j]);
        if (rows_.empty() || rows_.back().i != entry.i || rows_.back().j != j) rows_.push_back({entry.i, j, 0});
        ++rows_.back().terms;
        products_.push_back({entry.k, float(entry.value)});
    }
}

VertexShader::VertexShader(const Convention& convention, int stride, const MaterialView& material,
                           const LightView& light)
    : convention_(convention),
      stride_(stride),
      view_order_(material.view_order),
      slice_order_(material.slice_order),
      light_order_(light.order),
      channels_(material.channels),
      path_(shadePaths().back()) {
    assert(stride >= convention.size());
    basisRecurrence(basis_a_, basis_b_);
    addSlices(material);
    addProduct();
    addLobes(material, light);
}

ShadeTables VertexShader::tables() const {
    ShadeTables tables{};
    tables.view_order = view_order_;
    tables.slice_order = slice_order_;
    tables.light_order = light_order_;
    tables.stride = stride_;
    tables.size = convention_.size();
    tables.channels = std::size_t(channels_);
    for (int c = 0; c < channels_; ++c) {
        tables.slices[c] = slices_[c].data();
        tables.slice_terms[c] = slices_[c].size();
    }
    tables.rows = rows_.data();
    tables.row_count = rows_.size();
    tables.products = products_.data();
    tables.axes = axes_.data();
    tables.axis_count = axes_.size();
    tables.lobes = lobes_.data();
    tables.basis_a = basis_a_.data();
    tables.basis_b = basis_b_.data();
    return tables;
}

void VertexShader::shade(std::size_t begin, std::size_t end, std::span<const Vec3> positions,
                         std::span<const Vec3> normals, std::span<const Vec3> tangents, std::span<const float> numbers,
                         Vec3 eye, std::span<Vec3> radiance) const {
    assert(begin <= end && end <= radiance.size() && positions.size() == radiance.size() &&
           normals.size() == radiance.size() && tangents.size() == radiance.size() &&
           numbers.size() == radiance.size() * std::size_t(stride_));
    const ShadeInput input{positions.data(), normals.data(), tangents.data(), numbers.data(), eye, radiance.data()};
    path_.shade(tables(), input, begin, end);
}

void ambient(const Convention& convention, int stride, std::size_t begin, std::size_t end,
             std::span<const float> numbers, std::span<float> e) {
    std::array<float, coefficientCount(kMaxOrder)> buffer;
    const std::span<float> weights = std::span(buffer).first(std::size_t(convention.size()));
    ambientWeights(convention, weights);
    assert(end <= e.size() && numbers.size() == e.size() * std::size_t(stride));
    for (std::size_t v = begin; v < end; ++v) {
        const float* row = numbers.data() + v * std::size_t(stride);
        float sum = 0;
        for (std::size_t i = 0; i < weights.size(); ++i) sum += weights[i] * row[i];
        e[v] = sum;
    }
}

Mat3 localFrame(Vec3 normal, Vec3 tangent) { return fromRows(tangent, cross(normal, tangent), normal); }

void numbersFromMoments(const Convention& convention, std::span<const float> moments, Vec3 normal, Vec3 tangent,
                        std::span<float> numbers) {
    assert(int(moments.size()) >= coefficientCount(convention.order));
    std::array<float, coefficientCount(kMaxOrder)> local;
    const auto count = std::size_t(coefficientCount(convention.order));
    const ShRotation rotation = makeShRotation(convention.order, localFrame(normal, tangent));
    apply(rotation, moments.first(count), std::span(local).first(count));
    fromMoments(convention, std::span<const float>(local).first(count), numbers);
}

void numbersFromTruth(const AssetView& truth, std::size_t frame, const Convention& convention, int stride,
                      std::size_t begin, std::size_t end, std::span<const std::uint32_t> shading_point,
                      std::span<const Vec3> normals, std::span<const Vec3> tangents, std::span<float> numbers) {
    std::array<float, coefficientCount(kMaxOrder)> buffer;
    const std::span<float> moments = std::span(buffer).first(std::size_t(coefficientCount(truth.truth.order)));
    const auto size = std::size_t(convention.size());
    for (std::size_t v = begin; v < end; ++v) {
        readTruth(truth, frame, shading_point[v], moments);
        const std::span<float> row = numbers.subspan(v * std::size_t(stride), std::size_t(stride));
        numbersFromMoments(convention, moments, normals[v], tangents[v], row.first(size));
        std::fill(row.begin() + std::ptrdiff_t(size), row.end(), 0.0f);
    }
}

}  // namespace penumbra
