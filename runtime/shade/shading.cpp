#include "runtime/shade/shading.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>

#include "runtime/evaluate/transfer_evaluator.h"
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

void VertexShader::shade(std::size_t begin, std::size_t end, std::span<const Vec3> positions,
                         std::span<const Vec3> normals, std::span<const Vec3> tangents, std::span<const float> numbers,
                         Vec3 eye, std::span<Vec3> radiance) const {
    assert(begin <= end && end <= radiance.size() && positions.size() == radiance.size() &&
           normals.size() == radiance.size() && tangents.size() == radiance.size() &&
           numbers.size() == radiance.size() * std::size_t(stride_));
    const ShadeInput input{positions.data(), normals.data(), tangents.data(), numbers.data(), stride_, size_, eye,
                           radiance.data()};
    path_.shade(material_.view(), light_.view(), input, begin, end);
}

namespace {

void sumWeighted(std::span<const float> weights, int stride, std::size_t begin, std::size_t end,
                 std::span<const float> numbers, std::span<float> e) {
    assert(end <= e.size() && numbers.size() == e.size() * std::size_t(stride));
    for (std::size_t v = begin; v < end; ++v) {
        const float* row = numbers.data() + v * std::size_t(stride);
        float sum = 0;
        for (std::size_t i = 0; i < weights.size(); ++i) sum += weights[i] * row[i];
        e[v] = sum;
    }
}

}  // namespace

void ambient(const Convention& convention, int stride, std::size_t begin, std::size_t end,
             std::span<const float> numbers, std::span<float> e) {
    std::array<float, coefficientCount(kMaxOrder)> buffer;
    const std::span<float> weights = std::span(buffer).first(std::size_t(convention.size()));
    ambientWeights(convention, weights);
    sumWeighted(weights, stride, begin, end, numbers, e);
}

void ambient(const AssetView& asset, std::size_t begin, std::size_t end, std::span<const float> numbers,
             std::span<float> e) {
    const ModelView& model = asset.model;
    if (!asset.transfer) return ambient(model.convention, model.stride, begin, end, numbers, e);
    std::array<float, coefficientCount(kMaxOrder)> buffer;
    const std::span<float> weights = std::span(buffer).first(asset.transfer->coefficients());
    transferAmbientWeights(weights);
    sumWeighted(weights, model.stride, begin, end, numbers, e);
}

std::vector<float> freeSight(const Convention& convention) {
    const auto count = std::size_t(coefficientCount(convention.order));
    std::vector<double> below(count);
    belowHorizonCoefficients(convention.order, below);
    std::vector<float> moments(count), numbers(std::size_t(convention.size()));
    for (std::size_t i = 0; i < count; ++i) moments[i] = -float(below[i]);
    moments[0] += 2 * std::sqrt(std::numbers::pi_v<float>);
    fromMoments(convention, moments, numbers);
    return numbers;
}

Mat3 toLocalFrame(Vec3 normal, Vec3 tangent) { return fromRows(tangent, cross(normal, tangent), normal); }

void numbersFromMoments(const Convention& convention, std::span<const float> moments, Vec3 normal, Vec3 tangent,
                        std::span<float> numbers) {
    assert(int(moments.size()) >= coefficientCount(convention.order));
    std::array<float, coefficientCount(kMaxOrder)> local;
    const auto count = std::size_t(coefficientCount(convention.order));
    const ShRotation rotation = makeShRotation(convention.order, toLocalFrame(normal, tangent));
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

void transferFromTruth(const AssetView& truth, std::size_t frame, int order, int stride, std::size_t begin,
                       std::size_t end, std::span<const Vec3> normals, std::span<float> numbers) {
    std::array<float, coefficientCount(kMaxOrder)> buffer;
    const std::span<float> stored = std::span(buffer).first(std::size_t(coefficientCount(truth.truth.order)));
    const auto n = std::size_t(coefficientCount(order));
    const std::optional<CosineProduct> cosine =
        truth.truth.is_transfer ? std::nullopt : std::optional<CosineProduct>(order);
    for (std::size_t v = begin; v < end; ++v) {
        readTruth(truth, frame, v, stored);
        const std::span<float> row = numbers.subspan(v * std::size_t(stride), std::size_t(stride));
        if (cosine)
            cosine->apply(stored, normals[v], row.first(n));
        else
            std::copy_n(stored.begin(), n, row.begin());
        std::fill(row.begin() + std::ptrdiff_t(n), row.end(), 0.0f);
    }
}

}  // namespace penumbra
