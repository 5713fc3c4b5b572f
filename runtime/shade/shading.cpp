#include "runtime/shade/shading.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>

#include "runtime/papers/transfer_evaluator.h"
#include "sh/cosine_product.h"
#include "sh/sh_rotation.h"

namespace penumbra {

VertexShader::VertexShader(const Convention& convention, int stride, const MaterialView& material,
                           const LightView& light, const ShadingChoice& choice)
    : material_(convention, light.order, material, choice.reflectance),
      light_(light, choice.light_form),
      stride_(stride),
      size_(convention.size()),
      path_(shadePaths().back()) {
    assert(stride >= size_);
}

void VertexShader::shade(const VertexFrames& vertices, Vec3 eye, std::span<Vec3> radiance) const {
    path_.shade(material_.view(), light_.view(), shadeInput(vertices, stride_, size_, eye, radiance), vertices.begin,
                vertices.end);
}

void ambient(const Convention& convention, int stride, std::span<const float> coefficients, std::span<float> e) {
    assert(coefficients.size() == e.size() * std::size_t(stride));
    std::array<float, coefficientCount(kMaxOrder)> buffer;
    const std::span<float> weights = std::span(buffer).first(std::size_t(convention.size()));
    ambientWeights(convention, weights);
    for (std::size_t v = 0; v < e.size(); ++v) {
        const float* row = coefficients.data() + v * std::size_t(stride);
        float sum = 0;
        for (std::size_t i = 0; i < weights.size(); ++i) sum += weights[i] * row[i];
        e[v] = sum;
    }
}

void ambient(const AssetView& asset, std::span<const float> coefficients, std::span<float> e) {
    if (asset.transfer) return transferAmbient(asset.model.stride, coefficients, e);
    ambient(asset.model.convention, asset.model.stride, coefficients, e);
}

std::vector<float> freeSight(const Convention& convention) {
    const auto count = std::size_t(coefficientCount(convention.order));
    std::vector<double> below(count);
    belowHorizonCoefficients(convention.order, below);
    std::vector<float> moments(count), coefficients(std::size_t(convention.size()));
    for (std::size_t i = 0; i < count; ++i) moments[i] = -float(below[i]);
    moments[0] += 2 * std::sqrt(std::numbers::pi_v<float>);
    fromMoments(convention, moments, coefficients);
    return coefficients;
}

Mat3 toLocalFrame(Vec3 normal, Vec3 tangent) { return fromRows(tangent, cross(normal, tangent), normal); }

void coefficientsFromMoments(const Convention& convention, std::span<const float> moments, Vec3 normal, Vec3 tangent,
                             std::span<float> coefficients) {
    assert(int(moments.size()) >= coefficientCount(convention.order));
    std::array<float, coefficientCount(kMaxOrder)> local;
    const auto count = std::size_t(coefficientCount(convention.order));
    const ShRotation rotation = makeShRotation(convention.order, toLocalFrame(normal, tangent));
    apply(rotation, moments.first(count), std::span(local).first(count));
    fromMoments(convention, std::span<const float>(local).first(count), coefficients);
}

void coefficientsFromTruth(const AssetView& truth, std::size_t frame, const AssetView& asset,
                           const VertexFrames& vertices, std::span<float> coefficients) {
    std::array<float, coefficientCount(kMaxOrder)> buffer;
    const std::span<float> stored = std::span(buffer).first(std::size_t(coefficientCount(truth.truth.order)));
    const Convention& convention = asset.model.convention;
    const auto stride = std::size_t(asset.model.stride), size = std::size_t(convention.size());
    std::optional<CosineProduct> cosine;
    if (asset.transfer && !truth.truth.is_transfer) cosine.emplace(asset.transfer->order);
    for (std::size_t v = vertices.begin; v < vertices.end; ++v) {
        readTruth(truth, frame, asset.mesh.shading_point[v], stored);
        const std::span<float> row = coefficients.subspan(v * stride, stride), used = row.first(size);
        if (truth.truth.is_transfer)
            std::copy_n(stored.begin(), size, used.begin());
        else if (cosine)
            cosine->apply(stored, vertices.normals[v], used);
        else
            coefficientsFromMoments(convention, stored, vertices.normals[v], vertices.tangents[v], used);
        std::fill(row.begin() + std::ptrdiff_t(size), row.end(), 0.0f);
    }
}

}  // namespace penumbra
