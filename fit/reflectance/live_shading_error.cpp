#include "fit/reflectance/live_shading_error.h"

#include <cassert>
#include <cmath>

#include "fit/numerics/matrix.h"
#include "formats/common/parallel_for.h"
#include "sh/brdf/mirror_lobe.h"
#include "sh/reflectance.h"
#include "sh/sh_rotation.h"

namespace penumbra {

namespace {

// Rows x, y, z of a frame whose z is the mirror direction of the view.
Mat3d mirrorFrame(Vec3d view) {
    const Vec3d r{-view.x, -view.y, view.z};
    const Vec3d across = std::abs(r.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}, x = normalized(cross(across, r));
    return fromRows(x, cross(r, x), r);
}

std::vector<double> timesVector(const std::vector<double>& matrix, std::span<const double> v) {
    std::vector<double> product(matrix.size() / v.size());
    for (std::size_t i = 0; i < product.size(); ++i)
        for (std::size_t j = 0; j < v.size(); ++j) product[i] += matrix[i * v.size() + j] * v[j];
    return product;
}

std::vector<double> turned(int order, const Mat3d& rotation, std::span<const double> v) {
    std::vector<double> out(v.size());
    apply(makeShRotation(order, rotation), v, out);
    return out;
}

// Returns the Gram matrix of the hemisphere, [moment_order^2, order^2].
std::vector<double> gram(int moment_order, int order) {
    std::vector<double> moments;
    for (int k = 0; k < moment_order + order - 1; ++k) moments.push_back(1 / double(k + 1));
    return mirrorLobeMatrix(moment_order, order, moments);
}

std::vector<double> lobeMatrix(const BrdfLobe& lobe, int light_order, int moment_order) {
    std::vector<double> moments(std::size_t(light_order + moment_order - 1));
    mirrorLobeMoments(lobe.model, double(lobe.parameters[0]), moments);
    return mirrorLobeMatrix(light_order, moment_order, moments);
}

std::vector<double> spread(int order, std::span<const double> coefficients) {
    const std::vector<int> even = evenIndices(order);
    assert(even.size() == coefficients.size());
    std::vector<double> d(std::size_t(coefficientCount(order)));
    for (std::size_t i = 0; i < even.size(); ++i) d[std::size_t(even[i])] = coefficients[i];
    return d;
}

double product(std::span<const double> a, std::span<const double> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
}

}  // namespace

double liveRadiance(const BrdfLobe& lobe, int light_order, std::span<const double> light, int order,
                    std::span<const double> coefficients, int moment_order, Vec3d view) {
    const Mat3d frame = mirrorFrame(view);
    const std::vector<double> b = timesVector(gram(moment_order, order), spread(order, coefficients));
    const std::vector<double> t =
        timesVector(lobeMatrix(lobe, light_order, moment_order), turned(moment_order, frame, b));
    return product(turned(light_order, frame, light), t);
}

double liveShadingError(const RgbBrdf& source, const BrdfLobe& lobe, int threads) {
    constexpr int kOrder = 5, kMomentOrder = 6;
    const ShadingTruth truth = shadingTruth(source, threads);
    const ShadingTest& test = truth.test;
    const std::size_t occluders = test.scenes.occluders.size(), lights = test.scenes.lights.size(),
                      views = test.scenes.views.size();
    const std::vector<double> matrix = lobeMatrix(lobe, test.scenes.light_order, kMomentOrder),
                              to_moments = gram(kMomentOrder, kOrder);
    std::vector<std::vector<double>> b;
    for (std::size_t k = 0; k < occluders; ++k) {
        std::vector<double> d(coefficientCount(kOrder));
        for (const int i : evenIndices(kOrder))
            d[std::size_t(i)] = 2 * test.moments[k * coefficientCount(kMaxOrder) + std::size_t(i)];
        b.push_back(timesVector(to_moments, d));
    }
    std::vector<RelativeRms> errors(views);
    parallelFor(views, threads, [&](std::size_t v) {
        const Mat3d frame = mirrorFrame(test.scenes.views[v]);
        for (std::size_t k = 0; k < occluders; ++k) {
            const std::vector<double> t = timesVector(matrix, turned(kMomentOrder, frame, b[k]));
            for (std::size_t l = 0; l < lights; ++l) {
                const double ours = product(turned(test.scenes.light_order, frame, test.scenes.lights[l]), t);
                for (int c = 0; c < 3; ++c)
                    errors[v].add(ours * double(lobe.color[c]),
                                  truth.radiance[((std::size_t(c) * views + v) * lights + l) * occluders + k]);
            }
        }
    });
    RelativeRms error;
    for (const RelativeRms& of_view : errors) error.add(of_view);
    return error.value();
}

}  // namespace penumbra
