#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "fit/numerics/eigen_map.h"
#include "fit/reflectance/shading_error.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "sh/quadrature.h"

namespace penumbra {

namespace {

constexpr int kParts = 16;  // the grid is summed in this many parts, whatever the number of threads

// Returns lit f^T for every channel, [lights * occluders, 3 views]. A channel that is a multiple of an earlier one
// takes no product of its own.
Eigen::MatrixXd shaded(const Eigen::MatrixXd& lit, const std::array<Eigen::MatrixXd, 3>& f) {
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

// The radiance of all scenes, and the albedo: what each view reflects of a light of 1 everywhere, summed over the
// channels.
struct Radiance {
    std::vector<double> radiance;  // in the layout of bruteForceRadiance()
    std::vector<double> albedo;    // [views]
};

// Integrates on the grid of the test, which all views share. The sum is then a matrix product.
Radiance onSharedGrid(const ShadingTest& test, const RgbBrdf& brdf, int threads) {
    const std::size_t lights = test.scenes.lights.size(), occluders = test.scenes.occluders.size(),
                      views = test.scenes.views.size(), columns = lights * occluders;
    const std::size_t part_size = test.directions.size() / kParts;
    std::vector<Eigen::MatrixXd> sums(kParts);
    std::vector<Eigen::VectorXd> albedos(kParts);
    parallelFor(kParts, threads, [&](std::size_t part) {
        throwIfInterrupted();
        // L = sum over q of f(q, view) (light(q) cos w) open(q).
        std::array<Eigen::MatrixXd, 3> f;
        f.fill(Eigen::MatrixXd(views, part_size));
        Eigen::MatrixXd lit(columns, part_size);
        Eigen::VectorXd cosines(part_size);
        for (std::size_t k = 0; k < part_size; ++k) {
            const std::size_t q = part * part_size + k;
            for (std::size_t v = 0; v < views; ++v) {
                const Vec3d value = brdf.eval(test.directions[q], test.scenes.views[v]);
                for (int c = 0; c < 3; ++c) f[std::size_t(c)](Eigen::Index(v), Eigen::Index(k)) = value[c];
            }
            cosines[Eigen::Index(k)] = test.directions[q].z * test.weights[q];
            for (std::size_t i = 0; i < columns; ++i)
                lit(Eigen::Index(i), Eigen::Index(k)) =
                    test.light[q * lights + i / occluders] * test.open[q * occluders + i % occluders];
        }
        sums[part] = shaded(lit, f);
        albedos[part] = (f[0] + f[1] + f[2]) * cosines;
    });
    // The parts are added in order, so the result does not depend on the number of threads.
    for (std::size_t part = 1; part < kParts; ++part) {
        sums[0] += sums[part];
        albedos[0] += albedos[part];
    }
    return {{sums[0].data(), sums[0].data() + sums[0].size()}, {albedos[0].data(), albedos[0].data() + views}};
}

// Returns a grid for one view that is dense around its mirror direction r: angles a sinh(b u) from r, azimuths about r.
std::vector<WeightedDirection> gridAbout(Vec3d view) {
    constexpr int kAngles = 96, kTurns = 64;
    constexpr double kNearAngle = 0.003;  // a in radians: a third of the nodes are nearer to r than 7 times this
    const Vec3d r{-view.x, -view.y, view.z};
    const Vec3d side = normalized(cross(std::abs(r.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0}, r)), up = cross(r, side);
    const double b = std::asinh(std::numbers::pi / kNearAngle);
    std::vector<WeightedDirection> grid;
    for (const auto& [u, weight] : gaussInterval(kAngles)) {
        const double angle = kNearAngle * std::sinh(b * u), step = kNearAngle * b * std::cosh(b * u) * weight;
        for (int j = 0; j < kTurns; ++j) {
            const double azimuth = 2 * std::numbers::pi * (j + 0.5) / kTurns;
            const Vec3d direction =
                std::cos(angle) * r + std::sin(angle) * (std::cos(azimuth) * side + std::sin(azimuth) * up);
            if (direction.z > 0) grid.push_back({direction, std::sin(angle) * step * 2 * std::numbers::pi / kTurns});
        }
    }
    return grid;
}

// A direction of one view's grid that reflects anything, with f cos w.
struct Reflected {
    Vec3d direction, value;
};
std::vector<Reflected> reflectedOf(const RgbBrdf& brdf, Vec3d view) {
    std::vector<Reflected> out;
    for (const auto& [direction, weight] : gridAbout(view)) {
        const Vec3d value = brdf.eval(direction, view) * (direction.z * weight);
        if (value.x != 0 || value.y != 0 || value.z != 0) out.push_back({direction, value});
    }
    return out;
}

// Returns the relative difference between the albedos that the two kinds of grid see, over all views. It is large where
// a lobe falls between the points of the shared grid.
double albedoDifference(const ShadingTest& test, const RgbBrdf& brdf, const std::vector<double>& shared, int threads) {
    std::vector<double> own(shared.size());
    parallelFor(own.size(), threads, [&](std::size_t v) {
        for (const Reflected& r : reflectedOf(brdf, test.scenes.views[v])) own[v] += r.value.x + r.value.y + r.value.z;
    });
    RelativeRms difference;
    for (std::size_t v = 0; v < own.size(); ++v) difference.add(shared[v], own[v]);
    return difference.value();
}

// Integrates each view on its own grid.
std::vector<double> onOwnGrids(const ShadingTest& test, const RgbBrdf& brdf, int threads) {
    const ShadingScenes& scenes = test.scenes;
    const std::size_t lights = scenes.lights.size(), occluders = scenes.occluders.size(), views = scenes.views.size();
    std::vector<double> radiance(3 * views * lights * occluders);
    parallelFor(views, threads, [&](std::size_t v) {
        throwIfInterrupted();
        std::array<double, coefficientCount(kMaxOrder)> y;
        std::vector<double> lit(3 * lights), sums(occluders * lit.size());  // [occluders, 3, lights]
        for (const auto& [direction, value] : reflectedOf(brdf, scenes.views[v])) {
            evalBasis(scenes.light_order, direction, std::span(y).first(scenes.lights[0].size()));
            for (std::size_t l = 0; l < lights; ++l) {
                double incoming = 0;
                for (std::size_t i = 0; i < scenes.lights[l].size(); ++i) incoming += scenes.lights[l][i] * y[i];
                for (int c = 0; c < 3; ++c) lit[std::size_t(c) * lights + l] = value[c] * incoming;
            }
            for (std::size_t k = 0; k < occluders; ++k) {
                if (isBlocked(scenes.occluders[k], direction)) continue;
                for (std::size_t i = 0; i < lit.size(); ++i) sums[k * lit.size() + i] += lit[i];
            }
        }
        // Put the sums in the order of bruteForceRadiance().
        for (std::size_t at = 0; at < sums.size(); ++at) {
            const std::size_t k = at / lit.size(), c = at % lit.size() / lights, l = at % lights;
            radiance[((c * views + v) * lights + l) * occluders + k] = sums[at];
        }
    });
    return radiance;
}

}  // namespace

std::vector<double> bruteForceRadiance(const ShadingTest& test, const RgbBrdf& brdf, int threads) {
    constexpr double kAlike = 0.01;
    Radiance shared = onSharedGrid(test, brdf, threads);
    return albedoDifference(test, brdf, shared.albedo, threads) > kAlike ? onOwnGrids(test, brdf, threads)
                                                                         : std::move(shared.radiance);
}

}  // namespace penumbra
