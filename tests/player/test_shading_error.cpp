// Compares what a vertex is drawn with to brute force: the true BRDF, binary visibility and a band-limited light,
// integrated on a fine grid, over the kinds of occluders, views and lights of docs/formulas.md, section 3 (with
// random draws of its own).
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "player/runtime/shading.h"
#include "sh/quadrature.h"
#include "sh/reflectance.h"
#include "sh/sh_project.h"
#include "sh/sh_rotation.h"
#include "tests/player/synthetic_asset.h"

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kLightOrder = 4, kLightCount = kLightOrder * kLightOrder;
using Visible = std::function<bool(Vec3d)>;

class Draws {
public:
    explicit Draws(unsigned seed) : random_(seed) {}
    double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
    double degrees(double low, double high) { return uniform(low, high) * kPi / 180; }
    Vec3d direction(double lowest_z) {
        const double z = uniform(lowest_z, 1), azimuth = uniform(0, 2 * kPi), r = std::sqrt(1 - z * z);
        return {r * std::cos(azimuth), r * std::sin(azimuth), z};
    }
    Mat3d rotation() {
        const Vec3d z = direction(-1), x = normalized(cross(z, direction(-1)));
        return fromRows(x, cross(z, x), z);
    }

private:
    std::mt19937 random_;
};

// A half plane that rises from the horizon at an azimuth to an elevation.
Visible wall(double azimuth, double elevation) {
    const Vec3d m{-std::sin(elevation) * std::cos(azimuth), -std::sin(elevation) * std::sin(azimuth),
                  std::cos(elevation)};
    return [m](Vec3d s) { return dot(s, m) >= 0; };
}

Visible outsideCaps(std::vector<Vec3d> axes, std::vector<double> radii) {
    return [axes = std::move(axes), radii = std::move(radii)](Vec3d s) {
        for (std::size_t i = 0; i < axes.size(); ++i)
            if (dot(s, axes[i]) > std::cos(radii[i])) return false;
        return true;
    };
}

Visible caps(Draws& draws) {
    std::vector<Vec3d> axes;
    std::vector<double> radii;
    for (int n = int(draws.uniform(1, 5)); n > 0; --n) {
        axes.push_back(draws.direction(-0.2));
        radii.push_back(draws.degrees(10, 40));
    }
    return outsideCaps(axes, radii);
}

// Chains of eight caps along arcs, which is what arms and legs look like.
Visible limbs(Draws& draws) {
    std::vector<Vec3d> axes;
    std::vector<double> radii;
    for (int n = int(draws.uniform(1, 4)); n > 0; --n) {
        Vec3d axis = draws.direction(-0.1);
        const Vec3d pole = draws.direction(-1);
        const double step = 0.12 * draws.uniform(0.8, 1.4), radius = draws.uniform(0.12, 0.3);
        for (int i = 0; i < 8; ++i) {
            axes.push_back(axis);
            radii.push_back(radius);
            axis = normalized(axis * std::cos(step) + cross(pole, axis) * std::sin(step) +
                              pole * (dot(pole, axis) * (1 - std::cos(step))));
        }
    }
    return outsideCaps(axes, radii);
}

std::vector<Visible> makeOccluders(Draws& draws) {
    std::vector<Visible> occluders = {[](Vec3d) { return true; }};
    for (int i = 0; i < 12; ++i) {
        occluders.push_back(wall(draws.uniform(0, 2 * kPi), draws.degrees(10, 80)));
        occluders.push_back(wall(draws.uniform(0, 2 * kPi), draws.degrees(80, 130)));
        const double corner = draws.uniform(0, 2 * kPi);
        const Visible a = wall(corner, draws.degrees(20, 75)), b = wall(corner + kPi / 2, draws.degrees(20, 75));
        occluders.push_back([a, b](Vec3d s) { return a(s) && b(s); });
        occluders.push_back(caps(draws));
        occluders.push_back(limbs(draws));
    }
    return occluders;
}

// Makes sun and sky, two area lights, and smooth noise: one for each colour channel, windowed against ringing. [n^2,
// 3]
std::vector<float> makeLight(Draws& draws) {
    const Vec3d up = draws.direction(-1), sun = draws.direction(-1), a = draws.direction(-1), b = draws.direction(-1);
    const auto sky = [&](Vec3d s) {
        const double c = dot(s, up);
        return (c > 0 ? 0.6 + 0.6 * (1 - c) : 0.15) + (dot(s, sun) > std::cos(kPi / 15) ? 8 : 0);
    };
    const auto areas = [&](Vec3d s) {
        return 0.2 + (dot(s, a) > std::cos(kPi / 6) ? 2.5 : 0) + (dot(s, b) > std::cos(kPi / 4) ? 1.5 : 0);
    };
    const auto smooth = [&](Vec3d s) { return std::max(0.0, 0.8 + 0.7 * dot(s, a) + 0.5 * dot(s, b) * dot(s, up)); };
    std::vector<float> light(3 * kLightCount);
    const std::vector<WeightedDirection> grid = gaussSphere(40, 80);
    int channel = 0;
    for (const std::function<double(Vec3d)>& radiance : {std::function<double(Vec3d)>(sky), {areas}, {smooth}}) {
        std::vector<double> sh(kLightCount);
        project(kLightOrder, grid, radiance, sh);
        for (int i = 0; i < kLightCount; ++i) {
            const int l = bandOfIndex(i);
            light[std::size_t(3 * i + channel)] = float(sh[std::size_t(i)] / (1 + 0.002 * l * l * (l + 1) * (l + 1)));
        }
        ++channel;
    }
    return light;
}

// One local frame: its visibility on the grid and as numbers, and the light there.
struct Place {
    Mat3 local_from_model;
    std::vector<double> weight;   // V times solid angle, of each grid direction
    std::vector<Vec3d> radiance;  // of the light from each grid direction
    std::vector<float> numbers;
};

Place makePlace(const Convention& convention, const Visible& visible, const std::vector<WeightedDirection>& grid,
                std::span<const float> light, Draws& draws) {
    Place place;
    const Mat3d rotation = draws.rotation();
    for (std::size_t i = 0; i < 9; ++i) place.local_from_model.m[i] = float(rotation.m[i]);
    std::vector<double> moments(std::size_t(coefficientCount(convention.order)));
    project(
        convention.order, grid, [&](Vec3d s) { return visible(s) ? 1.0 : 0.0; }, moments);
    place.numbers.resize(std::size_t(convention.size()));
    fromMoments(convention, std::vector<float>(moments.begin(), moments.end()), place.numbers);
    std::array<double, kLightCount> y;
    for (const WeightedDirection& d : grid) {
        place.weight.push_back(visible(d.direction) ? d.weight : 0);
        evalBasis(kLightOrder, transposed(rotation) * d.direction, y);
        Vec3d sum;
        for (std::size_t i = 0; i < y.size(); ++i)
            sum += y[i] * Vec3d{light[3 * i], light[3 * i + 1], light[3 * i + 2]};
        place.radiance.push_back(sum);
    }
    return place;
}

// Returns the relative RMSE of radiance over lights, views and occluders.
double shadingError(const std::string& brdf, const Convention& convention) {
    Draws draws(11);
    const BrdfSpec spec = parseBrdf(brdf);
    const std::vector<float> slices = player_test::fitSlices(spec, 16);
    const MaterialView material{"m", kSliceOrder, kSliceViewOrder, 1, {1, 1, 1}, slices};
    const std::vector<WeightedDirection> grid = gaussHemisphere(48, 128);
    std::vector<Vec3d> views;
    for (const Vec3d& d : fibonacciSphere(60))
        if (d.z > 0.1) views.push_back(d);
    std::vector<std::vector<double>> reflected(views.size());  // f cos of every grid direction
    for (std::size_t o = 0; o < views.size(); ++o)
        for (const WeightedDirection& d : grid)
            reflected[o].push_back(evalBrdf(spec, d.direction, views[o]) * d.direction.z);

    double difference = 0, size = 0;
    const Vec3 eye{1, 2, 3};
    for (int set = 0; set < 2; ++set) {
        const std::vector<float> light = makeLight(draws);
        const VertexShader shader(convention, convention.size(), material, {"l", kLightOrder, light});
        for (const Visible& visible : makeOccluders(draws)) {
            const Place place = makePlace(convention, visible, grid, light, draws);
            const Mat3 model_from_local = transposed(place.local_from_model);
            std::vector<Vec3> positions, normals, tangents, radiance(views.size());
            std::vector<float> numbers;
            for (const Vec3d& view : views) {  // a vertex a view, all at the same place of the shadow
                positions.push_back(eye - 2.0f * (model_from_local * toFloat(view)));
                normals.push_back(model_from_local * Vec3{0, 0, 1});
                tangents.push_back(model_from_local * Vec3{1, 0, 0});
                numbers.insert(numbers.end(), place.numbers.begin(), place.numbers.end());
            }
            shader.shade(0, views.size(), positions, normals, tangents, numbers, eye, radiance);
            for (std::size_t o = 0; o < views.size(); ++o) {
                Vec3d exact;
                for (std::size_t q = 0; q < grid.size(); ++q)
                    exact += place.radiance[q] * (place.weight[q] * reflected[o][q]);
                const Vec3d off = toDouble(radiance[o]) - exact;
                difference += dot(off, off);
                size += dot(exact, exact);
            }
        }
    }
    return std::sqrt(difference / size);
}

// The bounds are those of docs/formulas.md, section 3. Its table has .0049 and .044 for D5 and .0157 and .071 for A4,
// on other draws of the same scenes.
TEST(ShadingError, OfTruthAgainstBruteForceIsWithinTheTable) {
    const Convention d5 = parseConvention("D5"), a4 = parseConvention("A4");
    const double lambert = shadingError("lambert", d5), ggx = shadingError("ggx:alpha=0.3,f0=0.9", d5);
    const double lambert_a4 = shadingError("lambert", a4), ggx_a4 = shadingError("ggx:alpha=0.3,f0=0.9", a4);
    std::printf("D5: Lambert %.4f, GGX %.4f; A4: Lambert %.4f, GGX %.4f\n", lambert, ggx, lambert_a4, ggx_a4);
    EXPECT_LE(lambert, 0.006);
    EXPECT_LE(ggx, 0.050);
    EXPECT_LE(lambert_a4, 0.016);
    EXPECT_LE(ggx_a4, 0.095);
}

}  // namespace
}  // namespace penumbra
