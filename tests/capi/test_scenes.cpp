// Tests how characters shadow one another and the engine's own meshes, through the C interface.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "sh/sh_basis.h"
#include "tests/capi/packed_asset.h"
#include "tests/runtime/count_allocations.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_scenes {
namespace {

using namespace capi_test;
using ::testing::HasSubstr;

const synthetic::TubeOptions kTube{
    .rings = 20, .segments = 9, .joints = 6, .clusters = 4, .components = 5, .inputs = 4};
constexpr float kBeside[12] = {1, 0, 0, 0.6f, 0, 1, 0, 0, 0, 0, 1, 0},
                kAway[12] = {1, 0, 0, 5000, 0, 1, 0, 0, 0, 0, 1, 0};

std::vector<std::byte> tube() {
    return packAsset(synthetic::composedTube(kTube), {}, {}, {.precision = AssetPrecision::kI8}, "{}", 1).bytes;
}

Scene sceneOf(std::vector<const penumbra_asset*> assets, penumbra_error* error = nullptr) {
    penumbra_scene* scene = nullptr;
    penumbra_scene_create(assets.data(), assets.size(), &scene, error);
    return Scene(scene);
}

Frame evaluated(const Character& character, const penumbra_asset_info& info) {
    Frame frame(info);
    EXPECT_EQ(frame.evaluate(character.get(), info), PENUMBRA_OK);
    return frame;
}

struct Points {
    std::vector<float> positions, normals;
    explicit Points(std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            for (const float x : {0.3f + 0.03f * float(i % 20), 0.0f, 0.1f * float(i / 20)}) positions.push_back(x);
            for (const float x : {0.0f, 1.0f, 0.0f}) normals.push_back(x);
        }
    }
    penumbra_points view() const { return {positions.data(), normals.data(), positions.size() / 3}; }
};

TEST(CApiScenes, CastsOnPoints) {
    const std::vector<std::byte> bytes = tube();
    const Asset asset = open(bytes);
    const Scene scene = sceneOf({asset.get(), asset.get()});
    ASSERT_TRUE(scene);
    const Points points(100);
    std::vector<float> e(100, -1), transfer(2500);
    const penumbra_points view = points.view();
    const auto probe = [&](std::size_t except) {
        EXPECT_EQ(penumbra_scene_ambient(scene.get(), except, &view, e.data(), nullptr), PENUMBRA_OK);
        EXPECT_EQ(penumbra_scene_transfer(scene.get(), except, &view, transfer.data(), nullptr), PENUMBRA_OK);
    };
    probe(PENUMBRA_NONE);
    EXPECT_THAT(e, ::testing::Each(1.0f)) << "nobody is posed";
    const Character character = capi_test::character(asset);
    EXPECT_EQ(penumbra_scene_set_caster(scene.get(), 0, character.get(), nullptr, nullptr), PENUMBRA_OK);
    probe(PENUMBRA_NONE);
    EXPECT_LT(e[0], 0.95f);
    // E is one of the transfer's numbers, and a white light arrives where it does.
    for (std::size_t i = 0; i < 100; ++i) EXPECT_NEAR(transfer[25 * i] / (std::sqrt(std::numbers::pi) / 2), e[i], 1e-4);
    const std::vector<LightFile> sky = lights(3);
    const std::vector<float> sh(sky[0].sh.begin(), sky[0].sh.end());
    std::vector<float> irradiance(300);
    EXPECT_EQ(penumbra_scene_irradiance(scene.get(), PENUMBRA_NONE, &view, sky[0].order, sh.data(), irradiance.data(),
                                        nullptr),
              PENUMBRA_OK);
    for (std::size_t i = 0; i < 300; ++i) {
        double sum = 0;
        for (std::size_t k = 0; k < sh.size() / 3; ++k) sum += double(transfer[25 * (i / 3) + k]) * sh[3 * k + i % 3];
        EXPECT_NEAR(irradiance[i], sum, 1e-5);
    }
    const float near = e[0];
    probe(0);
    EXPECT_THAT(e, ::testing::Each(1.0f)) << "the only caster is left out";
    EXPECT_EQ(penumbra_scene_set_caster(scene.get(), 1, character.get(), kBeside, nullptr), PENUMBRA_OK);
    probe(PENUMBRA_NONE);
    EXPECT_LT(e[0], near);
    EXPECT_EQ(penumbra_scene_set_caster(scene.get(), 1, nullptr, nullptr, nullptr), PENUMBRA_OK);
    probe(PENUMBRA_NONE);
    EXPECT_EQ(e[0], near);
}

TEST(CApiScenes, CastsOnCharacters) {
    const std::vector<std::byte> bytes = tube(), plain = packed();
    const Asset asset = open(bytes), additive = open(plain);
    const Scene scene = sceneOf({asset.get(), asset.get()});
    const Character one = character(asset), other = character(asset), receiver = character(additive);
    EXPECT_EQ(penumbra_scene_set_caster(scene.get(), 0, one.get(), nullptr, nullptr), PENUMBRA_OK);
    EXPECT_EQ(penumbra_scene_set_caster(scene.get(), 1, other.get(), kAway, nullptr), PENUMBRA_OK);
    const penumbra_asset_info info = infoOf(asset), plain_info = infoOf(additive);
    const Frame alone = evaluated(one, info);
    Frame whole = alone;
    EXPECT_EQ(whole.cast(scene.get(), 0, one.get(), nullptr), PENUMBRA_OK);
    EXPECT_EQ(whole.coefficients, alone.coefficients) << "the other is out of reach";
    EXPECT_EQ(penumbra_scene_set_caster(scene.get(), 1, other.get(), kBeside, nullptr), PENUMBRA_OK);
    EXPECT_EQ(whole.cast(scene.get(), 0, one.get(), nullptr), PENUMBRA_OK);
    EXPECT_NE(whole.coefficients, alone.coefficients);
    const penumbra_vertices shadowed = whole.vertices();
    penumbra_character_ambient(one.get(), &shadowed, whole.ambient.data(), nullptr);
    double darker = 0;
    for (std::size_t v = 0; v < info.vertex_count; ++v) darker += alone.ambient[v] - whole.ambient[v];
    EXPECT_GT(darker / double(info.vertex_count), 0.005);
    // Ranges make the same coefficients, from several threads.
    Frame parts = alone;
    std::vector<std::thread> threads;
    for (std::size_t half : {std::size_t(0), std::size_t(1)})
        threads.emplace_back([&, half] {
            const std::size_t middle = info.vertex_count / 2 / 64 * 64;
            const penumbra_vertices part =
                parts.vertices(half ? middle : 0, half ? info.vertex_count - middle : middle);
            penumbra_scene_cast(scene.get(), 0, one.get(), nullptr, &part, nullptr);
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(parts.coefficients, whole.coefficients);
    // An asset without fields receives.
    const Frame unshadowed = evaluated(receiver, plain_info);
    Frame received = unshadowed;
    EXPECT_EQ(received.cast(scene.get(), PENUMBRA_NONE, receiver.get(), nullptr), PENUMBRA_OK);
    EXPECT_NE(received.coefficients, unshadowed.coefficients);
}

// E loses exactly the hidden light, and a ground on which a character lies on its head hides other directions than
// before.
TEST(CApiScenes, ALevelGroundHidesWhatGoesDown) {
    const std::vector<std::byte> bytes = tube();
    const Asset asset = open(bytes);
    const Character one = character(asset);
    const penumbra_asset_info info = infoOf(asset);
    const Frame alone = evaluated(one, info);
    const float over[12] = {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0};
    std::vector<float> sum(info.vertex_count), hidden(info.vertex_count);
    for (const float* to_scene : {static_cast<const float*>(nullptr), over}) {
        Frame shadowed = alone;
        const penumbra_vertices vertices = shadowed.vertices();
        ASSERT_EQ(penumbra_ground_shadow(one.get(), to_scene, &vertices, hidden.data(), nullptr), PENUMBRA_OK);
        penumbra_character_ambient(one.get(), &vertices, shadowed.ambient.data(), nullptr);
        for (std::size_t v = 0; v < info.vertex_count; ++v) {
            sum[v] += hidden[v];
            EXPECT_NEAR(hidden[v], std::max(alone.ambient[v] - shadowed.ambient[v], 0.0f), 1e-5f);
        }
    }
    EXPECT_GT(*std::max_element(hidden.begin(), hidden.end()), 0.3f);
    // Both halves of the hemisphere are all of it. Bands, and E that stays in [0, 1], leave a part of it.
    for (std::size_t v = 0; v < info.vertex_count; ++v) EXPECT_NEAR(sum[v], alone.ambient[v], 0.1f);
    Frame unused = alone;
    const penumbra_vertices some = unused.vertices();
    EXPECT_EQ(penumbra_ground_shadow(nullptr, nullptr, &some, nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
}

TEST(CApiScenes, AllocatesNothingPerFrame) {
    const std::vector<std::byte> bytes = tube();
    const Asset asset = open(bytes);
    const Scene scene = sceneOf({asset.get(), asset.get()});
    const Character one = character(asset), other = character(asset);
    const penumbra_asset_info info = infoOf(asset);
    Frame receiver = evaluated(one, info);
    std::vector<float> e(100), transfer(2500), irradiance(300);
    const float white[3] = {1, 1, 1};
    const Points points(100);
    const penumbra_points view = points.view();
    const penumbra_vertices vertices = receiver.vertices();
    std::vector<float> of_vertices(25 * info.vertex_count);
    int status = 0;
    const auto draw_frame = [&] {
        penumbra_error error;
        status |= penumbra_scene_set_caster(scene.get(), 0, one.get(), nullptr, &error);
        status |= penumbra_scene_set_caster(scene.get(), 1, other.get(), kBeside, &error);
        status |= receiver.cast(scene.get(), 0, one.get(), nullptr, &error);
        status |= penumbra_scene_ambient(scene.get(), PENUMBRA_NONE, &view, e.data(), &error);
        status |= penumbra_scene_irradiance(scene.get(), PENUMBRA_NONE, &view, 1, white, irradiance.data(), &error);
        status |= penumbra_scene_transfer(scene.get(), PENUMBRA_NONE, &view, transfer.data(), &error);
        status |= penumbra_character_transfer(one.get(), 5, &vertices, of_vertices.data(), &error);
    };
    draw_frame();  // a thread makes its room the first time
    const std::size_t before = allocationCount();
    for (int frame = 0; frame < 10; ++frame) draw_frame();
    EXPECT_EQ(status, PENUMBRA_OK);
    EXPECT_EQ(allocationCount() - before, 0u);
}

TEST(CApiScenes, OutlivesItsAssetsAndCharacters) {
    Scene scene;
    {
        const std::vector<std::byte> bytes = tube();
        penumbra_asset* copied = nullptr;
        penumbra_asset_open_memory(bytes.data(), bytes.size(), PENUMBRA_COPY, &copied, nullptr);
        const Asset asset(copied);
        scene = sceneOf({asset.get()});
        const Character character = capi_test::character(asset);
        EXPECT_EQ(penumbra_scene_set_caster(scene.get(), 0, character.get(), nullptr, nullptr), PENUMBRA_OK);
    }
    const Points points(1);
    float e = -1;
    const penumbra_points view = points.view();
    EXPECT_EQ(penumbra_scene_ambient(scene.get(), PENUMBRA_NONE, &view, &e, nullptr), PENUMBRA_OK);
    EXPECT_LT(e, 1);
}

TEST(CApiScenes, TellsWhoStandsWhere) {
    const std::vector<std::byte> bytes = tube();
    const Asset asset = open(bytes);
    const Scene scene = sceneOf({asset.get(), asset.get()});
    const Character character = capi_test::character(asset);
    EXPECT_EQ(penumbra_scene_caster_count(scene.get()), 2u);
    EXPECT_EQ(penumbra_scene_caster_count(nullptr), 0u);
    const auto caster = [&](std::size_t i) {
        penumbra_caster out = {};
        EXPECT_EQ(penumbra_scene_get_caster(scene.get(), i, &out, nullptr), PENUMBRA_OK);
        return out;
    };
    const auto place = [&](std::size_t i) {
        const penumbra_caster out = caster(i);
        return std::vector<float>(std::begin(out.to_scene), std::end(out.to_scene));
    };
    EXPECT_EQ(caster(0).kind, PENUMBRA_CASTS_FIELDS);
    EXPECT_EQ(caster(0).hidden, 1) << "nobody was set";
    EXPECT_THAT(place(0), ::testing::ElementsAre(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0));
    EXPECT_EQ(penumbra_scene_set_caster(scene.get(), 1, character.get(), kBeside, nullptr), PENUMBRA_OK);
    EXPECT_EQ(caster(0).hidden, 1);
    EXPECT_EQ(caster(1).hidden, 0);
    EXPECT_THAT(place(1), ::testing::ElementsAreArray(kBeside));
    const float scaled[12] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0};
    EXPECT_NE(penumbra_scene_set_caster(scene.get(), 1, character.get(), scaled, nullptr), PENUMBRA_OK);
    EXPECT_THAT(place(1), ::testing::ElementsAreArray(kBeside)) << "a refused place changes nothing";
    EXPECT_EQ(penumbra_scene_set_caster(scene.get(), 1, nullptr, nullptr, nullptr), PENUMBRA_OK);
    EXPECT_EQ(caster(1).hidden, 1);
    penumbra_error error;
    penumbra_caster out;
    EXPECT_EQ(penumbra_scene_get_caster(scene.get(), 2, &out, &error), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_scene_get_caster(scene.get(), 0, nullptr, &error), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_scene_get_caster(nullptr, 0, &out, &error), PENUMBRA_INVALID_ARGUMENT);
}

TEST(CApiScenes, RefusesWhatIsWrong) {
    const std::vector<std::byte> bytes = tube(), more = tube(), plain = packed();
    const Asset asset = open(bytes), same_kind = open(more), additive = open(plain);
    penumbra_error error;
    EXPECT_FALSE(sceneOf({additive.get()}, &error));
    EXPECT_EQ(error.status, PENUMBRA_UNSUPPORTED);
    EXPECT_THAT(error.message, HasSubstr("neither fields of parts nor spheres"));
    EXPECT_FALSE(sceneOf({nullptr}, &error));
    EXPECT_EQ(error.status, PENUMBRA_INVALID_ARGUMENT);
    EXPECT_FALSE(sceneOf(std::vector<const penumbra_asset*>(70000 / 6, asset.get()), &error));
    EXPECT_EQ(error.status, PENUMBRA_UNSUPPORTED);
    // A count that cannot be is refused before the array is read.
    const penumbra_asset* const one = asset.get();
    penumbra_scene* made = nullptr;
    EXPECT_EQ(penumbra_scene_create(&one, std::size_t(1) << 60, &made, &error), PENUMBRA_UNSUPPORTED);
    EXPECT_EQ(made, nullptr);
    const Scene scene = sceneOf({asset.get()});
    const Character character = capi_test::character(asset), stranger = capi_test::character(same_kind);
    const auto set = [&](std::size_t caster, const Character& who, const float* at) {
        return penumbra_scene_set_caster(scene.get(), caster, who.get(), at, &error);
    };
    EXPECT_EQ(set(1, character, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(set(0, stranger, nullptr), PENUMBRA_INVALID_ARGUMENT);
    const float scaled[12] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0}, nan[12] = {NAN};
    EXPECT_EQ(set(0, character, scaled), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(set(0, character, nan), PENUMBRA_INVALID_ARGUMENT);
    const float position[3] = {0, NAN, 0}, normal[3] = {0, 1, 0};
    float e = 7;
    const auto probe = [&](const penumbra_scene* of, std::size_t except, const penumbra_points& points) {
        return penumbra_scene_ambient(of, except, &points, &e, &error);
    };
    EXPECT_EQ(probe(scene.get(), PENUMBRA_NONE, {position, normal, 1}), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(probe(scene.get(), 1, {normal, normal, 1}), PENUMBRA_INVALID_ARGUMENT);
    for (const int bits : {60, 63}) {
        EXPECT_EQ(probe(scene.get(), PENUMBRA_NONE, {normal, normal, std::size_t(1) << bits}),
                  PENUMBRA_INVALID_ARGUMENT);
        EXPECT_THAT(error.message, HasSubstr("count is"));
    }
    EXPECT_EQ(probe(scene.get(), 0, {nullptr, normal, 1}), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(probe(nullptr, 0, {normal, normal, 1}), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_scene_ambient(scene.get(), 0, nullptr, &e, &error), PENUMBRA_INVALID_ARGUMENT);
    const penumbra_points one_point{normal, normal, 1};
    EXPECT_EQ(penumbra_scene_irradiance(scene.get(), 0, &one_point, 6, normal, &e, &error), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_scene_irradiance(scene.get(), 0, &one_point, 1, position, &e, &error),
              PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(e, 7) << "nothing is written";
    Frame frame = evaluated(character, infoOf(asset));
    const penumbra_vertices vertices = frame.vertices(0, infoOf(asset).vertex_count + 1);
    EXPECT_EQ(penumbra_scene_cast(scene.get(), 0, character.get(), nullptr, &vertices, &error),
              PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_scene_cast(scene.get(), 0, nullptr, nullptr, &vertices, &error), PENUMBRA_INVALID_ARGUMENT);
}

}  // namespace
}  // namespace penumbra::test_scenes
