// Suns in the window: when they shine, what the light is without them, and when their maps are drawn.
#include <gtest/gtest.h>
#include <unistd.h>

#include "formats/common/write_file.h"
#include "formats/image/environment_map.h"
#include "formats/image/image_file.h"
#include "pack/pack_asset.h"
#include "player/gl/gl_context.h"
#include "player/scene/scene_suns.h"
#include "player/view/view_actions.h"
#include "player/view/view_look.h"
#include "player/view/view_shapes.h"
#include "player/view/view_sunlight.h"
#include "tests/player/gl_calls.h"
#include "tests/sun_light.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_view_suns {
namespace {

namespace fs = std::filesystem;

// A uniform light of radiance 1 and a sun.
LightFile sunny(const SunD& sun) {
    LightFile light = synthetic::withSun(synthetic::light(4, 0), sun);
    light.name = "sunny";
    return light;
}

const SunD kSun{{0.6, 0.8, 0}, {3, 2.5, 2}, 0.01};

// Two tubes on a ground, the second one turned. Materials: "lambert", "live"; lights: "sunny", "uniform".
class ViewSuns : public testing::Test {
protected:
    fs::path folder = fs::path(testing::TempDir()) / ("view_suns_" + std::to_string(getpid()));
    UpdateCost cost;
    std::unique_ptr<Scene> scene;
    ViewState state;

    void SetUp() override {
        fs::create_directories(folder);
        BrdfFile live;
        live.name = "live";
        live.slice_order = live.view_order = 1;
        live.even_index = {0};
        live.lobes = {lobeOf(parseBrdf("phong-live:exponent=10"))};
        const std::array materials = {synthetic::lambert({0.5, 0.5, 0.5}), live};
        const std::array lights = {sunny(kSun), synthetic::light(4, 0)};
        writeWholeFile(folder / "tube.pnb",
                       packAsset(synthetic::composedTube({.rings = 12, .segments = 9, .joints = 6, .clusters = 4}),
                                 materials, lights, {.precision = AssetPrecision::kF32}, "{}", 1)
                           .bytes);
        writeWholeFile(folder / "s.json",
                       R"({"version": 1, "characters": [{"asset": "tube.pnb", "casts": "nothing"},
                           {"asset": "tube.pnb", "position": [0.6, 0, 0.1], "yaw": 40}],
                           "ground": {"size": 6, "resolution": 17}})");
        const std::array files = {folder / "s.json"};
        scene = std::make_unique<Scene>(openScene(files, 1));
        state = stateFor(*scene, {});
        applySceneFile(*scene, state);
    }
    void TearDown() override { fs::remove_all(folder); }

    void update() { updateScene(*scene, state, {.values = true, .threads = 1}, cost); }
    void press(int key) { applyKey(state, *scene, {key, false}); }
    bool saysSuns() const { return describe(*scene, state).find("suns with shadow maps") != std::string::npos; }
    const std::vector<Vec3>& shown(std::size_t i) const {
        return (*scene->characters[i]->shown.values)[std::size_t(Shown::kModel)];
    }
};

TEST_F(ViewSuns, ShineUntilTheyAreSwitchedOff) {
    update();
    EXPECT_TRUE(showsSuns(*scene, state) && saysSuns());
    EXPECT_TRUE(scene->characters[0]->shown.shading->sunsOn());
    const std::vector<Vec3> soft = shown(0), soft_ground = *scene->ground.values;
    press('H');
    update();
    EXPECT_FALSE(showsSuns(*scene, state) || saysSuns());
    EXPECT_FALSE(scene->characters[0]->shown.shading->sunsOn());
    EXPECT_NE(shown(0), soft);
    EXPECT_NE(*scene->ground.values, soft_ground);
    press('H');
    update();
    EXPECT_TRUE(saysSuns());
    EXPECT_EQ(shown(0), soft);
    EXPECT_EQ(*scene->ground.values, soft_ground);
}

TEST_F(ViewSuns, WhatKeepsThemFromShiningIsSaid) {
    const auto refuses = [&](ViewState changed, std::string_view reason) {
        EXPECT_EQ(whyNoSuns(*scene, changed), reason);
        EXPECT_FALSE(showsSuns(*scene, changed));
    };
    EXPECT_EQ(whyNoSuns(*scene, state), "");
    ViewState changed = state;
    changed.lighting.light = 1;
    refuses(changed, "the light has no suns");
    changed = state;
    changed.lighting.shading.light_form = LightForm::kFixed;
    refuses(changed, "suns need the exact rotation");
    for (const Shadows shadows : {Shadows::kSelf, Shadows::kCast, Shadows::kNone}) {
        changed = state;
        changed.show.shadows = shadows;
        refuses(changed, "suns need all shadows");
    }
}

// Other channels have no light, and a difference is one of what vertices show, which is SH.
TEST_F(ViewSuns, AreForShadedColorsAlone) {
    for (const Channel channel : {Channel::kAmbient, Channel::kNormals, Channel::kError}) {
        state.show.channel = channel;
        EXPECT_FALSE(showsSuns(*scene, state));
    }
    state.show.channel = Channel::kShaded;
    for (const Compare compare : {Compare::kTruth, Compare::kSideBySide, Compare::kWipe}) {
        state.show.compare = compare;
        EXPECT_TRUE(showsSuns(*scene, state));
    }
    state.show.compare = Compare::kDifference;
    EXPECT_FALSE(showsSuns(*scene, state));
    state.show.compare = Compare::kModel;
    state.show.component = 0;
    EXPECT_FALSE(showsSuns(*scene, state));
}

TEST_F(ViewSuns, RemainderIsTheLightWithoutThem) {
    const std::vector<float> rest = remainderOf(scene->characters[0]->asset.lights[0]);
    EXPECT_NEAR(rest[0], std::sqrt(4 * std::numbers::pi), 1e-5);
    for (std::size_t i = 3; i < rest.size(); ++i) EXPECT_NEAR(rest[i], 0, 2e-6) << i;
}

// Everyone's ShadingSet has the light in their own frame.
TEST_F(ViewSuns, TurnWithTheLight) {
    for (const double turn : {0.0, 70.0}) {
        state.lighting.yaw = turn;
        state.lighting.pitch = -turn / 2;
        update();
        const std::vector<Sun> suns = sunsOf(scene->characters[0]->asset.lights[0], lightRotation(state));
        ASSERT_EQ(suns.size(), 1u);
        EXPECT_NEAR(length(suns[0].direction - lightRotation(state) * toFloat(kSun.direction)), 0, 1e-6);
        for (const auto& character : scene->characters)
            EXPECT_NEAR(length(character->posed.to_scene.linear() * character->shown.shading->suns()[0].direction -
                               suns[0].direction),
                        0, 1e-6);
    }
}

TEST_F(ViewSuns, ExposureIsMeasuredAnew) {
    const ExposedLook with = exposedLook(*scene, state);
    press('H');
    EXPECT_NE(exposedLook(*scene, state), with);
}

// A character that casts nothing in SH casts in the map, so its pose counts, too.
TEST_F(ViewSuns, EveryMoveCounts) {
    update();
    const ViewKeys before = keysOf(*scene, state);
    update();
    EXPECT_EQ(keysOf(*scene, state).suns, before.suns);
    state.characters[0].moved = {0.1f, 0, 0};
    update();
    EXPECT_NE(keysOf(*scene, state).suns, before.suns);
    EXPECT_EQ(keysOf(*scene, state).ground, before.ground);
}

// A picture has no SH of suns that somebody stored: it is factored when it is opened.
TEST_F(ViewSuns, ArePartOfPicturesThatAreOpened) {
    Image sky{64, 32, std::vector<Vec3>(64 * 32, Vec3{0.5f, 0.5f, 0.5f}), {}};
    writeExr(folder / "flat.exr", sky);
    const MapShape shape{MapLayout::kLatLong, sky.width, sky.height};
    sky.pixels[8 * 64 + 20] = {300, 280, 250};
    writeExr(folder / "sun.exr", sky);
    const std::array files = {folder / "s.json", folder / "sun.exr", folder / "flat.exr"};
    *scene = openScene(files, 1);
    state = stateFor(*scene, {});
    ASSERT_EQ(scene->light_names.size(), 4u);
    const LightView &sun = scene->characters[0]->asset.lights[2], &flat = scene->characters[0]->asset.lights[3];
    ASSERT_EQ(sun.suns.size(), 1u);
    EXPECT_GT(dot(toDouble(sun.suns[0].direction), mapDirection(shape, 20.5, 8.5)), std::cos(0.02));
    const double pixel = mapSteradians(shape, 20.5, 8.5);
    EXPECT_NEAR(sun.suns[0].irradiance.x, 300 * pixel, 0.1 * 300 * pixel);
    EXPECT_TRUE(flat.suns.empty());
    for (const LightView* light : {&sun, &flat}) {
        EXPECT_GT(light->picture.width, 0);
        EXPECT_EQ(light->picture.texels.size(), std::size_t(3 * light->picture.width * light->picture.height));
    }
    state.lighting.light = 2;
    EXPECT_EQ(whyNoSuns(*scene, state), "");
    update();
    EXPECT_TRUE(saysSuns());
    state.lighting.light = 3;
    EXPECT_EQ(whyNoSuns(*scene, state), "the light has no suns");
}

// On the way to the light without suns the sun fades, everyone has the same light, and the picture says so.
TEST_F(ViewSuns, FadeWhereTheLightIsSwitched) {
    scene->blend = LightBlend({.seconds = 1, .sun_time = 0.1});
    advanceLight(*scene, state, 0);
    update();
    const LightKey before = shownLightKey(*scene, state);
    const std::vector<Vec3> sunny = shown(0);
    state.lighting.light = 1;
    advanceLight(*scene, state, 0.5);
    update();
    EXPECT_NE(shownLightKey(*scene, state), before);
    EXPECT_NE(describe(*scene, state).find("light uniform (50% of the way from sunny)"), std::string::npos);
    const LightView light = shownLight(*scene, state);
    ASSERT_EQ(light.suns.size(), 1u);
    EXPECT_LT(light.suns[0].irradiance.x, kSun.irradiance.x);
    EXPECT_GT(light.suns[0].irradiance.x, 0.2 * kSun.irradiance.x);
    EXPECT_TRUE(saysSuns());
    for (const auto& character : scene->characters) {
        ASSERT_EQ(character->shown.shading->suns().size(), 1u);
        EXPECT_EQ(character->shown.shading->suns()[0].irradiance, light.suns[0].irradiance);
    }
    EXPECT_NEAR(length(scene->characters[1]->posed.to_scene.linear() *
                           scene->characters[1]->shown.shading->suns()[0].direction -
                       lightRotation(state) * light.suns[0].direction),
                0, 1e-6);
    EXPECT_NE(exposedLook(*scene, state).light, before);
    for (int i = 0; i < 20; ++i) advanceLight(*scene, state, 0.1);
    update();
    EXPECT_FALSE(saysSuns() || scene->blend.active());
    EXPECT_EQ(scene->characters[0]->shown.shading->light(), 1u);
    state.lighting.light = 0;
    for (int i = 0; i < 30; ++i) {
        advanceLight(*scene, state, 0.1);
        update();
    }
    EXPECT_EQ(shown(0), sunny) << "back where it was, to the bit";
}

// Other forms than the exact rotation cannot be mixed.
TEST_F(ViewSuns, OtherFormsOfLightSwitchAtOnce) {
    scene->blend = LightBlend({.seconds = 1, .sun_time = 0.1});
    advanceLight(*scene, state, 0);
    state.lighting.light = 1;
    advanceLight(*scene, state, 0.1);
    EXPECT_TRUE(scene->blend.active());
    state.lighting.shading.light_form = LightForm::kFixed;
    advanceLight(*scene, state, 0.1);
    EXPECT_FALSE(scene->blend.active());
    update();
    EXPECT_EQ(scene->characters[0]->shown.shading->light(), 1u);
}

int& dispatches() {
    static int count = 0;
    return count;
}
decltype(gl::DispatchCompute) gl_dispatch = nullptr;

// A map ends with compute passes, which are counted.
TEST_F(ViewSuns, MapsAreDrawnWhenSomethingChanged) {
    const std::unique_ptr<GlContext> context = createGlContext(GlBackend::kOsMesa);
    ViewSunlight sunlight(*scene);
    gl_dispatch = std::exchange(
        gl::DispatchCompute, +[](GLuint x, GLuint y, GLuint z) { ++dispatches(), gl_dispatch(x, y, z); });
    const auto draws = [&] {
        const int before = dispatches();
        update();
        sunlight.shine(state);
        return dispatches() > before;
    };
    EXPECT_TRUE(draws());
    EXPECT_FALSE(draws()) << "nothing changed";
    state.camera.yaw += 1;
    EXPECT_FALSE(draws()) << "maps are the same from everywhere";
    state.lighting.yaw = 10;
    EXPECT_TRUE(draws());
    state.playhead.time = 0.2;
    EXPECT_TRUE(draws());
    state.characters[1].moved = {0.2f, 0, 0};
    EXPECT_TRUE(draws());
    EXPECT_FALSE(draws());
    gl::DispatchCompute = gl_dispatch;
    std::vector<Vec3> values(scene->characters[1]->posed.vertices.positions.size());
    const SunlitSurface surface = sunlight.surfaceOf(1, {0, 0, 5}, values);
    EXPECT_EQ(surface.lobes.size(), values.size());
    EXPECT_TRUE(surface.sight.empty()) << "nothing is a mirror";
    EXPECT_NE(sunlight.groundLobes(1), sunlight.groundLobes(kTileShades[1])) << "tiles have two colours";
}

// The lobes of the last frame make room for those of this one: in the table, and in the buffer of the GPU. The maps
// stay as they are.
TEST_F(ViewSuns, ADraggedSliderMakesNothing) {
    const std::unique_ptr<GlContext> context = createGlContext(GlBackend::kOsMesa);
    ViewSunlight sunlight(*scene);
    constexpr std::size_t kLive = 1;
    state.characters[0].material_of_slot[0] = kLive;
    chooseParameter(*scene, state, kLive, 5);
    update();
    sunlight.shine(state);
    const std::size_t lobes = sunlight.lobes().size();
    const BrdfModels models = sunlight.sunlight().models();
    const player_test::GlCalls calls;
    for (int frame = 0; frame < 300; ++frame) {
        chooseParameter(*scene, state, kLive, 10 + frame);
        update();
        sunlight.shine(state);
        ASSERT_EQ(sunlight.lobes().size(), lobes) << frame;
        ASSERT_EQ(sunlight.sunlight().models(), models);
    }
    EXPECT_EQ(calls.made(), 0);
    const std::span<const SlotLobes> shown = sunlight.slotLobes(0);
    ASSERT_EQ(shown.size(), 1u);
    EXPECT_EQ(sunlight.lobes()[std::size_t(shown[0].first)].parameters[0], 309) << "what the slider says";
    EXPECT_EQ(sunlight.lobes()[std::size_t(sunlight.slotLobes(1)[0].first)].model, BrdfModel::kLambert);
}

}  // namespace
}  // namespace penumbra::test_view_suns
