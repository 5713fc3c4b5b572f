#include <gtest/gtest.h>

#include <numbers>

#include "pack/pack_asset.h"
#include "runtime/shade/shading.h"
#include "runtime/shade/visibility_transfer.h"
#include "sh/quadrature.h"
#include "sh/sh_rotation.h"
#include "tests/difference.h"
#include "tests/sh/eval_slice.h"
#include "tests/sh/sh_project.h"
#include "tests/synthetic_model.h"

namespace penumbra::test_shading {
namespace {

constexpr double kPi = std::numbers::pi;

// A material, a light and vertices, without an asset.
struct Scene {
    Convention convention{BelowHorizon::kMirrored, 5};
    std::vector<float> slices, light;
    MaterialView material;
    LightView light_view;
    std::vector<Vec3> positions, normals, tangents;
    std::vector<float> coefficients;  // stride = size
    Vec3 eye{0.3f, 0.4f, 3.0f};

    void setMaterial(const BrdfFile& brdf, int channels = 1) {
        slices.clear();
        for (int c = 0; c < channels; ++c)
            for (std::size_t i = 0; i < brdf.slices.size() / 3; ++i)
                slices.push_back(float(brdf.slices[3 * i + std::size_t(c)]));
        material = {"m", brdf.slice_order, brdf.view_order, channels, {1, 1, 1}, slices};
    }
    void setLight(const LightFile& file) {
        light.assign(file.sh.begin(), file.sh.end());
        light_view = {"l", file.order, light};
    }
    void addVertex(Vec3 position, Vec3 normal, Vec3 tangent, std::span<const float> n) {
        positions.push_back(position);
        normals.push_back(normal);
        tangents.push_back(tangent);
        coefficients.insert(coefficients.end(), n.begin(), n.end());
    }
    std::vector<Vec3> shade(const ShadePath* path = nullptr) const {
        VertexShader shader(convention, convention.size(), material, light_view);
        if (path) shader.usePath(*path);
        std::vector<Vec3> radiance(positions.size());
        shader.shade({positions, normals, tangents, coefficients, 0, positions.size()}, eye, radiance);
        return radiance;
    }
};

Mat3 someRotation(float a, float b) {
    const float c = std::cos(a), s = std::sin(a), d = std::cos(b), t = std::sin(b);
    return Mat3{{c, -s, 0, s, c, 0, 0, 0, 1}} * Mat3{{1, 0, 0, 0, d, -t, 0, t, d}};
}

// Returns the numbers of a visibility function given in the local frame, through its hemisphere moments.
template <class Visible>
std::vector<float> coefficientsOf(const Convention& convention, Visible visible) {
    std::vector<double> moments(std::size_t(coefficientCount(convention.order)));
    project(
        convention.order, gaussHemisphere(128, 256), [&](Vec3d s) { return visible(s) ? 1.0 : 0.0; }, moments);
    const std::vector<float> local(moments.begin(), moments.end());
    std::vector<float> coefficients(std::size_t(convention.size()));
    fromMoments(convention, local, coefficients);
    return coefficients;
}

Vec3d radianceOf(const LightFile& light, Vec3d s) {
    std::vector<double> y(std::size_t(coefficientCount(light.order)));
    evalBasis(light.order, s, y);
    Vec3d sum;
    for (std::size_t i = 0; i < y.size(); ++i)
        for (int c = 0; c < 3; ++c) sum[c] += y[i] * light.sh[3 * i + std::size_t(c)];
    return sum;
}

Vec3d toModel(const Mat3& q, Vec3d local) {
    return Vec3d{q(0, 0), q(0, 1), q(0, 2)} * local.x + Vec3d{q(1, 0), q(1, 1), q(1, 2)} * local.y +
           Vec3d{q(2, 0), q(2, 1), q(2, 2)} * local.z;
}

// V = 1 over the hemisphere is exact in A and D, and so is the product. Measured: 6e-8.
TEST(VertexShader, OpenLambertUnderUniformLightIsItsAlbedo) {
    for (const char* name : {"A4", "A5", "D4", "D5", "D6"}) {
        Scene scene;
        scene.convention = parseConvention(name);
        scene.setMaterial(synthetic::lambert());
        scene.material.color = {0.2f, 0.5f, 0};
        scene.setLight(synthetic::light(4, 0));
        const Mat3 q = someRotation(0.7f, 1.9f);
        scene.addVertex({0, 0, 0}, {q(2, 0), q(2, 1), q(2, 2)}, {q(0, 0), q(0, 1), q(0, 2)},
                        coefficientsOf(scene.convention, [](Vec3d) { return true; }));
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(scene.shade()[0][c], scene.material.color[c], 3e-7) << name;
    }
}

// Lambert under an order-4 light is the integral of light cos / pi. It is exact, as bands 0..3 of the cosine are.
// Measured: 5.1e-7.
TEST(VertexShader, OpenLambertIsTheCosineIntegralOfTheLight) {
    Scene scene;
    const LightFile light = synthetic::light(4, 1);
    scene.setMaterial(synthetic::lambert());
    scene.setLight(light);
    const std::vector<float> open = coefficientsOf(scene.convention, [](Vec3d) { return true; });
    for (int i = 0; i < 11; ++i) {
        const Mat3 q = someRotation(0.5f * float(i), 1.3f * float(i));
        scene.addVertex({0.1f * float(i), 0, 0}, {q(2, 0), q(2, 1), q(2, 2)}, {q(0, 0), q(0, 1), q(0, 2)}, open);
    }
    const std::vector<Vec3> radiance = scene.shade();
    for (std::size_t v = 0; v < radiance.size(); ++v) {
        const Mat3 q = toLocalFrame(scene.normals[v], scene.tangents[v]);
        Vec3d expected;
        for (const WeightedDirection& w : gaussHemisphere(16, 32))
            expected += radianceOf(light, toModel(q, w.direction)) * (w.weight * w.direction.z / kPi);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(radiance[v][c], expected[c], 2e-6) << "vertex " << v;
    }
}

// A wall hides all directions with x < 0. D5 keeps the hemisphere's best fit; docs/formulas.md, section 3, has 0.5%
// for Lambert with D5 over many occluders. Measured here: 0.286%.
TEST(VertexShader, LambertBesideAWallIsTheIntegralOverWhatIsOpen) {
    Scene scene;
    const LightFile light = synthetic::light(4, 0.5);
    scene.setMaterial(synthetic::lambert());
    scene.setLight(light);
    const std::vector<float> wall = coefficientsOf(scene.convention, [](Vec3d s) { return s.x > 0; });
    for (int i = 0; i < 8; ++i) {
        const Mat3 q = someRotation(0.9f * float(i), 0.7f * float(i));
        scene.addVertex({}, {q(2, 0), q(2, 1), q(2, 2)}, {q(0, 0), q(0, 1), q(0, 2)}, wall);
    }
    const std::vector<Vec3> radiance = scene.shade();
    double error = 0, squares = 0;
    for (std::size_t v = 0; v < radiance.size(); ++v) {
        const Mat3 q = toLocalFrame(scene.normals[v], scene.tangents[v]);
        Vec3d expected;
        for (const WeightedDirection& w : gaussHemisphere(64, 128))
            if (w.direction.x > 0)
                expected += radianceOf(light, toModel(q, w.direction)) * (w.weight * w.direction.z / kPi);
        for (int c = 0; c < 3; ++c) {
            error += std::pow(radiance[v][c] - expected[c], 2);
            squares += expected[c] * expected[c];
        }
    }
    EXPECT_LT(std::sqrt(error / squares), 0.006);
}

// Every table is noise: slices, numbers and light. The expectation is a quadrature of the product of the three
// functions that the coefficients stand for. Radiances reach 20. Measured: 1.1e-6.
TEST(VertexShader, IsTheIntegralOfTheThreeFunctions) {
    for (const char* name : {"A4", "B3", "D5", "D4"}) {
        Scene scene;
        scene.convention = parseConvention(name);
        synthetic::Noise noise(11);
        BrdfFile brdf;
        for (int i = 0; i < 25 * 15 * 3; ++i) brdf.slices.push_back(noise());
        scene.setMaterial(brdf, 3);
        scene.material.color = {1, 2, 0.5f};
        const LightFile light = synthetic::light(4, 1);
        scene.setLight(light);
        for (int i = 0; i < 3; ++i) {
            std::vector<float> coefficients(std::size_t(scene.convention.size()));
            for (float& n : coefficients) n = noise();
            const Mat3 q = someRotation(2.1f * float(i), 0.4f * float(i));
            scene.addVertex({0, float(i), 0}, {q(2, 0), q(2, 1), q(2, 2)}, {q(0, 0), q(0, 1), q(0, 2)}, coefficients);
        }
        const std::vector<Vec3> radiance = scene.shade();
        const int order = scene.convention.order;
        for (std::size_t v = 0; v < radiance.size(); ++v) {
            const Mat3 q = toLocalFrame(scene.normals[v], scene.tangents[v]);
            const Vec3 o = q * normalized(scene.eye - scene.positions[v]);
            std::vector<float> coefficients(std::size_t(coefficientCount(order))), f(25);
            fullCoefficients(
                scene.convention,
                std::span<const float>(scene.coefficients)
                    .subspan(v * std::size_t(scene.convention.size()), std::size_t(scene.convention.size())),
                coefficients);
            for (std::size_t c = 0; c < 3; ++c) {
                evalSlice(std::span<const float>(scene.slices).subspan(c * 375, 375), 5, 5, o, f);
                double expected = 0;
                for (const WeightedDirection& w : gaussSphere(16, 32)) {
                    std::vector<double> y(25);
                    evalBasis(5, w.direction, y);
                    double slice = 0, visibility = 0;
                    for (std::size_t i = 0; i < 25; ++i) slice += f[i] * y[i];
                    for (std::size_t i = 0; i < coefficients.size(); ++i) visibility += coefficients[i] * y[i];
                    expected += w.weight * slice * visibility * radianceOf(light, toModel(q, w.direction))[int(c)];
                }
                EXPECT_NEAR(radiance[v][int(c)], expected * scene.material.color[int(c)], 1e-5) << name;
            }
        }
    }
}

Scene noiseScene(int vertices, int light_order, int channels) {
    Scene scene;
    synthetic::Noise noise(23);
    BrdfFile brdf;
    for (int i = 0; i < 25 * 15 * 3; ++i) brdf.slices.push_back(noise());
    scene.setMaterial(brdf, channels);
    scene.setLight(synthetic::light(light_order, 1));
    for (int i = 0; i < vertices; ++i) {
        std::vector<float> coefficients(15);
        for (float& n : coefficients) n = noise();
        const Mat3 q = someRotation(4 * noise(), 4 * noise());
        scene.addVertex({noise(), noise(), noise()}, {q(2, 0), q(2, 1), q(2, 2)}, {q(0, 0), q(0, 1), q(0, 2)},
                        coefficients);
    }
    return scene;
}

// Includes counts that are no multiple of 8. Radiances reach 20. Measured: 4.6e-6 (order 8).
TEST(VertexShader, EveryPathAgreesWithThePortableOne) {
    for (int order : {1, 2, 4, 8})
        for (int vertices : {1, 7, 8, 29}) {
            const Scene scene = noiseScene(vertices, order, vertices % 2 ? 3 : 1);
            const std::vector<ShadePath> paths = shadePaths();
            const std::vector<Vec3> expected = scene.shade(&paths[0]);
            for (const ShadePath& path : paths) {
                const std::vector<Vec3> radiance = scene.shade(&path);
                for (std::size_t v = 0; v < radiance.size(); ++v)
                    EXPECT_LT(length(radiance[v] - expected[v]), 2e-5f) << path.name << " order " << order;
            }
        }
}

// Turning normals, view and light together changes nothing. Measured: 3.5e-6.
TEST(VertexShader, TurningEverythingLeavesTheRadiance) {
    const Scene scene = noiseScene(16, 4, 1);
    const std::vector<Vec3> expected = scene.shade();
    const Mat3 turn = someRotation(1.1f, 2.3f);
    Scene turned = scene;
    turned.material.slices = turned.slices;
    for (auto* list : {&turned.positions, &turned.normals, &turned.tangents})
        for (Vec3& v : *list) v = turn * v;
    turned.eye = turn * turned.eye;
    const ShRotation rotation = makeShRotation(4, turn);
    for (std::size_t c = 0; c < 3; ++c) {
        std::vector<float> in(16), out(16);
        for (std::size_t i = 0; i < 16; ++i) in[i] = scene.light[3 * i + c];
        apply(rotation, in, out);
        for (std::size_t i = 0; i < 16; ++i) turned.light[3 * i + c] = out[i];
    }
    turned.light_view.sh = turned.light;
    const std::vector<Vec3> radiance = turned.shade();
    for (std::size_t v = 0; v < radiance.size(); ++v) EXPECT_LT(length(radiance[v] - expected[v]), 2e-5f);
}

TEST(VertexShader, ViewFromBehindIsMirroredAtTheTangentPlane) {
    Scene scene = noiseScene(1, 4, 1);
    const Vec3 n = scene.normals[0], to_eye = scene.eye - scene.positions[0];
    const Vec3 front = scene.shade()[0];
    scene.eye = scene.positions[0] + to_eye - 2 * dot(to_eye, n) * n;
    EXPECT_LT(length(scene.shade()[0] - front), 1e-5f);  // measured: 1.7e-6
    scene.eye = scene.positions[0];                      // no direction at all: taken as the normal
    const Vec3 nowhere = scene.shade()[0];
    scene.eye = scene.positions[0] + n;
    EXPECT_LT(largestDifference(nowhere, scene.shade()[0]), 1e-5);
}

// The fixed axes span every band: noise of order 8 comes back to float precision. Measured: 2.9e-6; sums reach 10.
TEST(VertexShader, LobesReproduceALightOfAnyOrder) {
    for (int order = 1; order <= kMaxOrder; ++order) {
        Scene scene;
        const LightFile light = synthetic::light(order, 1);
        BrdfFile brdf;  // f = y_0 of the view times every y_k: with V = y_0-like numbers the result is a sum of light
        brdf.slice_order = kMaxOrder;
        brdf.slices.assign(std::size_t(coefficientCount(kMaxOrder)) * 15 * 3, 0.0);
        synthetic::Noise noise(31);
        std::vector<float> f(std::size_t(coefficientCount(kMaxOrder)));
        for (std::size_t k = 0; k < f.size(); ++k) {
            f[k] = noise();
            for (std::size_t c = 0; c < 3; ++c) brdf.slices[k * 45 + c] = f[k] * std::sqrt(4 * kPi);
        }
        scene.setMaterial(brdf);
        scene.setLight(light);
        std::vector<float> coefficients(15);
        coefficients[0] = float(std::sqrt(4 * kPi));  // V = 1 on the whole sphere
        scene.addVertex({}, {0, 0, 1}, {1, 0, 0}, coefficients);
        const Vec3 radiance = scene.shade()[0];
        for (int c = 0; c < 3; ++c) {
            double expected = 0;
            for (std::size_t i = 0; i < std::size_t(order * order); ++i)
                expected += f[i] * light.sh[3 * i + std::size_t(c)];
            EXPECT_NEAR(radiance[c], expected, 2e-5)
                << "order " << order;  // measured: see the failure text when it grows
        }
    }
}

// The integral of V cos y_i itself. D6 is what casters leave visible, the others are of assets. Measured: 2.4e-7.
TEST(VisibilityTransfer, IsTheIntegralOfVisibilityCosineAndSh) {
    const Mat3 q = someRotation(0.7f, 1.9f);
    for (const char* name : {"A4", "B5", "D5", "D6"}) {
        const Convention convention = parseConvention(name);
        const std::vector<float> coefficients =
            coefficientsOf(convention, [](Vec3d s) { return s.x + 0.3 * s.z > 0.2; });
        std::vector<float> function(std::size_t(coefficientCount(convention.order)));
        fullCoefficients(convention, coefficients, function);
        std::vector<double> expected(25), v(function.size()), y(25);
        for (const WeightedDirection& d : gaussHemisphere(16, 32)) {
            evalBasis(convention.order, d.direction, v);
            double visible = 0;
            for (std::size_t i = 0; i < v.size(); ++i) visible += v[i] * double(function[i]);
            evalBasis(5, toModel(q, d.direction), y);
            for (std::size_t i = 0; i < 25; ++i) expected[i] += d.weight * d.direction.z * visible * y[i];
        }
        const VisibilityTransfer transfer(convention);
        for (const int order : {1, 3, 5}) {
            std::vector<float> found(std::size_t(coefficientCount(order)));
            transfer.apply(coefficients, q, order, found);
            for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-6) << name << i;
        }
    }
}

TEST(Ambient, IsOneWhereNothingIsInTheWay) {
    for (const char* name : {"A4", "B4", "D5"}) {
        const Convention convention = parseConvention(name);
        std::vector<float> coefficients = coefficientsOf(convention, [](Vec3d) { return true; });
        const std::vector<float> half = coefficientsOf(convention, [](Vec3d s) { return s.x > 0; });
        coefficients.insert(coefficients.end(), half.begin(), half.end());
        std::vector<float> e(2);
        ambient(convention, convention.size(), coefficients, e);
        EXPECT_NEAR(e[0], 1, name[0] == 'B' ? 0.02 : 1e-5) << name;
        EXPECT_NEAR(e[1], 0.5, name[0] == 'B' ? 0.02 : 1e-5) << name;
    }
}

}  // namespace
}  // namespace penumbra::test_shading
