#include "fit/reflectance/shading_error.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "fit/numerics/eigen_map.h"
#include "formats/common/parallel_for.h"
#include "sh/quadrature.h"
#include "sh/sh_product.h"

namespace penumbra {

namespace {

constexpr int kHeights = 64, kAzimuths = 256;
constexpr int kErrorParts = 16;
constexpr std::size_t kPartSize = std::size_t(kHeights) * kAzimuths / kErrorParts;

template <class T>
Eigen::Map<const EigenRows<double>> rowsOf(const T& values, std::size_t columns) {
    return {values.data(), Eigen::Index(values.size() / columns), Eigen::Index(columns)};
}

}  // namespace

ShadingTest makeShadingTest(const ShadingScenes& scenes, int threads) {
    ShadingTest test{scenes, {}, {}, {}, {}, {}};
    const auto grid = gaussHemisphere(kHeights, kAzimuths);
    const std::size_t lights = scenes.lights.size(), occluders = scenes.occluders.size();
    constexpr int kCount = coefficientCount(kMaxOrder);
    // 1. The grid.
    for (const auto& [direction, weight] : grid) {
        test.directions.push_back(direction);
        test.weights.push_back(weight);
    }
    // 2. Lights and occluders on the grid.
    test.light.resize(grid.size() * lights);
    test.open.resize(grid.size() * occluders);
    std::vector<double> weighted(grid.size() * kCount);
    parallelFor(kErrorParts, threads, [&](std::size_t part) {
        std::array<double, kCount> y;
        for (std::size_t q = part * kPartSize; q < (part + 1) * kPartSize; ++q) {
            const auto& [direction, weight] = grid[q];
            evalBasis(kMaxOrder, direction, y);
            for (std::size_t i = 0; i < y.size(); ++i) weighted[q * kCount + i] = weight * y[i];
            for (std::size_t l = 0; l < lights; ++l)
                for (std::size_t i = 0; i < scenes.lights[l].size(); ++i)
                    test.light[q * lights + l] += scenes.lights[l][i] * y[i] * weight * direction.z;
            for (std::size_t k = 0; k < occluders; ++k)
                test.open[q * occluders + k] = !isBlocked(scenes.occluders[k], direction);
        }
    });
    // 3. Moments of every occluder.
    test.moments.resize(occluders * kCount);
    Eigen::Map<EigenRows<double>>(test.moments.data(), Eigen::Index(occluders), kCount) =
        rowsOf(test.open, occluders).transpose() * rowsOf(weighted, kCount);
    return test;
}

namespace {

// Returns the product of light and visibility for every light and occluder, [lights * occluders, J^2]. It does not
// depend on the view.
std::vector<double> products(const ShadingTest& test, const Convention& convention, int slice_order) {
    const auto count = std::size_t(coefficientCount(convention.order)),
               rows = std::size_t(coefficientCount(slice_order));
    std::vector<float> coefficients(std::size_t(convention.size())), full(count);
    std::vector<double> p, product(rows);
    for (const std::vector<double>& light : test.scenes.lights)
        for (std::size_t k = 0; k < test.scenes.occluders.size(); ++k) {
            const double* moments = test.moments.data() + k * coefficientCount(kMaxOrder);
            const std::vector<float> single(moments, moments + count);
            fromMoments(convention, single, coefficients);
            fullCoefficients(convention, coefficients, full);
            multiply(slice_order, light, test.scenes.light_order, std::vector<double>(full.begin(), full.end()),
                     convention.order, product);
            p.insert(p.end(), product.begin(), product.end());
        }
    return p;
}

}  // namespace

ShadingTruth shadingTruth(const RgbBrdf& brdf, int threads) {
    ShadingTest test = makeShadingTest(referenceScenes(), threads);
    std::vector<double> radiance = bruteForceRadiance(test, brdf, threads);
    return {std::move(test), std::move(radiance)};
}

double shadingError(const ShadingTruth& truth, const Convention& convention, const std::vector<double>& slices_of_views,
                    int slice_order) {
    const auto rows = std::size_t(coefficientCount(slice_order));
    const std::size_t views = truth.test.scenes.views.size();
    assert(slices_of_views.size() == views * rows * 3);
    const std::vector<double> p = products(truth.test, convention, slice_order);
    const std::size_t scenes = p.size() / rows;
    assert(truth.radiance.size() == 3 * views * scenes);
    RelativeRms error;
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t v = 0; v < views; ++v)
            for (std::size_t k = 0; k < scenes; ++k) {
                double ours = 0;
                for (std::size_t i = 0; i < rows; ++i)
                    ours += p[k * rows + i] * slices_of_views[(v * rows + i) * 3 + c];
                error.add(ours, truth.radiance[(c * views + v) * scenes + k]);
            }
    return error.value();
}

std::vector<double> slicesOfViews(const std::vector<Vec3d>& views, const std::vector<double>& c,
                                  const std::vector<int>& index) {
    const std::size_t rows = c.size() / index.size() / 3;
    std::vector<double> f(views.size() * rows * 3);
    std::array<double, coefficientCount(kMaxOrder)> y;
    for (std::size_t v = 0; v < views.size(); ++v) {
        evalBasis(kMaxOrder, views[v], y);
        for (std::size_t i = 0; i < rows; ++i)
            for (std::size_t e = 0; e < index.size(); ++e)
                for (std::size_t channel = 0; channel < 3; ++channel)
                    f[(v * rows + i) * 3 + channel] +=
                        c[(i * index.size() + e) * 3 + channel] * y[std::size_t(index[e])];
    }
    return f;
}

void measureShading(const ShadingTruth& truth, BrdfFile& brdf) {
    const std::vector<double> slices = slicesOfViews(truth.test.scenes.views, brdf.slices, brdf.even_index);
    brdf.errors["shading_d5"] = shadingError(truth, {BelowHorizon::kMirrored, 5}, slices, brdf.slice_order);
    brdf.errors["shading_a4"] = shadingError(truth, {BelowHorizon::kOpen, 4}, slices, brdf.slice_order);
}

double lobeError(const ShadingTruth& truth, std::span<const BrdfLobe> lobes, int threads) {
    const RgbBrdf sum{"lobes", BrdfSymmetry::kOrthotropic,
                      [lobes](Vec3d wi, Vec3d wo) { return toDouble(evalLobes(lobes, toFloat(wi), toFloat(wo))); }};
    const std::vector<double> ours = bruteForceRadiance(truth.test, sum, threads);
    RelativeRms error;
    for (std::size_t i = 0; i < ours.size(); ++i) error.add(ours[i], truth.radiance[i]);
    return error.value();
}

}  // namespace penumbra
