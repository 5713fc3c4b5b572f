// Compares the radiance that the run time computes for a vertex with brute force, over the scenes of docs/formulas.md
// section 3. Brute force integrates the true BRDF, binary visibility and a band-limited light on a fine grid.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "fit/reflectance/fit_brdf.h"
#include "fit/reflectance/shading_error.h"
#include "runtime/shade/shading.h"
#include "sh/sh_rotation.h"
#include "tests/accuracy/extent.h"
#include "tests/fit/golden_scenes.h"

namespace penumbra::test_run_time_shading {
namespace {

Mat3d randomRotation(std::mt19937& random) {
    std::normal_distribution<double> normal;
    const auto direction = [&] { return normalized(Vec3d{normal(random), normal(random), normal(random)}); };
    const Vec3d z = direction(), x = normalized(cross(z, direction()));
    return fromRows(x, cross(z, x), z);
}

// Three lights of the scenes, given in the local frame, as the colours of one light of the model. [n^2, 3]
std::vector<float> lightOfModel(const ShadingScenes& scenes, std::size_t first, const Mat3d& model_from_local) {
    const std::size_t count = std::size_t(coefficientCount(scenes.light_order));
    std::vector<float> light(3 * count);
    std::vector<double> turned(count);
    for (std::size_t c = 0; c < 3; ++c) {
        apply(makeShRotation(scenes.light_order, model_from_local), scenes.lights[first + c], turned);
        for (std::size_t i = 0; i < count; ++i) light[3 * i + c] = float(turned[i]);
    }
    return light;
}

std::vector<float> coefficientsOf(const ShadingTest& test, std::size_t occluder, const Convention& convention) {
    const double* moments = test.moments.data() + occluder * coefficientCount(kMaxOrder);
    std::vector<float> coefficients(std::size_t(convention.size()));
    fromMoments(convention, std::vector<float>(moments, moments + coefficientCount(convention.order)), coefficients);
    return coefficients;
}

// Radiance of one place towards every view, [views]: a vertex a view, each at the same place of the shadow.
std::vector<Vec3> shadePlace(const VertexShader& shader, const std::vector<Vec3d>& views,
                             const std::vector<float>& coefficients, const Mat3d& model_from_local) {
    const Vec3 eye{1, 2, 3};
    std::vector<Vec3> positions, normals, tangents, radiance(views.size());
    std::vector<float> all_coefficients;
    for (const Vec3d& view : views) {
        positions.push_back(eye - 2.0f * toFloat(model_from_local * view));
        normals.push_back(toFloat(model_from_local * Vec3d{0, 0, 1}));
        tangents.push_back(toFloat(model_from_local * Vec3d{1, 0, 0}));
        all_coefficients.insert(all_coefficients.end(), coefficients.begin(), coefficients.end());
    }
    shader.shade({positions, normals, tangents, all_coefficients, 0, views.size()}, eye, radiance);
    return radiance;
}

// Relative RMSE of radiance over lights, views and occluders, each occluder in a local frame of its own.
double runTimeError(const ShadingTest& test, const BrdfFile& brdf, const std::vector<double>& truth,
                    const Convention& convention) {
    const std::size_t lights = test.scenes.lights.size(), occluders = test.scenes.occluders.size(),
                      views = test.scenes.views.size();
    std::vector<float> slices;  // of the first channel: the materials are grey
    for (std::size_t i = 0; i < brdf.slices.size(); i += 3) slices.push_back(float(brdf.slices[i]));
    const MaterialView material{"m", brdf.slice_order, brdf.view_order, 1, {1, 1, 1}, slices};
    std::mt19937 random(11);
    double difference = 0, size = 0;
    for (std::size_t k = 0; k < occluders; ++k) {
        const Mat3d model_from_local = randomRotation(random);
        const std::vector<float> coefficients = coefficientsOf(test, k, convention);
        for (std::size_t first = 0; first < lights; first += 3) {
            const std::vector<float> light = lightOfModel(test.scenes, first, model_from_local);
            const VertexShader shader(convention, convention.size(), material, {"l", test.scenes.light_order, light});
            const std::vector<Vec3> radiance = shadePlace(shader, test.scenes.views, coefficients, model_from_local);
            for (std::size_t v = 0; v < views; ++v)
                for (std::size_t c = 0; c < 3; ++c) {
                    const double exact = truth[(v * lights + first + c) * occluders + k];
                    difference += std::pow(double(radiance[v][int(c)]) - exact, 2);
                    size += exact * exact;
                }
        }
    }
    return std::sqrt(difference / size);
}

struct Row {
    const char* brdf;
    double d5, a4;  // measured
};

void expectRows(const char* name, const ShadingScenes& scenes, const std::vector<Row>& rows) {
    const ShadingTest test = makeShadingTest(scenes, 2);
    for (const Row& row : rows) {
        const RgbBrdf grey = rgbBrdf(parseBrdf(row.brdf));
        const BrdfFile brdf = fitBrdf(grey, {}, 2);
        const std::vector<double> truth = bruteForceRadiance(test, grey, 2);
        const double d5 = runTimeError(test, brdf, truth, parseConvention("D5")),
                     a4 = runTimeError(test, brdf, truth, parseConvention("A4"));
        std::printf("run time, %s, %s: D5 %.4f, A4 %.4f\n", name, row.brdf, d5, a4);
        EXPECT_NEAR(d5, row.d5, 1e-4) << name << ' ' << row.brdf;
        EXPECT_NEAR(a4, row.a4, 1e-4) << name << ' ' << row.brdf;
    }
}

// On the scenes of the table the run time has the figures of the columns "C, D5" and "C, A4" of docs/formulas.md
// section 3: single precision, rotated lights and its kernels change nothing in four digits. The figures of the other
// scenes are measured. A figure may differ by 1e-4.
TEST(ShadingError, OfTruthAgainstBruteForceIsWithinTheTable) {
    expectRows("scenes of the table", referenceScenes(),
               {{"lambert", .0049, .0156}, {"ggx:alpha=0.3,f0=0.9", .0441, .0616}});
    if (!every_row) return;
    expectRows("other scenes", scenesOfGolden(readGolden("scene_seed12.json")),
               {{"lambert", .0040, .0092}, {"ggx:alpha=0.3,f0=0.9", .0370, .0522}});
}

}  // namespace
}  // namespace penumbra::test_run_time_shading
