// Radiance from D5 visibility and J = 5 slices against the integral of light, binary visibility and the true BRDF, on
// the very scenes of the accuracy table in docs/formulas.md section 3: light order 4, 61 occluders, 54 views, 6 lights.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>

#include "fit/fit_brdf.h"
#include "sh/quadrature.h"
#include "sh/reflectance.h"
#include "sh/sh_product.h"
#include "tests/sh/golden.h"

namespace penumbra {
namespace {

constexpr int kLightOrder = 4, kVisibilityOrder = 5;

struct Scenes {
    std::vector<WeightedDirection> grid = gaussHemisphere(64, 256);
    std::vector<std::vector<int>> visible;  // of each occluder: the points of the grid that it leaves open
    std::vector<Vec3d> views;
    std::vector<std::vector<double>> lights;    // [6][16]
    std::vector<std::vector<double>> radiance;  // [6][grid], of the lights
    std::vector<std::vector<double>> mirrored;  // [61][25], D5 as coefficients
};

bool isBlocked(const nlohmann::json& parts, Vec3d s) {
    for (const auto& part : parts) {
        const double along = dot(s, Vec3d{part[1], part[2], part[3]});
        if (part[0] == "wall" ? along < 0 : along > part[4].get<double>()) return true;
    }
    return false;
}

Scenes readScenes(const nlohmann::json& golden) {
    Scenes scenes;
    for (const auto& view : golden.at("views")) scenes.views.push_back(vec3(view));
    for (const auto& light : golden.at("lights")) scenes.lights.push_back(doubles(light));
    std::vector<std::array<double, 25>> basis(scenes.grid.size());
    for (std::size_t q = 0; q < basis.size(); ++q) evalBasis(5, scenes.grid[q].direction, basis[q]);
    for (const auto& light : scenes.lights) {
        std::vector<double>& radiance = scenes.radiance.emplace_back();
        for (const auto& y : basis) radiance.push_back(std::inner_product(light.begin(), light.end(), y.begin(), 0.0));
    }
    for (const auto& occluder : golden.at("occluders")) {
        std::vector<int>& visible = scenes.visible.emplace_back();
        std::vector<double>& d = scenes.mirrored.emplace_back(25);
        for (std::size_t q = 0; q < basis.size(); ++q) {
            if (isBlocked(occluder.at("parts"), scenes.grid[q].direction)) continue;
            visible.push_back(int(q));
            for (int index : evenIndices(kVisibilityOrder))
                d[std::size_t(index)] += 2 * scenes.grid[q].weight * basis[q][std::size_t(index)];
        }
    }
    return scenes;
}

// Slices of all views, [54][25], of one channel.
std::vector<std::vector<double>> slicesOf(const BrdfFile& brdf, const std::vector<Vec3d>& views) {
    std::vector<std::vector<double>> slices;
    for (Vec3d view : views) {
        std::array<double, 25> y;
        evalBasis(brdf.view_order, view, y);
        std::vector<double>& f = slices.emplace_back(25);
        for (std::size_t i = 0; i < 25; ++i)
            for (std::size_t e = 0; e < brdf.even_index.size(); ++e)
                f[i] += brdf.slices[(i * brdf.even_index.size() + e) * 3] * y[std::size_t(brdf.even_index[e])];
    }
    return slices;
}

// Relative RMSE of l . (f x v) over all lights, views and occluders.
double shadingError(const Scenes& scenes, const BrdfSpec& spec) {
    const auto slices = slicesOf(fitBrdf(rgbBrdf(spec), {}, 2), scenes.views);
    const BrdfFunction brdf = brdfFunction(spec);
    // The product of light and visibility does not depend on the view.
    std::vector<std::vector<double>> products;
    for (const auto& light : scenes.lights)
        for (const auto& d : scenes.mirrored)
            multiply(kSliceOrder, light, kLightOrder, d, kVisibilityOrder, products.emplace_back(25));
    double error = 0, total = 0;
    std::vector<double> transfer(scenes.grid.size()), reflected(scenes.grid.size());
    for (std::size_t v = 0; v < scenes.views.size(); ++v) {
        for (std::size_t q = 0; q < transfer.size(); ++q) {
            const auto& [direction, weight] = scenes.grid[q];
            transfer[q] = weight * direction.z * brdf(direction, scenes.views[v]);
        }
        for (std::size_t l = 0; l < scenes.lights.size(); ++l) {
            for (std::size_t q = 0; q < transfer.size(); ++q) reflected[q] = transfer[q] * scenes.radiance[l][q];
            for (std::size_t k = 0; k < scenes.visible.size(); ++k) {
                double exact = 0;
                for (int q : scenes.visible[k]) exact += reflected[std::size_t(q)];
                const auto& product = products[l * scenes.visible.size() + k];
                const double ours = std::inner_product(product.begin(), product.end(), slices[v].begin(), 0.0);
                error += (ours - exact) * (ours - exact);
                total += exact * exact;
            }
        }
    }
    return std::sqrt(error / total);
}

// Measured: Lambert .0049, Phong 10 .0655, Phong 50 .1569, Ward GMD .0656, Ward 92 .0639, Ashikhmin .0544, GGX .0441.
TEST(ShadingScenes, ErrorsAreThoseOfTheTable) {
    const auto golden = readGolden("scene_seed11.json");
    const Scenes scenes = readScenes(golden);
    ASSERT_EQ(scenes.visible.size(), 61u);
    ASSERT_EQ(scenes.views.size(), 54u);
    for (const auto& row : golden.at("table")) {
        const double error = shadingError(scenes, parseBrdf(row[0].get<std::string>()));
        EXPECT_LE(error, row[2].get<double>()) << row[0];
        EXPECT_NEAR(error, row[1].get<double>(), 6e-4) << row[0];  // the table has three digits
    }
}

}  // namespace
}  // namespace penumbra
