// Tests the GLSL of sphere casters in shaders of an engine: a compute shader with storage buffers, and a fragment
// shader with texture buffers. Texts and tables come out of the C interface. They give what the CPU gives.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "runtime/cast/cast_shadow.h"
#include "sh/cast/cast_visibility.h"
#include "sh/tangent.h"
#include "tests/capi/packed_asset.h"
#include "tests/player/cast_shaders.h"

namespace penumbra::test_cast_glsl {
namespace {

using namespace capi_test;
using namespace player_test;

// For each receiver: visibility [25], mirrored [21], E, whether any sphere counts; then its numbers.
constexpr CastShaders kSphereShaders{R"(
layout(std430, binding = 0) readonly buffer Spheres { vec4 spheres[]; };
layout(std430, binding = 1) readonly buffer CapLogs { vec4 cap_logs[]; };
#define PENUMBRA_SPHERE(i) spheres[i]
#define PENUMBRA_CAP_LOG(i) cap_logs[i]
)",
                                     R"(
uniform samplerBuffer spheres, cap_logs;
#define PENUMBRA_SPHERE(i) texelFetch(spheres, i)
#define PENUMBRA_CAP_LOG(i) texelFetch(cap_logs, i)
)",
                                     R"(
void castAt(vec3 place, mat3 local_from_scene, inout float result[RESULTS + NUMBERS], out float mirrored[21]) {
    float visibility[25];
    bool seen = penumbra_cast_visibility(sphere_count, ivec2(left_out_begin, left_out_end), place, local_from_scene,
                                         visibility);
    penumbra_cast_mirror(visibility, mirrored);
    for (int i = 0; i < 25; ++i) result[i] = visibility[i];
    for (int i = 0; i < 21; ++i) result[25 + i] = mirrored[i];
    result[46] = penumbra_cast_ambient(mirrored);
    result[47] = float(seen);
}
)",
                                     "sphere_count", 48};

struct SphereInputs : CastInputs {
    std::vector<CasterSphere> spheres;
    std::vector<float> cap_logs;

    SphereInputs() : cap_logs(4 * PENUMBRA_CAP_LOG_TEXELS) {
        EXPECT_EQ(penumbra_get_cap_logs(cap_logs.data(), nullptr), PENUMBRA_OK);
    }
    CastPoints points() const { return {positions, normals, tangents}; }
    CastProgram program() const {
        return {kSphereShaders,
                *this,
                {CasterBuffer{"spheres", GL_RGBA32F, bytesOf(spheres)}, {"cap_logs", GL_RGBA32F, bytesOf(cap_logs)}},
                int(spheres.size())};
    }
};

// Some 30 spheres in a space as large as two people, and receivers among them, inside of them, and as far away as
// spheres count.
SphereInputs someCasters(std::size_t receivers) {
    SphereInputs inputs;
    synthetic::Noise noise(11);
    for (int s = 0; s < 30; ++s)
        inputs.spheres.push_back({{0.6f * noise(), 1 + noise(), 0.4f * noise()}, 0.12f + 0.08f * noise()});
    for (std::size_t r = 0; r < receivers; ++r) {
        const float reach = r % 8 == 7 ? 12.0f : r % 8 == 6 ? 5.0f : 1.0f;
        Vec3 position = Vec3{0, 1, 0} + Vec3{noise(), noise(), noise()} * reach;
        if (r % 8 == 0) {  // near the surface of a sphere, on either side of it
            const CasterSphere& sphere = inputs.spheres[r / 8 % 30];
            const Vec3 away = normalized(Vec3{noise(), noise(), noise()});
            position = sphere.center + away * (sphere.radius * (1 + 0.2f * noise()));
        }
        inputs.positions.push_back(position);
        inputs.normals.push_back(normalized(Vec3{noise(), noise(), noise()}));
        inputs.tangents.push_back(tangentOf(inputs.normals.back(), {noise(), noise(), noise()}));
    }
    inputs.positions[1] = inputs.spheres[0].center;
    inputs.texts = castText(nullptr);
    return inputs;
}

// Measured: numbers within 1.4e-5 of 3.5, E within 4.4e-6. Half a step of an 8-bit picture is 2e-3.
TEST(CastGlsl, GivesWhatTheCpuGivesAtAnyPoint) {
    SphereInputs inputs = someCasters(1000);
    inputs.left_out[0] = 4;
    inputs.left_out[1] = 9;
    std::vector<CasterSphere> counted = inputs.spheres;
    counted.erase(counted.begin() + 4, counted.begin() + 9);
    std::vector<float> mirrored(inputs.positions.size() * kMirroredCast), e;
    castMirrored(counted, inputs.points(), kSphereFade, mirrored);
    std::array<float, kMirroredCast> weights;
    ambientWeights({BelowHorizon::kMirrored, kFieldOrder}, weights);
    float darkest = 1;
    for (std::size_t r = 0; r < inputs.positions.size(); ++r) {
        float sum = 0;
        for (std::size_t i = 0; i < kMirroredCast; ++i) sum += weights[i] * mirrored[r * kMirroredCast + i];
        e.push_back(std::clamp(sum, 0.0f, 1.0f));
        darkest = std::min(darkest, e.back());
    }
    EXPECT_LT(darkest, 0.15f);
    for (const bool compute : {true, false}) {
        const CastProgram program = inputs.program();
        const std::vector<float> results = compute ? program.computed() : program.drawn();
        const double coefficients = program.difference(results, 25, kMirroredCast, mirrored, kMirroredCast);
        const double ambient = program.difference(results, 46, 1, e, 1);
        std::printf("%s shader: numbers within %.1e, E within %.1e\n", compute ? "compute" : "fragment", coefficients,
                    ambient);
        EXPECT_LT(coefficients, 5e-5);
        EXPECT_LT(ambient, 2e-5);
        const std::size_t open = program.expectOpen(results, 47, 25);
        EXPECT_GT(open, 10u);
        EXPECT_LT(open, 500u);
    }
}

// In the frame of the scene. All spheres count whole within 28 radii, and no receiver is inside of one, where scenes
// have a rule of their own. Measured with all spheres: 3.1e-6.
TEST(CastGlsl, GivesTheVisibilityOverTheWholeSphere) {
    SphereInputs inputs = someCasters(300);
    for (std::size_t r = 0; r < 300; ++r) {
        inputs.positions[r] = Vec3{0, 1, 0} + normalized(inputs.positions[r] - Vec3{0, 1, 0}) * 0.2f;
        inputs.normals[r] = {0, 0, 1};
        inputs.tangents[r] = {1, 0, 0};
    }
    inputs.spheres.erase(inputs.spheres.begin() + 15, inputs.spheres.end());
    for (CasterSphere& sphere : inputs.spheres) sphere.radius = std::max(sphere.radius, 0.08f);
    std::erase_if(inputs.spheres, [](const CasterSphere& s) {
        return length(s.center - Vec3{0, 1, 0}) < s.radius + 0.2f;
    });
    inputs.spheres.push_back({{0, 1, 0}, 0});  // hides nothing
    std::vector<float> expected(300 * 25);
    castVisibility(kCastOrder, inputs.spheres, inputs.positions, expected);
    const CastProgram program = inputs.program();
    const double worst = program.difference(program.computed(), 0, 25, expected, 25);
    std::printf("visibility within %.1e\n", worst);
    EXPECT_LT(worst, 2e-5);
}

// An asset that casts by spheres.
std::vector<std::byte> sphereTube(const char* convention) {
    synthetic::TubeOptions tube{.rings = 12, .segments = 9};
    tube.convention = parseConvention(convention);
    const Model model = synthetic::tubeModel(tube);
    SphereBlockers blockers;
    for (std::size_t j = 0; j < model.joint_centers.size(); ++j) {
        blockers.spheres.push_back({model.joint_centers[j], 0.3f});
        blockers.joints.push_back(std::uint16_t(j));
    }
    return packAsset(model, materials(), lights(3), {.precision = AssetPrecision::kI8, .blockers = blockers}, "{}", 1)
        .bytes;
}

// Two characters of one asset, which stand beside one another.
struct CastPair {
    static constexpr float kPlaces[2][12] = {{0.6f, 0, 0.8f, 0.4f, 0, 1, 0, 0.3f, -0.8f, 0, 0.6f, 0.2f},
                                             {1, 0, 0, -0.3f, 0, 1, 0, 0, 0, 0, 1, 0}};
    Scene scene;
    Character characters[2];
    std::vector<CasterSphere> spheres;  // of the first, then of the second

    explicit CastPair(const Asset& asset) {
        penumbra_scene* made = nullptr;
        const penumbra_asset* casters[2] = {asset.get(), asset.get()};
        int status = penumbra_scene_create(casters, 2, &made, nullptr);
        scene.reset(made);
        const std::size_t count = penumbra_asset_sphere_count(asset.get());
        spheres.resize(2 * count);
        for (std::size_t c = 0; c < 2; ++c) {
            characters[c] = capi_test::character(asset);
            const penumbra_character* character = characters[c].get();
            status |= penumbra_character_set_frame(characters[c].get(), c, nullptr);
            status |= penumbra_scene_set_caster(scene.get(), c, character, kPlaces[c], nullptr);
            status |= penumbra_character_get_spheres(character, kPlaces[c], &spheres[c * count].center.x, nullptr);
        }
        EXPECT_EQ(status, PENUMBRA_OK);
    }
};

// Measured: 1.4e-6.
TEST(CastGlsl, CastsOnCharactersAsTheSceneDoes) {
    for (const char* convention : {"D5", "A4", "B3"}) {
        const std::vector<std::byte> bytes = sphereTube(convention);
        const Asset asset = open(bytes);
        const penumbra_asset_info info = infoOf(asset);
        ASSERT_GT(penumbra_asset_sphere_count(asset.get()), 1u);
        const CastPair pair(asset);
        Frame frame(info);
        frame.evaluate(pair.characters[1].get(), info);
        SphereInputs inputs;
        inputs.spheres = pair.spheres;
        const int all = int(pair.spheres.size());
        inputs.addVertices(frame, info, affineOf(CastPair::kPlaces[1]), all / 2, all);  // without its own spheres
        inputs.texts = castTextOf(asset);
        const CastProgram program = inputs.program();
        ASSERT_EQ(frame.cast(pair.scene.get(), 1, pair.characters[1].get(), CastPair::kPlaces[1]), PENUMBRA_OK);
        for (const bool compute : {true, false}) {
            const std::vector<float> results = compute ? program.computed() : program.drawn();
            const auto worst = [&](const std::vector<float>& expected) {
                return program.difference(results, kSphereShaders.results, info.coefficient_count, expected,
                                          info.stride);
            };
            EXPECT_GT(worst(inputs.coefficients), 0.1) << "nothing is cast";
            EXPECT_LT(worst(frame.coefficients), 1e-5) << convention;
            std::printf("%s, %s shader: numbers within %.1e\n", convention, compute ? "compute" : "fragment",
                        worst(frame.coefficients));
        }
    }
}

TEST(CastGlsl, WrongCallsAreRefused) {
    const std::vector<std::byte> bytes = sphereTube("D5"), plain = packed();
    const Asset asset = open(bytes), without = open(plain);
    const Character character = capi_test::character(asset);
    float spheres[4 * 64], scaled[12] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0};
    ASSERT_LE(penumbra_asset_sphere_count(asset.get()), 64u);
    EXPECT_EQ(penumbra_asset_sphere_count(without.get()), 0u);
    EXPECT_EQ(penumbra_asset_sphere_count(nullptr), 0u);
    EXPECT_EQ(penumbra_character_get_spheres(nullptr, nullptr, spheres, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_get_spheres(character.get(), nullptr, nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_get_spheres(character.get(), scaled, spheres, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_get_spheres(character.get(), nullptr, spheres, nullptr), PENUMBRA_OK);
    EXPECT_EQ(penumbra_cast_get_glsl(nullptr, nullptr, 0, nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_get_cap_logs(nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
}

}  // namespace
}  // namespace penumbra::test_cast_glsl
