#include "player/runtime/shading.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "player/runtime/light_lobes.h"
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

void VertexShader::addLobes(const MaterialView& material, const LightView& light) {
    LightLobes lobes = makeLightLobes(light);
    axes_ = std::move(lobes.directions);
    lobes_ = std::move(lobes.weights);
    if (material.channels == 1)
        for (Vec3& weight : lobes_) weight = weight * material.color;
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
