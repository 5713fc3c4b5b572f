// Tests materials of parts, lights and their rotation, switched on the CPU: results equal shading every vertex on its
// own.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading_set.h"
#include "sh/light/light_rotation.h"
#include "sh/reflectance.h"
#include "sh/sh_product.h"
#include "sh/sh_rotation.h"
#include "sh/zonal.h"
#include "tests/difference.h"
#include "tests/posed_vertices.h"
#include "tests/runtime/count_allocations.h"
#include "tests/runtime/synthetic_asset.h"

namespace penumbra::test_shading_set {
namespace {

using player_test::SyntheticAsset;

const std::array<ShadingChoice, 6> kChoices = {{{Reflectance::kSlices, LightForm::kLobes},
                                                {Reflectance::kSlices, LightForm::kFixed},
                                                {Reflectance::kSlices, LightForm::kRotation},
                                                {Reflectance::kOperators, LightForm::kLobes},
                                                {Reflectance::kOperators, LightForm::kFixed},
                                                {Reflectance::kOperators, LightForm::kRotation}}};

std::string nameOf(const ShadingChoice& choice) {
    return std::string(choice.reflectance == Reflectance::kSlices ? "slices" : "operators") + " form " +
           std::to_string(int(choice.light_form));
}

Mat3 rotationOf(const char* text) {
    const Mat3d r = parseLightRotation(text);
    Mat3 out;
    for (std::size_t i = 0; i < 9; ++i) out.m[i] = float(r.m[i]);
    return out;
}

constexpr Vec3 kEye{0.5f, 1, 3};

// The vertices of one posed frame.
PosedArrays posedAt1(const AssetView& asset) {
    Evaluator evaluator(asset);
    evaluator.setPose(asset.animation.bonesOf(1), {});
    return PosedArrays(evaluator);
}

// Equality is bit for bit, in pieces of any size, as each vertex sees the same operations in its lane.
TEST(ShadingSet, EveryPartHasItsMaterial) {
    for (const char* convention : {"D5", "A4"}) {
        const SyntheticAsset data({.convention = convention, .rings = 8, .slots = 3});
        const PosedArrays posed = posedAt1(data.asset);
        for (const ShadingChoice& choice : kChoices) {
            ShadingSet set(data.asset, choice);
            EXPECT_EQ(set.slotCount(), 3u);
            for (const std::array<std::size_t, 3>& materials : {std::array<std::size_t, 3>{0, 1, 2}, {2, 2, 1}}) {
                for (std::size_t s = 0; s < 3; ++s) set.setMaterial(s, materials[s]);
                const std::vector<Vec3> radiance = posed.shade(set, kEye), pieces = posed.shade(set, kEye, 13);
                EXPECT_EQ(radiance, pieces);
                for (std::size_t s = 0; s < 3; ++s) {
                    const VertexShader one(data.asset.model.convention, data.asset.model.stride,
                                           data.asset.materials[materials[s]], data.asset.lights[0], choice);
                    const std::vector<Vec3> expected = posed.shade(one, kEye);
                    for (std::size_t v = s; v < radiance.size(); v += 3)  // vertex v belongs to part v % 3
                        EXPECT_EQ(radiance[v], expected[v]) << nameOf(choice) << " vertex " << v;
                }
            }
        }
    }
}

// The last vertices of a part fill no block of lanes.
TEST(ShadingSet, ShadesSomeVerticesAsAllOfThem) {
    const SyntheticAsset data({.rings = 8, .slots = 3});
    const PosedArrays posed = posedAt1(data.asset);
    std::vector<std::uint32_t> some;
    for (std::uint32_t slot = 0; slot < 3; ++slot)  // vertex v belongs to part v % 3
        for (std::uint32_t v = slot; v < posed.positions.size(); v += 6) some.push_back(v);
    for (const ShadingChoice& choice : kChoices) {
        const ShadingSet set(data.asset, choice);
        const std::vector<Vec3> expected = posed.shade(set, kEye);
        std::vector<Vec3> radiance(expected.size());
        set.shadeSome(some, posed.all(), kEye, radiance);
        for (const std::uint32_t v : some) EXPECT_EQ(radiance[v], expected[v]) << nameOf(choice) << " vertex " << v;
    }
}

// Without any setting the asset's own materials and first light are on. A mesh without parts has one part.
TEST(ShadingSet, BeginsWithWhatTheAssetSays) {
    SyntheticAsset data({.rings = 6, .slots = 2});
    data.asset.slot_material = {2, 1};
    const ShadingSet set(data.asset);
    EXPECT_EQ(std::vector<std::uint16_t>(set.materialOfSlot().begin(), set.materialOfSlot().end()),
              data.asset.slot_material);
    EXPECT_EQ(set.light(), 0u);
    const SyntheticAsset plain({.rings = 6});
    EXPECT_EQ(ShadingSet(plain.asset).slotCount(), 1u);
    EXPECT_TRUE(ShadingSet(plain.asset).shadingOrder().empty()) << "one material: the arrays as they lie";
}

// The synthetic asset's fitted lobes are its light exactly, and its operators are its slices exactly, so that every
// way gives the same radiance. Radiances reach 1.5. Measured: 3.2e-6 at order 8, whose fixed lobes have condition 47.
TEST(ShadingSet, EveryWayGivesTheSameRadiance) {
    for (const int order : {1, 2, 4, 8})
        for (const char* convention : {"D5", "A4"}) {
            const SyntheticAsset data({.convention = convention, .rings = 8, .light_order = order, .slots = 3});
            const PosedArrays posed = posedAt1(data.asset);
            std::vector<Vec3> expected;
            for (const ShadingChoice& choice : kChoices) {
                ShadingSet set(data.asset, choice);
                set.setLightRotation(rotationOf("yaw=40,pitch=-25,roll=160"));
                const std::vector<Vec3> radiance = posed.shade(set, kEye);
                if (expected.empty()) expected = radiance;
                EXPECT_LT(largestDifference(radiance, expected), 2e-6f) << nameOf(choice) << " order " << order;
            }
        }
}

// The normals of some frames are at or near the pole of the turns, where the first angle is ill defined; others are
// everywhere else. Compares the exact rotation with the fixed lobes. Radiances reach 0.3. Measured: 2.7e-7.
TEST(ShadingSet, RotationIsExactAtThePoles) {
    const SyntheticAsset data({.rings = 6, .light_order = 6});
    const MaterialView& material = data.asset.materials[1];
    std::vector<float> light(3 * 36), coefficients;
    for (std::size_t i = 0; i < light.size(); ++i) light[i] = float(std::sin(1.7 * double(i)));
    const LightView view{"noise", 6, light};
    std::vector<Vec3> positions, normals, tangents;
    for (const float tilt : {0.0f, 1e-30f, 1e-12f, 1e-7f, 1e-4f, 1e-2f, 0.5f})
        for (const float sign : {1.0f, -1.0f})
            for (int turn = 0; turn < 5; ++turn) {
                const Vec3 n = normalized(Vec3{tilt, 0.3f * tilt, sign});
                const Vec3 t{std::cos(float(turn)), std::sin(float(turn)), 0};
                positions.push_back({});
                normals.push_back(n);
                tangents.push_back(normalized(t - n * dot(n, t)));
                for (int i = 0; i < 15; ++i) coefficients.push_back(std::cos(float(i + turn)));
            }
    std::vector<Vec3> radiance[2] = {std::vector<Vec3>(positions.size()), std::vector<Vec3>(positions.size())};
    for (const bool rotation : {false, true}) {
        const VertexShader shader(parseConvention("D5"), 15, material, view,
                                  {Reflectance::kSlices, rotation ? LightForm::kRotation : LightForm::kFixed});
        shader.shade({positions, normals, tangents, coefficients, 0, positions.size()}, {1, 2, 3}, radiance[rotation]);
    }
    EXPECT_LT(largestDifference(radiance[0], radiance[1]), 1e-6f);
}

// The lobes are no light's exact ones, in the convention of the file (docs/formulas.md, section 1). What is shaded is
// the SH light that they add up to. Measured: 3.0e-7.
TEST(ShadingSet, FittedLobesAreTheLightThatTheyAddUpTo) {
    SyntheticAsset data({.rings = 8, .light_order = 4});
    const std::vector<Vec3> directions = {normalized(Vec3{1, 2, 3}), normalized(Vec3{-2, 0.3f, 1}), {0, 0, -1}};
    std::vector<float> z;
    for (int i = 0; i < 3 * 4 * 3; ++i) z.push_back(std::cos(float(i)));
    std::vector<double> light(3 * 16), lobe(16);
    for (std::size_t d = 0; d < 3; ++d)
        for (std::size_t c = 0; c < 3; ++c) {
            const std::vector<double> bands = {z[(4 * d + 0) * 3 + c], z[(4 * d + 1) * 3 + c], z[(4 * d + 2) * 3 + c],
                                               z[(4 * d + 3) * 3 + c]};
            rotateZonal(bands, toDouble(directions[d]), lobe);
            for (std::size_t i = 0; i < 16; ++i) light[3 * i + c] += lobe[i];
        }
    const std::vector<float> sh(light.begin(), light.end());
    data.asset.lights = {{"lobes", 4, sh, {directions, z}}};
    const PosedArrays posed = posedAt1(data.asset);
    const Mat3 rotation = rotationOf("yaw=25,roll=110");
    ShadingSet lobes(data.asset, {Reflectance::kSlices, LightForm::kLobes}), exact(data.asset);
    for (std::size_t m = 0; m < 3; ++m) {
        for (ShadingSet* set : {&lobes, &exact}) {
            set->setMaterial(m);
            set->setLightRotation(rotation);
        }
        EXPECT_LT(largestDifference(posed.shade(lobes, kEye), posed.shade(exact, kEye)), 1e-6f);
    }
}

// Goes through every path, every way and every number of lanes that are left over. Radiances reach 0.9. Measured:
// 1.9e-7.
TEST(ShadingSet, EveryPathAgreesWithThePortableOne) {
    for (const int order : {1, 3, 4, 8}) {
        const SyntheticAsset data({.rings = 6, .light_order = order, .slots = 3});
        const PosedArrays posed = posedAt1(data.asset);
        for (const ShadingChoice& choice : kChoices) {
            ShadingSet set(data.asset, choice);
            set.setLightRotation(rotationOf("axis=1/2/3,angle=50"));
            set.usePath(shadePaths().front());
            const std::vector<Vec3> expected = posed.shade(set, kEye);
            for (const ShadePath& path : shadePaths()) {
                set.usePath(path);
                EXPECT_LT(largestDifference(posed.shade(set, kEye), expected), 1e-6f)
                    << path.name << " " << nameOf(choice);
            }
        }
    }
}

// A turned light is the light whose coefficients were turned beforehand. A second rotation replaces the first, and a
// light that is switched on is turned as the one before. Radiances reach 1. Measured: 2.4e-7.
TEST(ShadingSet, TurnsTheLightAsItsCoefficientsTurn) {
    const SyntheticAsset data({.rings = 8});
    const PosedArrays posed = posedAt1(data.asset);
    const Mat3 rotation = rotationOf("yaw=70,pitch=20,roll=-30");
    const LightView& sky = data.asset.lights[0];
    std::vector<float> turned(sky.sh.size());
    for (std::size_t c = 0; c < 3; ++c) {
        std::vector<float> from(16), to(16);
        for (std::size_t i = 0; i < 16; ++i) from[i] = sky.sh[3 * i + c];
        apply(makeShRotation(4, rotation), from, to);
        for (std::size_t i = 0; i < 16; ++i) turned[3 * i + c] = to[i];
    }
    for (const LightForm form : {LightForm::kLobes, LightForm::kFixed, LightForm::kRotation}) {
        const VertexShader expected(data.asset.model.convention, data.asset.model.stride, data.asset.materials[0],
                                    {"turned", 4, turned});
        ShadingSet set(data.asset, {Reflectance::kSlices, form});
        set.setLightRotation(rotationOf("yaw=5"));
        set.setLight(1);
        set.setLightRotation(rotation);
        set.setLight(0);
        EXPECT_LT(largestDifference(posed.shade(set, kEye), posed.shade(expected, kEye)), 1e-6f) << int(form);
    }
}

TEST(ShadingSet, SwitchingAllocatesNothing) {
    const SyntheticAsset data({.rings = 6, .light_order = 6, .slots = 3});
    const PosedArrays posed = posedAt1(data.asset);
    std::vector<Vec3> radiance(posed.positions.size());
    const Mat3 rotation = rotationOf("yaw=70");
    for (const ShadingChoice& choice : kChoices) {
        ShadingSet set(data.asset, choice);
        const std::size_t before = allocationCount();
        const std::uint64_t materials = set.materialVersion();
        for (std::size_t i = 0; i < 12; ++i) {
            set.setMaterial(i % 3, i % 2);
            set.setLight(i % 2);
            set.setLightRotation(rotation);
            set.shade(posed.all(), kEye, radiance);
        }
        EXPECT_EQ(allocationCount(), before) << nameOf(choice);
        EXPECT_GT(set.materialVersion(), materials);
    }
}

TEST(ShadingSet, WhatLacksTheFormCannotBeOn) {
    SyntheticAsset data({.rings = 6});
    data.asset.materials[1].operators = {};
    data.asset.lights[1].lobes = {};
    const ShadingSet set(data.asset, {Reflectance::kOperators, LightForm::kLobes});
    EXPECT_TRUE(set.hasMaterial(0));
    EXPECT_FALSE(set.hasMaterial(1));
    EXPECT_TRUE(set.hasLight(0));
    EXPECT_FALSE(set.hasLight(1));
    const ShadingSet other(data.asset);
    EXPECT_TRUE(other.hasMaterial(1));
    EXPECT_TRUE(other.hasLight(1));
}

// Writes eq 11 of Nowrouzezahrai 2009 in double precision as it stands: L = sum_b (w^b . y_even(omega_o)) l^T M^b v
// with M^b_ij = sum_k u^b_k Gamma_ijk, everything in the local frame. Operators are random, with several orders of u
// (truncated and exact products) and counts. Radiances reach 5. Measured: 2.4e-6.
TEST(Operators, AreThePapersFormula) {
    std::uint32_t seed = 5;
    const auto noise = [&] { return float((seed = seed * 1664525u + 1013904223u) / 2147483648.0 - 1); };
    for (const char* name : {"D5", "A4"})
        for (const int order_u : {4, 7})
            for (const int count : {1, 8, 16}) {
                const Convention convention = parseConvention(name);
                const std::size_t coefficients = std::size_t(convention.size()), size = std::size_t(order_u * order_u);
                std::vector<float> u(3 * std::size_t(count) * size), w(3 * std::size_t(count) * 15), l(3 * 16), v;
                for (auto* values : {&u, &w, &l})
                    for (float& x : *values) x = noise();
                for (std::size_t i = 0; i < coefficients; ++i) v.push_back(noise());
                MaterialView material{"m", 5, 5, 3, {1, 0.5f, 2}, {}, {count, order_u, u, w}};
                const VertexShader shader(convention, int(coefficients), material, {"l", 4, l},
                                          {Reflectance::kOperators, LightForm::kRotation});
                const Vec3 p{}, n{0, 0, 1}, t{1, 0, 0}, eye{0.3f, 0.5f, 0.9f};  // local frame = model frame
                Vec3 radiance;
                shader.shade({{&p, 1}, {&n, 1}, {&t, 1}, v, 0, 1}, eye, {&radiance, 1});

                std::vector<double> y(25);
                evalBasis(5, normalized(toDouble(eye)), y);
                const std::vector<int> even = evenIndices(5), indices = convention.indices();
                for (std::size_t c = 0; c < 3; ++c) {
                    double expected = 0;
                    for (std::size_t b = 0; b < std::size_t(count); ++b) {
                        const std::size_t set = c * std::size_t(count) + b;
                        double weight = 0, product = 0;
                        for (std::size_t e = 0; e < 15; ++e)
                            weight += double(w[set * 15 + e]) * y[std::size_t(even[e])];
                        for (const TripleProductEntry& g : tripleProduct(4, convention.order, order_u))
                            for (std::size_t j = 0; j < coefficients; ++j)
                                if (indices[j] == g.j)
                                    product +=
                                        double(l[3 * g.i + c]) * g.value * double(u[set * size + g.k]) * double(v[j]);
                        expected += weight * product;
                    }
                    EXPECT_NEAR(radiance[int(c)], expected * double(material.color[int(c)]), 1e-5)
                        << name << " k=" << count << " order " << order_u;
                }
            }
}

}  // namespace
}  // namespace penumbra::test_shading_set
