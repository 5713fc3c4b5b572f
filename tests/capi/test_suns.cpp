// Suns through the C interface: which ones shine, what they add, and the map of their shadows.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "sh/brdf/brdf_lobe.h"
#include "tests/capi/packed_asset.h"
#include "tests/runtime/count_allocations.h"

namespace penumbra::test_suns {
namespace {

using namespace capi_test;
using ::testing::HasSubstr;

const SunD kSunOfTest{{0.6, 0.8, 0}, {5, 4, 3}, 0.01};
const std::vector<BrdfLobe> kLobesOfTest = {{BrdfModel::kLambert, {}, {0.4f, 0.3f, 0.2f}},
                                            {BrdfModel::kGgx, {0.3f, 0.5f}, {1, 1, 1}}};

// A light of order 4 that is `sun` before a uniform sky.
std::vector<float> sunny(const Sun& sun) {
    std::vector<float> sh(48);
    for (std::size_t c = 0; c < 3; ++c) sh[c] = 1;
    const Sun negative{sun.direction, -sun.irradiance, 0};
    subtractSuns({&negative, 1}, {}, sh);
    return sh;
}

struct SunnyAsset {
    std::vector<std::byte> bytes;
    Asset asset;
    penumbra_asset_info info;
    Shading shading;
    Frame frame;

    explicit SunnyAsset(const penumbra_shading_options& options = {PENUMBRA_SLICES, PENUMBRA_ROTATION, 4})
        : bytes(make()),
          asset(open(bytes)),
          info(infoOf(asset)),
          shading(capi_test::shading(asset, options)),
          frame(info) {
        frame.evaluate(character(asset).get(), info);
    }
    penumbra_vertices vertices() { return frame.vertices(); }

private:
    static std::vector<std::byte> make() {
        std::vector<BrdfFile> brdfs = materials();
        brdfs[0].lobes = kLobesOfTest;
        std::vector<LightFile> sky = lights(3);
        sky[1].suns = {kSunOfTest};
        sky[1].factor = "exact";
        return packAsset(synthetic::tubeModel({}), brdfs, sky, {}, "{}", 1).bytes;
    }
};

TEST(CApiSuns, TheAssetTellsItsLobesAndSuns) {
    const SunnyAsset x;
    penumbra_light light;
    penumbra_material material;
    penumbra_asset_get_light(x.asset.get(), 0, &light);
    EXPECT_EQ(light.sun_count, 0);
    penumbra_asset_get_light(x.asset.get(), 1, &light);
    EXPECT_EQ(light.sun_count, 1);
    penumbra_asset_get_material(x.asset.get(), 0, &material);
    ASSERT_EQ(material.lobe_count, 2u);
    penumbra_lobe lobe;
    ASSERT_EQ(penumbra_asset_get_lobe(x.asset.get(), 0, 1, &lobe), PENUMBRA_OK);
    EXPECT_EQ(lobe.model, int(BrdfModel::kGgx));
    EXPECT_EQ(lobe.parameters[0], 0.3f);
    EXPECT_EQ(lobe.color[2], 1);
    EXPECT_EQ(penumbra_asset_get_lobe(x.asset.get(), 0, 2, &lobe), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_asset_get_lobe(x.asset.get(), 1, 1, &lobe), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_asset_get_lobe(x.asset.get(), 2, 0, &lobe), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_asset_get_lobe(nullptr, 0, 0, &lobe), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_asset_get_lobe(x.asset.get(), 0, 0, nullptr), PENUMBRA_INVALID_ARGUMENT);
    float emission[3] = {1, 1, 1};
    ASSERT_EQ(penumbra_asset_get_emission(x.asset.get(), 0, emission), PENUMBRA_OK);
    EXPECT_EQ(emission[2], 0);
    EXPECT_EQ(penumbra_asset_get_emission(x.asset.get(), 9, emission), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_asset_get_emission(x.asset.get(), 0, nullptr), PENUMBRA_INVALID_ARGUMENT);
}

TEST(CApiSuns, TurnWithTheLightAndGoWithIt) {
    const SunnyAsset x;
    penumbra_shading* s = x.shading.get();
    penumbra_shading_set_light(s, 1, nullptr);
    EXPECT_EQ(penumbra_shading_sun_count(s), 0u) << "suns are off at first";
    ASSERT_EQ(penumbra_shading_set_suns(s, 1, nullptr), PENUMBRA_OK);
    ASSERT_EQ(penumbra_shading_sun_count(s), 1u);
    const float turn[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1};
    penumbra_shading_set_light_rotation(s, turn, nullptr);
    penumbra_sun sun;
    ASSERT_EQ(penumbra_shading_get_sun(s, 0, &sun), PENUMBRA_OK);
    EXPECT_NEAR(sun.direction[0], -0.8f, 1e-6f);
    EXPECT_NEAR(sun.direction[1], 0.6f, 1e-6f);
    EXPECT_EQ(sun.irradiance[2], 3);
    EXPECT_EQ(sun.radius, 0.01f);
    penumbra_shading_set_light(s, 0, nullptr);
    EXPECT_EQ(penumbra_shading_sun_count(s), 0u);
    EXPECT_EQ(penumbra_shading_get_sun(s, 0, &sun), PENUMBRA_INVALID_ARGUMENT);
}

// Half of the sun reaches every vertex. The bound is the single precision of a GGX lobe.
TEST(CApiSuns, AddsVisibilityIrradianceBrdfAndCosine) {
    SunnyAsset x;
    penumbra_shading* s = x.shading.get();
    penumbra_shading_set_light(s, 1, nullptr);
    penumbra_shading_set_suns(s, 1, nullptr);
    const std::size_t n = x.info.vertex_count;
    const std::vector<float> visible(n, 0.5f);
    x.frame.radiance.assign(3 * n, 1.0f);
    penumbra_vertices vertices = x.vertices();
    vertices.coefficients = nullptr;
    vertices.first = 1, vertices.count = n - 1;
    ASSERT_EQ(penumbra_shading_add_suns(s, &vertices, x.frame.eye, visible.data(), x.frame.radiance.data(), nullptr),
              PENUMBRA_OK);
    EXPECT_EQ(x.frame.radiance[0], 1) << "vertex 0 was not asked for";
    const auto vectorAt = [](const float* p, std::size_t v) { return Vec3{p[3 * v], p[3 * v + 1], p[3 * v + 2]}; };
    std::size_t lit = 0;
    for (std::size_t v = 1; v < n; ++v) {
        const Vec3 normal = vectorAt(vertices.normals, v), tangent = vectorAt(vertices.tangents, v);
        const Mat3 local = fromRows(tangent, cross(normal, tangent), normal);
        const Vec3 eye = vectorAt(x.frame.eye, 0) - vectorAt(vertices.positions, v);
        Vec3 wo = local * normalized(eye);
        wo.z = std::abs(wo.z);
        const Vec3 wi = local * toFloat(kSunOfTest.direction);
        const Vec3 expected =
            toFloat(kSunOfTest.irradiance) * evalLobes(kLobesOfTest, wi, wo) * (0.5f * std::max(wi.z, 0.0f));
        const Vec3 added = vectorAt(x.frame.radiance.data(), v) - Vec3{1, 1, 1};
        EXPECT_LT(length(added - expected), 2e-6f * (1 + length(expected))) << v;
        lit += length(expected) > 0.1f;
    }
    EXPECT_GT(lit, n / 4);
}

// The first light is taken as it is. After the time constant, 1/e of the way to the next one is left.
TEST(CApiSuns, FindsThoseOfTheCallersLight) {
    const SunnyAsset x;
    penumbra_shading* s = x.shading.get();
    penumbra_shading_set_suns(s, 1, nullptr);
    ASSERT_EQ(penumbra_shading_find_suns(s, 1, 0.5, nullptr), PENUMBRA_OK);
    const auto seen = [&](float angle, double seconds) {
        const std::vector<float> sh = sunny({{std::cos(angle), std::sin(angle), 0}, {5, 4, 3}, 0});
        EXPECT_EQ(penumbra_shading_set_sh_light(s, 4, sh.data(), seconds, nullptr), PENUMBRA_OK);
        penumbra_sun sun{};
        EXPECT_EQ(penumbra_shading_get_sun(s, 0, &sun), PENUMBRA_OK);
        return std::atan2(sun.direction[1], sun.direction[0]);
    };
    EXPECT_NEAR(seen(0.9f, 0), 0.9f, 0.01f);
    EXPECT_NEAR(seen(1.1f, 0.5), 1.1f - 0.2f * std::exp(-1.0f), 0.01f);
    EXPECT_NEAR(seen(1.1f, 100), 1.1f, 0.01f);
    ASSERT_EQ(penumbra_shading_find_suns(s, 0, 0, nullptr), PENUMBRA_OK);
    const std::vector<float> sh = sunny({{1, 0, 0}, {5, 4, 3}, 0});
    penumbra_shading_set_sh_light(s, 4, sh.data(), 0, nullptr);
    EXPECT_EQ(penumbra_shading_sun_count(s), 0u);
}

// A triangle of side 1 at height 1 below the zenith's sun.
struct Awning {
    std::vector<float> corners = {-1, 1, -1, 1, 1, -1, 0, 1, 1};
    std::vector<std::uint32_t> triangles = {0, 1, 2};
    penumbra_sun sun{{0, 1, 0}, {1, 1, 1}, 0};
    penumbra_sun_caster caster() const { return {corners.data(), 3, triangles.data(), 1}; }
};

struct DestroySunMap {
    void operator()(penumbra_sun_map* map) const { penumbra_sun_map_destroy(map); }
};
using SunMapHandle = std::unique_ptr<penumbra_sun_map, DestroySunMap>;

SunMapHandle sunMap(int size) {
    penumbra_sun_map* map = nullptr;
    EXPECT_EQ(penumbra_sun_map_create(size, &map, nullptr), PENUMBRA_OK);
    return SunMapHandle(map);
}

TEST(CApiSuns, AMapTellsWhatACasterHides) {
    const SunMapHandle map = sunMap(256);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    // Below the awning, beside it, above it, facing away, nowhere, and so far away that no texel has a number.
    const std::vector<float> points = {0, 0, 0, 3, 0, 0, 0, 2, 0, 3, 0, 0, nan, 0, 0, 1e30f, -1e30f, 0};
    const std::vector<float> normals = {0, 1, 0, 0, 1, 0, 0, 1, 0, 0, -1, 0, 0, 1, 0, 0, 1, 0};
    std::vector<float> visible(6, -1);
    const auto look = [&] {
        EXPECT_EQ(penumbra_sun_map_visibility(map.get(), points.data(), normals.data(), 6, visible.data(), nullptr),
                  PENUMBRA_OK);
        return visible;
    };
    EXPECT_EQ(look()[0], 1) << "nothing casts yet";
    Awning awning;
    for (const float radius : {0.0f, 0.05f, 3e38f}) {
        awning.sun.radius = radius;
        const penumbra_sun_caster caster = awning.caster();
        ASSERT_EQ(penumbra_sun_map_set_casters(map.get(), &awning.sun, &caster, 1, nullptr, nullptr), PENUMBRA_OK);
        look();
        EXPECT_EQ(visible[2], 1);
        EXPECT_EQ(visible[3], 0);
        EXPECT_EQ(visible[4], 0);
        if (radius > 1) continue;
        EXPECT_EQ(visible[0], 0);
        EXPECT_EQ(visible[1], 1);
        EXPECT_EQ(visible[5], 1);
    }
}

// On a ground of 2 km the awning has the edges that it has alone, to a centimetre, and on no ground it is as before.
TEST(CApiSuns, ACasterOnAWideGroundHasItsShadow) {
    const SunMapHandle map = sunMap(0), alone = sunMap(0);
    const Awning awning;
    const penumbra_sun_caster caster = awning.caster();
    std::vector<float> corners;
    std::vector<std::uint32_t> triangles;
    for (int r = 0; r < 21; ++r)
        for (int c = 0; c < 21; ++c) {
            for (const float x : {100 * float(c - 10), 0.0f, 100 * float(r - 10)}) corners.push_back(x);
            if (r == 20 || c == 20) continue;
            const auto a = std::uint32_t(21 * r + c);
            triangles.insert(triangles.end(), {a, a + 21, a + 1, a + 1, a + 21, a + 22});
        }
    penumbra_sun_caster ground{corners.data(), 441, triangles.data(), triangles.size() / 3};
    penumbra_error error;
    ASSERT_EQ(penumbra_sun_map_set_casters(map.get(), &awning.sun, &caster, 1, &ground, &error), PENUMBRA_OK);
    ASSERT_EQ(penumbra_sun_map_set_casters(alone.get(), &awning.sun, &caster, 1, nullptr, &error), PENUMBRA_OK);
    const auto seen = [](const SunMapHandle& at, float x, float z) {
        const float point[3] = {x, 0, z}, up[3] = {0, 1, 0};
        float visible = -1;
        EXPECT_EQ(penumbra_sun_map_visibility(at.get(), point, up, 1, &visible, nullptr), PENUMBRA_OK);
        return visible;
    };
    for (float z = -1.97f; z < 2; z += 0.05f) EXPECT_EQ(seen(map, 0, z), seen(alone, 0, z)) << z;
    EXPECT_EQ(seen(map, 0, -0.99f), 0);  // the edge of the awning lies at z = -1
    EXPECT_EQ(seen(map, 0, -1.01f), 1);
    EXPECT_EQ(seen(map, 700, 300), 1);
    ASSERT_EQ(penumbra_sun_map_set_casters(map.get(), &awning.sun, &caster, 1, nullptr, &error), PENUMBRA_OK);
    for (float z = -1.99f; z < 2; z += 0.05f) EXPECT_EQ(seen(map, 0, z), seen(alone, 0, z)) << z;
    triangles.back() = 441;
    EXPECT_EQ(penumbra_sun_map_set_casters(map.get(), &awning.sun, &caster, 1, &ground, &error),
              PENUMBRA_INVALID_ARGUMENT);
    EXPECT_THAT(error.message, HasSubstr("a vertex of a triangle is 441; there are 441"));
    EXPECT_EQ(seen(map, 0, 0), 0) << "what was refused has changed nothing";
}

// Drawing over and over, of a caster that moves, and looking the map up.
TEST(CApiSuns, NoFrameAllocates) {
    SunnyAsset x;
    const SunMapHandle map = sunMap(64);
    Awning awning;
    penumbra_shading* s = x.shading.get();
    penumbra_shading_set_suns(s, 1, nullptr);
    penumbra_shading_find_suns(s, 3, 0.1, nullptr);
    std::vector<float> visible(3 * x.info.vertex_count);
    const std::vector<float> sh = sunny({{0, 1, 0}, {5, 4, 3}, 0});
    const penumbra_vertices vertices = x.vertices();
    const auto frame = [&](int number) {
        int status = penumbra_shading_set_sh_light(s, 4, sh.data(), 0.02, nullptr);
        awning.corners[0] = -1 - 0.1f * float(number);
        const penumbra_sun_caster caster = awning.caster();
        status |= penumbra_sun_map_set_casters(map.get(), &awning.sun, &caster, 1, nullptr, nullptr);
        for (std::size_t i = 0; i < penumbra_shading_sun_count(s); ++i)
            status |= penumbra_sun_map_visibility(map.get(), vertices.positions, vertices.normals, x.info.vertex_count,
                                                  &visible[i * x.info.vertex_count], nullptr);
        return status |
               penumbra_shading_add_suns(s, &vertices, x.frame.eye, visible.data(), x.frame.radiance.data(), nullptr);
    };
    EXPECT_EQ(frame(0), PENUMBRA_OK);
    const std::size_t before = allocationCount();
    for (int i = 1; i < 20; ++i) EXPECT_EQ(frame(i), PENUMBRA_OK);
    EXPECT_EQ(allocationCount(), before);
}

TEST(CApiSuns, WrongCallsOfShadings) {
    SunnyAsset x;
    const SunnyAsset lobes({PENUMBRA_SLICES, PENUMBRA_FIXED_LOBES, 0}), roomless(penumbra_shading_options{});
    penumbra_shading* s = x.shading.get();
    penumbra_error error;
    EXPECT_EQ(penumbra_shading_set_suns(lobes.shading.get(), 1, &error), PENUMBRA_UNSUPPORTED);
    EXPECT_STREQ(error.message, "suns need light_form PENUMBRA_ROTATION");
    EXPECT_EQ(penumbra_shading_set_suns(lobes.shading.get(), 0, &error), PENUMBRA_OK);
    EXPECT_EQ(penumbra_shading_set_suns(nullptr, 1, &error), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_shading_sun_count(nullptr), 0u);
    EXPECT_EQ(penumbra_shading_find_suns(roomless.shading.get(), 1, 0.1, &error), PENUMBRA_UNSUPPORTED);
    EXPECT_EQ(penumbra_shading_find_suns(s, 9, 0.1, &error), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_STREQ(error.message, "most is 9, allowed are 0..8");
    for (const double seconds : {-1.0, double(NAN), double(INFINITY)}) {
        EXPECT_EQ(penumbra_shading_find_suns(s, 1, seconds, &error), PENUMBRA_INVALID_ARGUMENT);
        const std::vector<float> sh(48);
        EXPECT_EQ(penumbra_shading_set_sh_light(s, 4, sh.data(), seconds, &error), PENUMBRA_INVALID_ARGUMENT);
        EXPECT_STREQ(error.message, "seconds must be a finite number of seconds, 0 or more");
    }
    const penumbra_vertices good = x.vertices(), too_many = x.frame.vertices(0, x.info.vertex_count + 1);
    const std::vector<float> visible(x.info.vertex_count, 1.0f);
    const auto add = [&](const penumbra_vertices* vertices, const float* share) {
        return penumbra_shading_add_suns(s, vertices, x.frame.eye, share, x.frame.radiance.data(), &error);
    };
    EXPECT_EQ(add(&too_many, visible.data()), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(add(&good, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(add(nullptr, visible.data()), PENUMBRA_INVALID_ARGUMENT);
    const float eye[3] = {0, 0, NAN};
    EXPECT_EQ(penumbra_shading_add_suns(s, &good, eye, visible.data(), x.frame.radiance.data(), &error),
              PENUMBRA_INVALID_ARGUMENT);
    EXPECT_STREQ(error.message, "eye[2] is not finite");
    for (const auto member :
         {&penumbra_vertices::positions, &penumbra_vertices::normals, &penumbra_vertices::tangents}) {
        penumbra_vertices bad = good;
        bad.*member = nullptr;
        EXPECT_EQ(add(&bad, visible.data()), PENUMBRA_INVALID_ARGUMENT);
    }
    EXPECT_EQ(x.frame.radiance, Frame(x.info).radiance);
}

// The largest numbers that there are have suns or none, and nothing else.
TEST(CApiSuns, HostileLightsAndVerticesAreDefined) {
    SunnyAsset x;
    penumbra_shading* s = x.shading.get();
    penumbra_shading_set_suns(s, 1, nullptr);
    penumbra_shading_find_suns(s, 3, 0.1, nullptr);
    const float most = std::numeric_limits<float>::max();
    std::vector<float> visible(3 * x.info.vertex_count, 1.0f);
    for (const float size : {most, -most, 1e-38f, 0.0f}) {
        std::vector<float> sh(48, size);
        for (std::size_t i = 0; i < sh.size(); i += 5) sh[i] = -size;
        ASSERT_EQ(penumbra_shading_set_sh_light(s, 4, sh.data(), 1, nullptr), PENUMBRA_OK);
        for (std::size_t i = 0; i < penumbra_shading_sun_count(s); ++i) {
            penumbra_sun sun;
            penumbra_shading_get_sun(s, i, &sun);
            const float* d = sun.direction;
            EXPECT_NEAR(length(Vec3{d[0], d[1], d[2]}), 1, 1e-5f);
            for (const float e : sun.irradiance) EXPECT_GE(e, 0);
        }
    }
    penumbra_shading_set_light(s, 1, nullptr);
    for (float& share : visible) share = std::numeric_limits<float>::quiet_NaN();
    const penumbra_vertices vertices = x.vertices();
    EXPECT_EQ(penumbra_shading_add_suns(s, &vertices, x.frame.eye, visible.data(), x.frame.radiance.data(), nullptr),
              PENUMBRA_OK);
    EXPECT_EQ(x.frame.radiance, Frame(x.info).radiance) << "an unknown share adds nothing";
}

TEST(CApiSuns, WrongCallsOfMaps) {
    penumbra_error error;
    penumbra_sun_map* none = nullptr;
    EXPECT_EQ(penumbra_sun_map_create(7, &none, &error), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_STREQ(error.message, "size is 7, allowed are 0 and 8..8192");
    EXPECT_EQ(penumbra_sun_map_create(8193, &none, &error), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_sun_map_create(0, nullptr, &error), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(none, nullptr);
    penumbra_sun_map_destroy(nullptr);
    const SunMapHandle map = sunMap(64);
    Awning awning;
    const auto set = [&](const penumbra_sun& sun, penumbra_sun_caster caster) {
        const penumbra_status status = penumbra_sun_map_set_casters(map.get(), &sun, &caster, 1, nullptr, &error);
        return std::string(penumbra_status_name(status)) + ": " + error.message;
    };
    EXPECT_EQ(set(awning.sun, awning.caster()), "PENUMBRA_OK: ");
    const std::string invalid = "PENUMBRA_INVALID_ARGUMENT: ";
    EXPECT_EQ(set({{0, 2, 0}, {}, 0}, awning.caster()), invalid + "sun->direction has length 2.000000, not 1");
    EXPECT_EQ(set({{0, NAN, 0}, {}, 0}, awning.caster()), invalid + "sun->direction[1] is not finite");
    EXPECT_THAT(set({{0, 1, 0}, {}, -1}, awning.caster()), HasSubstr("sun->radius"));
    EXPECT_THAT(set({{0, 1, 0}, {}, NAN}, awning.caster()), HasSubstr("sun->radius"));
    EXPECT_EQ(set(awning.sun, {awning.corners.data(), 2, awning.triangles.data(), 1}),
              invalid + "a vertex of a triangle is 2; there are 2");
    EXPECT_THAT(set(awning.sun, {nullptr, 3, awning.triangles.data(), 1}), HasSubstr("positions of a caster"));
    EXPECT_THAT(set(awning.sun, {awning.corners.data(), 3, nullptr, 1}), HasSubstr("triangles of a caster"));
    // Counts that cannot be are refused before anything is read.
    for (const int bits : {60, 63}) {
        const std::size_t many = std::size_t(1) << bits;
        const penumbra_sun_caster caster = awning.caster();
        EXPECT_EQ(penumbra_sun_map_set_casters(map.get(), &awning.sun, &caster, many, nullptr, &error),
                  PENUMBRA_INVALID_ARGUMENT);
        EXPECT_THAT(set(awning.sun, {awning.corners.data(), 3, awning.triangles.data(), many}),
                    HasSubstr("triangle_count is"));
        EXPECT_THAT(set(awning.sun, {awning.corners.data(), many, awning.triangles.data(), 1}),
                    HasSubstr("vertex_count is"));
        EXPECT_EQ(penumbra_sun_map_visibility(map.get(), awning.corners.data(), awning.corners.data(), many,
                                              awning.corners.data(), &error),
                  PENUMBRA_INVALID_ARGUMENT);
    }
    EXPECT_EQ(penumbra_sun_map_set_casters(map.get(), nullptr, nullptr, 0, nullptr, nullptr),
              PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_sun_map_set_casters(map.get(), &awning.sun, nullptr, 1, nullptr, nullptr),
              PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_sun_map_set_casters(nullptr, &awning.sun, nullptr, 0, nullptr, nullptr),
              PENUMBRA_INVALID_ARGUMENT);
    // The refused calls have changed nothing: the awning still casts.
    const float below[3] = {}, up[3] = {0, 1, 0};
    float visible = -1;
    EXPECT_EQ(penumbra_sun_map_visibility(map.get(), below, up, 1, &visible, nullptr), PENUMBRA_OK);
    EXPECT_EQ(visible, 0);
    EXPECT_EQ(penumbra_sun_map_visibility(map.get(), nullptr, up, 1, &visible, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_sun_map_visibility(map.get(), below, up, 1, nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_sun_map_visibility(nullptr, below, up, 1, &visible, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_sun_map_visibility(map.get(), nullptr, nullptr, 0, nullptr, nullptr), PENUMBRA_OK);
    // Vertices that are nowhere cast nothing, and a caster without triangles has no shadow.
    awning.corners[4] = INFINITY;
    EXPECT_EQ(set(awning.sun, awning.caster()), "PENUMBRA_OK: ");
    penumbra_sun_map_visibility(map.get(), below, up, 1, &visible, nullptr);
    EXPECT_EQ(visible, 1);
    EXPECT_EQ(set(awning.sun, {}), "PENUMBRA_OK: ");
    for (float& x : awning.corners) x = x > 0 ? 3e38f : -3e38f;
    EXPECT_EQ(set(awning.sun, awning.caster()), "PENUMBRA_OK: ");
    penumbra_sun_map_visibility(map.get(), below, up, 1, &visible, nullptr);
    EXPECT_TRUE(visible >= 0 && visible <= 1);
}

TEST(CApiSuns, TheTextOfLobes) {
    std::size_t length = 0;
    penumbra_error error;
    ASSERT_EQ(penumbra_brdf_get_glsl(nullptr, 0, &length, &error), PENUMBRA_OK);
    std::string text(length + 1, 0);
    EXPECT_EQ(penumbra_brdf_get_glsl(text.data(), length, &length, &error), PENUMBRA_INVALID_ARGUMENT);
    ASSERT_EQ(penumbra_brdf_get_glsl(text.data(), length + 1, &length, &error), PENUMBRA_OK);
    EXPECT_THAT(text, HasSubstr("vec3 penumbra_brdf_lobe(int model, vec4 parameters, vec3 color, vec3 wi, vec3 wo)"));
    EXPECT_EQ(penumbra_brdf_get_glsl(nullptr, 0, nullptr, &error), PENUMBRA_INVALID_ARGUMENT);
}

}  // namespace
}  // namespace penumbra::test_suns
