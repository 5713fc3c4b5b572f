// The modes that compare: light that is folded, and the ways of Nowrouzezahrai 2009 and 2011.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "formats/common/errors.h"
#include "player/papers/cast_shader.h"
#include "player/scene/scene_receivers.h"
#include "tests/sh/caster_scenes.h"

namespace penumbra::test_cast_shader {
namespace {

std::vector<float> flatFloats(const nlohmann::json& rows) {
    std::vector<float> out;
    for (const auto& row : rows)
        for (const auto& value : row) out.push_back(value.get<float>());
    return out;
}

// A case of the golden file as an asset of one vertex.
struct GoldenReceiver {
    std::vector<float> slices, light;
    AssetView asset;
    FrameVertices vertices;
    Vec3 eye;
    Shot shot;
    std::vector<CasterSphere> spheres;

    GoldenReceiver(const nlohmann::json& golden, const nlohmann::json& test, const char* material)
        : slices(flatFloats(golden.at("slices").at(material))), light(flatFloats(test.at("light_sh"))) {
        vertices.positions = {toFloat(vec3(test.at("position")))};
        vertices.normals = {toFloat(vec3(test.at("normal")))};
        vertices.tangents = {toFloat(vec3(test.at("tangent")))};
        for (const auto& number : test.at("d5")) vertices.coefficients.push_back(number.get<float>());
        vertices.coefficients.push_back(0);
        eye = toFloat(vec3(test.at("eye")));
        spheres = inFloats(goldenSpheres(test.at("centres"), test.at("radii")));
        asset.has_mesh = asset.has_model = true;
        asset.mesh.positions = vertices.positions;
        asset.model.convention = parseConvention("D5");
        asset.model.stride = 16;
        MaterialView view;
        view.name = material;
        view.slice_order = view.view_order = 5;
        view.channels = 1;
        view.slices = slices;
        asset.materials = {view};
        asset.lights = {{"light", 4, light}};
        shot.asset = &asset;
        shot.shaded = true;
        shot.material_of_slot = {0};
    }
    GoldenReceiver(const GoldenReceiver&) = delete;
    GoldenReceiver& operator=(const GoldenReceiver&) = delete;

    Vec3 radiance(CastMode mode, SphereCast cast) {
        std::vector<Vec3> out;
        CastShader(mode, shot).shade(vertices, cast, eye, 1, out);
        return out.at(0);
    }
    std::vector<float> castBySpheres(CastMode mode) const {
        std::vector<double> v(std::size_t(coefficientCount(castOrderOf(mode))));
        castReference({}, castOrderOf(mode), spheres, vertices.positions[0], {}, v);
        return std::vector<float>(v.begin(), v.end());
    }
};

std::vector<float> openCast(CastMode mode) {
    std::vector<float> cast(std::size_t(coefficientCount(castOrderOf(mode))));
    cast[0] = float(std::sqrt(4 * std::acos(-1.0)));
    return cast;
}

// The golden V_c in, the golden radiance out.
TEST(CastShader, FoldedMatchesGolden) {
    const auto golden = readGolden("cast_and_self.json");
    for (const auto& test : golden.at("cases"))
        for (const char* material : {"lambert", "ggx_.3"}) {
            GoldenReceiver receiver(golden, test, material);
            std::vector<float> cast;
            for (const auto& number : test.at("cast_order5")) cast.push_back(number.get<float>());
            const Vec3 folded = receiver.radiance(CastMode::kFolded, cast);
            const Vec3 alone = receiver.radiance(CastMode::kFolded, openCast(CastMode::kFolded));
            for (int c = 0; c < 3; ++c) {
                const auto& figures = test.at(material);
                EXPECT_NEAR(folded[c], std::max(0.0, figures.at("radiance").at(c).get<double>()), 5e-5);
                EXPECT_NEAR(alone[c], std::max(0.0, figures.at("radiance_without_cast").at(c).get<double>()), 5e-5);
            }
        }
}

// Against the brute force of all golden cases, the papers' ways err more than folding does, and less than no cast.
TEST(CastShader, PapersErrMoreThanFolding) {
    const auto golden = readGolden("cast_and_self.json");
    std::array<double, kCastModes> squares{};
    double none = 0;
    for (const auto& test : golden.at("cases")) {
        GoldenReceiver receiver(golden, test, "lambert");
        const Vec3d truth = vec3(test.at("lambert").at("brute_force"));
        for (const CastMode mode : {CastMode::kFolded, CastMode::kSphereProduct, CastMode::kHemisphereShare}) {
            const Vec3 ours = receiver.radiance(mode, receiver.castBySpheres(mode));
            for (int c = 0; c < 3; ++c) squares[std::size_t(mode)] += std::pow(double(ours[c]) - truth[c], 2);
        }
        const Vec3 alone = receiver.radiance(CastMode::kFolded, openCast(CastMode::kFolded));
        for (int c = 0; c < 3; ++c) none += std::pow(double(alone[c]) - truth[c], 2);
    }
    EXPECT_LT(squares[std::size_t(CastMode::kFolded)], squares[std::size_t(CastMode::kSphereProduct)]);
    EXPECT_LT(squares[std::size_t(CastMode::kFolded)], squares[std::size_t(CastMode::kHemisphereShare)]);
    EXPECT_LT(squares[std::size_t(CastMode::kSphereProduct)], 0.5 * none);
}

// Free sight becomes 1 over the sphere in every convention, and its share of the hemisphere is 1.
TEST(CastShader, FreeSightStaysFree) {
    for (const char* name : {"D5", "A4", "A6", "B5", "D3"}) {
        const Convention convention = parseConvention(name);
        std::vector<float> coefficients = freeSight(convention);
        const std::vector<float> a4 = ownInA4(convention, int(coefficients.size()), coefficients);
        ASSERT_EQ(a4.size(), 16u);
        for (std::size_t i = 0; i < 16; ++i)
            EXPECT_NEAR(a4[i], i == 0 ? std::sqrt(4 * std::acos(-1.0)) : 0.0, 2e-5) << name << " " << i;
        const std::vector<float> before = coefficients;
        keepHemisphereShare(convention, int(coefficients.size()), coefficients);
        for (std::size_t i = 0; i < coefficients.size(); ++i) EXPECT_NEAR(coefficients[i], before[i], 1e-5) << name;
    }
}

// Nowrouzezahrai 2011 scales what an open receiver reflects by the share of the hemisphere that it sees.
TEST(CastShader, HemisphereShareScalesOpenRadianceByTheShare) {
    const auto golden = readGolden("cast_and_self.json");
    const auto& test = golden.at("cases").at(2);
    GoldenReceiver receiver(golden, test, "ggx_.3");
    const std::vector<float> cast = receiver.castBySpheres(CastMode::kHemisphereShare);
    const float share = receiver.vertices.coefficients[0] / float(std::sqrt(4 * std::acos(-1.0)));
    EXPECT_LT(share, 0.99f);
    const Vec3 scaled = receiver.radiance(CastMode::kHemisphereShare, cast);
    const std::vector<float> open = freeSight(receiver.asset.model.convention);
    std::copy(open.begin(), open.end(), receiver.vertices.coefficients.begin());
    const Vec3 whole = receiver.radiance(CastMode::kFolded, cast);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(scaled[c], share * whole[c], 2e-5);
}

// E past nobody is E of the own numbers, in every mode that keeps them.
TEST(CastShader, AmbientPastNobodyIsOnesOwn) {
    const auto golden = readGolden("cast_and_self.json");
    for (const auto& test : golden.at("cases")) {
        GoldenReceiver receiver(golden, test, "lambert");
        const FrameVertices& own = receiver.vertices;
        std::vector<float> expected(1);
        ambient(receiver.asset.model.convention, 16, own.coefficients, expected);
        const auto e = [&](CastMode mode) { return castAmbient(mode, receiver.asset.model, own, openCast(mode))[0]; };
        EXPECT_NEAR(e(CastMode::kFolded), expected[0], 1e-5);
        EXPECT_NEAR(e(CastMode::kSphereProduct), expected[0],
                    0.03);  // 4 bands of a step at the horizon; 0.02 was measured
    }
}

// An open ground under radiance 1 has E and, for a white albedo, radiance 1.
TEST(GroundWeights, OfFreeSightIsTheLight) {
    const std::vector<float> white = {float(std::sqrt(4 * std::acos(-1.0))), 0, 0};
    for (const CastMode mode : {CastMode::kFolded, CastMode::kSphereProduct, CastMode::kHemisphereShare}) {
        const float open = openCast(mode)[0];
        EXPECT_NEAR(groundWeights(mode, {}, 1)[0].x * open, 1, 1e-5);
        EXPECT_NEAR(groundWeights(mode, white, 1)[0].x * open, 1, 1e-5);
        EXPECT_NEAR(groundWeights(mode, white, 1)[0].y, 0, 1e-9);
    }
}

}  // namespace
}  // namespace penumbra::test_cast_shader
