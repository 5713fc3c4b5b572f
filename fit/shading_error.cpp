#include "fit/shading_error.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "fit/eigen_map.h"
#include "formats/parallel_for.h"
#include "formats/write_file.h"
#include "sh/quadrature.h"
#include "sh/sh_product.h"

namespace penumbra {

constexpr int kHeights = 64, kAzimuths = 256;
constexpr int kParts = 16;  // the grid is summed in this many parts, whatever the number of threads
constexpr std::size_t kPartSize = std::size_t(kHeights) * kAzimuths / kParts;

template <class T>
static Eigen::Map<const EigenRows<double>> rowsOf(const T& values, std::size_t columns) {
    return {values.data(), Eigen::Index(values.size() / columns), Eigen::Index(columns)};
}

ShadingTest makeShadingTest(const ShadingScenes& scenes, int threads) {
    ShadingTest test{scenes, {}, {}, {}, {}};
    const auto grid = gaussHemisphere(kHeights, kAzimuths);
    const std::size_t lights = scenes.lights.size(), occluders = scenes.occluders.size();
    constexpr int kCount = coefficientCount(kMaxOrder);
    for (const auto& point : grid) test.directions.push_back(point.direction);
    test.light.resize(grid.size() * lights);
    test.open.resize(grid.size() * occluders);
    std::vector<double> weighted(grid.size() * kCount);
    parallelFor(kParts, threads, [&](std::size_t part) {
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
    test.moments.resize(occluders * kCount);
    Eigen::Map<EigenRows<double>>(test.moments.data(), Eigen::Index(occluders), kCount) =
        rowsOf(test.open, occluders).transpose() * rowsOf(weighted, kCount);
    return test;
}

// lit f^T of every channel, [lights * occluders, 3 views]. Channels that are multiples of another take no product.
static Eigen::MatrixXd shaded(const Eigen::MatrixXd& lit, const std::array<Eigen::MatrixXd, 3>& f) {
    const Eigen::Index views = f[0].rows();
    Eigen::MatrixXd radiance(lit.rows(), 3 * views);
    for (Eigen::Index c = 0; c < 3; ++c) {
        bool multiple = false;
        for (Eigen::Index d = 0; d < c && !multiple; ++d) {
            Eigen::Index row = 0, column = 0;
            const auto &own = f[std::size_t(c)], &other = f[std::size_t(d)];
            const double top = other.cwiseAbs().maxCoeff(&row, &column);
            const double factor = top > 0 ? own(row, column) / other(row, column) : 0;
            multiple = (own - factor * other).cwiseAbs().maxCoeff() <= 1e-14 * std::abs(factor) * top;
            if (multiple) radiance.middleCols(c * views, views) = factor * radiance.middleCols(d * views, views);
        }
        if (!multiple) radiance.middleCols(c * views, views) = lit * f[std::size_t(c)].transpose();
    }
    return radiance;
}

std::vector<double> bruteForceRadiance(const ShadingTest& test, const RgbBrdf& brdf, int threads) {
    const std::size_t lights = test.scenes.lights.size(), occluders = test.scenes.occluders.size(),
                      views = test.scenes.views.size(), columns = lights * occluders;
    std::vector<Eigen::MatrixXd> sums(kParts);
    parallelFor(kParts, threads, [&](std::size_t part) {
        throwIfInterrupted();
        // L = sum over q of f(q, view) (light(q) cos w) open(q).
        std::array<Eigen::MatrixXd, 3> f;
        f.fill(Eigen::MatrixXd(views, kPartSize));
        Eigen::MatrixXd lit(columns, kPartSize);
        for (std::size_t k = 0; k < kPartSize; ++k) {
            const std::size_t q = part * kPartSize + k;
            for (std::size_t v = 0; v < views; ++v) {
                const Vec3d value = brdf.eval(test.directions[q], test.scenes.views[v]);
                for (int c = 0; c < 3; ++c) f[std::size_t(c)](Eigen::Index(v), Eigen::Index(k)) = value[c];
            }
            for (std::size_t i = 0; i < columns; ++i)
                lit(Eigen::Index(i), Eigen::Index(k)) =
                    test.light[q * lights + i / occluders] * test.open[q * occluders + i % occluders];
        }
        sums[part] = shaded(lit, f);
    });
    Eigen::MatrixXd total = sums[0];
    for (std::size_t part = 1; part < kParts; ++part) total += sums[part];
    return {total.data(), total.data() + total.size()};
}

// p of every light and occluder, [lights * occluders, J^2]: the product of light and visibility does not depend on the
// view.
static std::vector<double> products(const ShadingTest& test, const Convention& convention, int slice_order) {
    const auto count = std::size_t(coefficientCount(convention.order)),
               rows = std::size_t(coefficientCount(slice_order));
    std::vector<float> numbers(std::size_t(convention.size())), coefficients(count);
    std::vector<double> p, product(rows);
    for (const std::vector<double>& light : test.scenes.lights)
        for (std::size_t k = 0; k < test.scenes.occluders.size(); ++k) {
            const double* moments = test.moments.data() + k * coefficientCount(kMaxOrder);
            const std::vector<float> single(moments, moments + count);
            fromMoments(convention, single, numbers);
            toCoefficients(convention, numbers, coefficients);
            multiply(slice_order, light, test.scenes.light_order,
                     std::vector<double>(coefficients.begin(), coefficients.end()), convention.order, product);
            p.insert(p.end(), product.begin(), product.end());
        }
    return p;
}

double shadingError(const ShadingTest& test, const std::vector<double>& truth, const Convention& convention,
                    const std::vector<double>& slices_of_views, int slice_order) {
    const auto rows = std::size_t(coefficientCount(slice_order));
    const std::size_t views = test.scenes.views.size();
    assert(slices_of_views.size() == views * rows * 3);
    const std::vector<double> p = products(test, convention, slice_order);
    const std::size_t scenes = p.size() / rows;
    assert(truth.size() == 3 * views * scenes);
    double error = 0, total = 0;
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t v = 0; v < views; ++v)
            for (std::size_t k = 0; k < scenes; ++k) {
                double ours = 0;
                for (std::size_t i = 0; i < rows; ++i)
                    ours += p[k * rows + i] * slices_of_views[(v * rows + i) * 3 + c];
                const double exact = truth[(c * views + v) * scenes + k];
                error += (ours - exact) * (ours - exact);
                total += exact * exact;
            }
    return total > 0 ? std::sqrt(error / total) : 0;
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

}  // namespace penumbra
