#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "sh/cast/cast_fold.h"
#include "sh/cast/cast_visibility.h"
#include "sh/cast/log_visibility.h"
#include "sh/mirrored_product.h"
#include "sh/reflectance.h"
#include "sh/sh_product.h"
#include "sh/sh_rotation.h"
#include "tests/sh/caster_scenes.h"
#include "tests/sh/slice_transfer.h"

namespace penumbra::test_cast_fold {
namespace {

// [16][3] of a golden file, row after row.
std::vector<double> flat(const nlohmann::json& rows) {
    std::vector<double> out;
    for (const auto& row : rows)
        for (const auto& value : row) out.push_back(value);
    return out;
}

std::vector<double> channel(const std::vector<double>& rgb, std::size_t c) {
    std::vector<double> out;
    for (std::size_t i = c; i < rgb.size(); i += 3) out.push_back(rgb[i]);
    return out;
}

std::vector<float> inFloats(const std::vector<double>& values) {
    return std::vector<float>(values.begin(), values.end());
}

double dotOf(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
}

// Radiance of a case under a light [16][3] in the model frame, in double precision.
std::vector<double> radianceOf(const nlohmann::json& test, const nlohmann::json& slices,
                               const std::vector<double>& light) {
    const Mat3d q = localFrame(vec3(test.at("normal")), vec3(test.at("tangent")));
    const Vec3d to_eye = q * normalized(vec3(test.at("eye")) - vec3(test.at("position")));
    const std::vector<double> t = transferOf(test.at("d5"), sliceOf(slices, to_eye));
    std::vector<double> radiance;
    for (std::size_t c = 0; c < 3; ++c) {
        std::vector<double> local(16);
        apply(makeShRotation(4, q), channel(light, c), local);
        radiance.push_back(dotOf(local, t));
    }
    return radiance;
}

// The spheres of a person, to the visibility past them, to the light that is left, to radiance.
TEST(CastFold, MatchesGolden) {
    const auto golden = readGolden("cast_and_self.json");
    const double tolerance = golden.at("tol"), float_tolerance = golden.at("tol_float");
    EXPECT_EQ(golden.at("even_index").get<std::vector<int>>(), evenIndices(5));
    ASSERT_EQ(golden.at("cases").size(), 8u);
    for (const auto& test : golden.at("cases")) {
        const std::vector<CasterSphereD> spheres = goldenSpheres(test.at("centres"), test.at("radii"));
        const Vec3d position = vec3(test.at("position"));
        int used = 0;
        for (const CasterSphereD& sphere : spheres) used += capOf(sphere, position).angle > 0;
        EXPECT_EQ(used, test.at("spheres_used").get<int>());

        const ExpOptions plain = {ExpMethod::kHybPs2, false};
        const std::vector<double> log = netLogAt(5, spheres, position);
        std::vector<double> cast(25), folded(48);
        expOfLog(expTablesD(5), plain, log, cast);
        expectNear(cast, doubles(test.at("cast_order5")), tolerance);
        EXPECT_EQ(squaringCount(plain, std::sqrt(dotOf(log, log) - log[0] * log[0])), test.at("squarings").get<int>());
        const std::vector<double> light = flat(test.at("light_sh"));
        for (std::size_t c = 0; c < 3; ++c) {
            std::vector<double> product(16);
            multiply(4, channel(light, c), 4, cast, 5, product);
            for (std::size_t i = 0; i < 16; ++i) folded[3 * i + c] = product[i];
        }
        expectNear(folded, flat(test.at("folded_light")), tolerance);
        for (const char* brdf : {"lambert", "ggx_.3"}) {
            const auto& slices = golden.at("slices").at(brdf);
            expectNear(radianceOf(test, slices, folded), doubles(test.at(brdf).at("radiance")), tolerance);
            expectNear(radianceOf(test, slices, light), doubles(test.at(brdf).at("radiance_without_cast")), tolerance);
        }

        // The same in single precision, as the run time computes it.
        std::vector<float> cast_floats(25), folded_floats(48);
        expOfLog(expTables(5), plain, netLogAt(5, inFloats(spheres), toFloat(position)), cast_floats);
        foldCast(makeCastFold(4, inFloats(light), 5), cast_floats, folded_floats);
        const std::vector<double> floats(folded_floats.begin(), folded_floats.end());
        expectNear(floats, flat(test.at("folded_light")), float_tolerance);
        for (const char* brdf : {"lambert", "ggx_.3"})
            expectNear(radianceOf(test, golden.at("slices").at(brdf), floats), doubles(test.at(brdf).at("radiance")),
                       float_tolerance);
    }
}

// D5 of a case times the visibility past its spheres, mirrored at the horizon, as scenes compute it.
nlohmann::json castD5(const nlohmann::json& test) {
    const std::vector<CasterSphere> spheres = inFloats(goldenSpheres(test.at("centres"), test.at("radii")));
    const std::vector<Vec3> at = {toFloat(vec3(test.at("position")))}, normal = {toFloat(vec3(test.at("normal")))},
                            tangent = {toFloat(vec3(test.at("tangent")))};
    std::vector<float> cast(kMirroredCast), product(15);
    castMirrored(spheres, {at, normal, tangent}, {}, cast);
    multiplyMirrored(5, inFloats(doubles(test.at("d5"))), 5, cast, 6, product);
    return product;
}

// Both ways against brute force, over all cases, colours and materials. Measured, relative: 0.040 and 0.026; 0.24
// without the casters.
TEST(CastFold, MirroredProductsAreNoFartherFromBruteForce) {
    const auto golden = readGolden("cast_and_self.json");
    double fold = 0, mirrored = 0, none = 0;
    for (auto test : golden.at("cases")) {
        const std::vector<double> light = flat(test.at("light_sh"));
        const nlohmann::json product = castD5(test);
        for (const char* brdf : {"lambert", "ggx_.3"}) {
            const nlohmann::json& figures = test.at(brdf);
            const std::vector<double> truth = doubles(figures.at("brute_force")),
                                      folded = doubles(figures.at("radiance")),
                                      alone = doubles(figures.at("radiance_without_cast"));
            nlohmann::json with_product = test;
            with_product["d5"] = product;
            const std::vector<double> ours = radianceOf(with_product, golden.at("slices").at(brdf), light);
            for (std::size_t c = 0; c < 3; ++c) {
                fold += std::pow(folded[c] - truth[c], 2);
                mirrored += std::pow(ours[c] - truth[c], 2);
                none += std::pow(alone[c] - truth[c], 2);
            }
        }
    }
    EXPECT_LT(mirrored, fold);
    EXPECT_LT(mirrored, 0.1 * none);
}

TEST(CastFold, WithFreeSightChangesNothing) {
    std::vector<float> light(48), one(25), out(48);
    for (std::size_t i = 0; i < light.size(); ++i) light[i] = float(std::sin(double(i)));
    one[0] = float(std::sqrt(4 * std::acos(-1.0)));
    foldCast(makeCastFold(4, light, 5), one, out);
    for (std::size_t i = 0; i < light.size(); ++i) EXPECT_NEAR(out[i], light[i], 1e-6);
}

}  // namespace
}  // namespace penumbra::test_cast_fold
