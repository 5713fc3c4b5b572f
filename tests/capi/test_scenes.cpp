// What characters hide from one another and from the engine's own meshes, through the C interface.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "sh/sh_basis.h"
#include "tests/capi/packed_asset.h"
#include "tests/runtime/count_allocations.h"
#include "tests/synthetic_composition.h"

namespace penumbra {
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

std::vector<float> numbersOf(const Character& character, const penumbra_asset_info& info) {
    std::vector<float> numbers(info.vertex_count * std::size_t(info.stride));
    EXPECT_EQ(penumbra_character_evaluate(character.get(), 0, info.cluster_count, numbers.data(), nullptr),
              PENUMBRA_OK);
    return numbers;
}

struct Points {
    std::vector<float> positions, normals;
    explicit Points(std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            for (const float x : {0.3f + 0.03f * float(i % 20), 0.0f, 0.1f * float(i / 20)}) positions.push_back(x);
            for (const float x : {0.0f, 1.0f, 0.0f}) normals.push_back(x);
        }
    }
};

TEST(CApiScenes, CastsOnPoints) {
    const std::vector<std::byte> bytes = tube();
    const Asset asset = open(bytes);
    const Scene scene = sceneOf({asset.get(), asset.get()});
    ASSERT_TRUE(scene);
    const Points points(100);
    std::vector<float> e(100, -1), transfer(2500);
    const auto probe = [&](std::size_t except) {
        EXPECT_EQ(penumbra_scene_probe(scene.get(), except, points.positions.data(), points.normals.data(), 100,
                                       e.data(), transfer.data(), nullptr),
                  PENUMBRA_OK);
    };
    probe(PENUMBRA_NONE);
    EXPECT_THAT(e, ::testing::Each(1.0f)) << "nobody is posed";
    const Character character = capi_test::character(asset);
    EXPECT_EQ(penumbra_scene_set_caster(scene.get(), 0, character.get(), nullptr, nullptr), PENUMBRA_OK);
    probe(PENUMBRA_NONE);
    EXPECT_LT(e[0], 0.95f);
    // E is one of the transfer's numbers, and a white light arrives where it does.
    for (std::size_t i = 0; i < 100; ++i) EXPECT_NEAR(transfer[25 * i] / (std::sqrt(std::numbers::pi) / 2), e[i], 1e-4);
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
    const std::vector<float> alone = numbersOf(one, info);
    std::vector<float> numbers = alone;
    const auto cast = [&] {
        return penumbra_scene_cast(scene.get(), 0, one.get(), nullptr, 0, info.vertex_count, numbers.data(), nullptr);
    };
    EXPECT_EQ(cast(), PENUMBRA_OK);
    EXPECT_EQ(numbers, alone) << "the other is out of reach";
    EXPECT_EQ(penumbra_scene_set_caster(scene.get(), 1, other.get(), kBeside, nullptr), PENUMBRA_OK);
    EXPECT_EQ(cast(), PENUMBRA_OK);
    EXPECT_NE(numbers, alone);
    std::vector<float> before(info.vertex_count), after(before);
    penumbra_character_ambient(one.get(), 0, info.vertex_count, alone.data(), before.data(), nullptr);
    penumbra_character_ambient(one.get(), 0, info.vertex_count, numbers.data(), after.data(), nullptr);
    double darker = 0;
    for (std::size_t v = 0; v < before.size(); ++v) darker += before[v] - after[v];
    EXPECT_GT(darker / double(before.size()), 0.005);
    // Ranges make the same numbers, from several threads.
    std::vector<float> parts = alone;
    std::vector<std::thread> threads;
    for (std::size_t half : {std::size_t(0), std::size_t(1)})
        threads.emplace_back([&, half] {
            const std::size_t middle = info.vertex_count / 2 / 64 * 64;
            penumbra_scene_cast(scene.get(), 0, one.get(), nullptr, half ? middle : 0,
                                half ? info.vertex_count - middle : middle, parts.data(), nullptr);
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(parts, numbers);
    // An asset without fields receives.
    std::vector<float> received = numbersOf(receiver, plain_info);
    const std::vector<float> unshadowed = received;
    EXPECT_EQ(penumbra_scene_cast(scene.get(), PENUMBRA_NONE, receiver.get(), nullptr, 0, plain_info.vertex_count,
                                  received.data(), nullptr),
              PENUMBRA_OK);
    EXPECT_NE(received, unshadowed);
}

TEST(CApiScenes, AllocatesNothingPerFrame) {
    const std::vector<std::byte> bytes = tube();
    const Asset asset = open(bytes);
    const Scene scene = sceneOf({asset.get(), asset.get()});
    const Character one = character(asset), other = character(asset);
    const penumbra_asset_info info = infoOf(asset);
    std::vector<float> numbers = numbersOf(one, info), e(100), transfer(2500);
    const Points points(100);
    int status = 0;
    const auto draw_frame = [&] {
        penumbra_error error;
        status |= penumbra_scene_set_caster(scene.get(), 0, one.get(), nullptr, &error);
        status |= penumbra_scene_set_caster(scene.get(), 1, other.get(), kBeside, &error);
        status |= penumbra_scene_cast(scene.get(), 0, one.get(), nullptr, 0, info.vertex_count, numbers.data(), &error);
        status |= penumbra_scene_probe(scene.get(), PENUMBRA_NONE, points.positions.data(), points.normals.data(), 100,
                                       e.data(), transfer.data(), &error);
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
    EXPECT_EQ(penumbra_scene_probe(scene.get(), PENUMBRA_NONE, points.positions.data(), points.normals.data(), 1, &e,
                                   nullptr, nullptr),
              PENUMBRA_OK);
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
    EXPECT_EQ(penumbra_scene_probe(scene.get(), PENUMBRA_NONE, position, normal, 1, &e, nullptr, &error),
              PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_scene_probe(scene.get(), 1, normal, normal, 1, &e, nullptr, &error), PENUMBRA_INVALID_ARGUMENT);
    for (const int bits : {60, 63}) {
        EXPECT_EQ(penumbra_scene_probe(scene.get(), PENUMBRA_NONE, normal, normal, std::size_t(1) << bits, &e, nullptr,
                                       &error),
                  PENUMBRA_INVALID_ARGUMENT);
        EXPECT_THAT(error.message, HasSubstr("count is"));
    }
    EXPECT_EQ(penumbra_scene_probe(scene.get(), 0, nullptr, normal, 1, &e, nullptr, &error), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_scene_probe(nullptr, 0, normal, normal, 1, &e, nullptr, &error), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(e, 7) << "nothing is written";
    std::vector<float> numbers = numbersOf(character, infoOf(asset));
    EXPECT_EQ(penumbra_scene_cast(scene.get(), 0, character.get(), nullptr, 0, infoOf(asset).vertex_count + 1,
                                  numbers.data(), &error),
              PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_scene_cast(scene.get(), 0, nullptr, nullptr, 0, 1, numbers.data(), &error),
              PENUMBRA_INVALID_ARGUMENT);
}

}  // namespace
}  // namespace penumbra
