// The keys of a view determine what is drawn: if nothing changed, nothing is computed or drawn, and each key and
// control gives another picture, equal to the picture of a scene that was just opened.
#include <gtest/gtest.h>
#include <unistd.h>

#include <deque>
#include <functional>
#include <set>

#include "formats/common/write_file.h"
#include "pack/pack_asset.h"
#include "player/view/view_actions.h"
#include "player/view/view_controls.h"
#include "sh/quadrature.h"
#include "tests/difference.h"
#include "tests/synthetic_composition.h"
#include "tests/synthetic_indirect.h"
#include "tests/synthetic_morphs.h"

namespace penumbra::test_view_keys {
namespace {

namespace fs = std::filesystem;

// Two tubes with truth, parts, spheres, slots, light that bounces and a live material, on a level ground or on waves.
class ViewKeysTest : public testing::TestWithParam<bool> {
protected:
    fs::path folder = fs::path(testing::TempDir()) / ("view_keys_" + std::to_string(getpid()));
    UpdateCost cost;
    std::vector<float> moments;
    std::deque<AssetView> truths;  // truth of each scene that was opened

    void SetUp() override {
        fs::create_directories(folder);
        Model model = synthetic::composedTube({.rings = 8, .segments = 6, .joints = 4, .clusters = 3, .components = 3});
        synthetic::addIndirect(model);
        model.mesh.slots = {"skin", "cloth"};
        for (std::size_t v = 0; v < model.mesh.vertexCount(); ++v)
            model.mesh.slot_of_vertex.push_back(std::uint16_t(v % 2));
        BrdfFile live;
        live.name = "live";
        live.slice_order = live.view_order = 1;
        live.even_index = {0};
        live.lobes = {lobeOf(parseBrdf("phong-live:exponent=10"))};
        const std::array materials = {synthetic::lambert({0.5, 0.5, 0.5}), live};
        LightFile sunny = synthetic::light(4, 0.3);
        sunny.name = "sunny";
        sunny.suns = {{{0.6, 0.8, 0}, {3, 2.5, 2}, 0.01}};
        sunny.factor = "exact";
        const std::array lights = {sunny, synthetic::light(4, 0.1)};
        writeWholeFile(folder / "tube.pnb",
                       packAsset(model, materials, lights, {.precision = AssetPrecision::kF32}, "{}", 1).bytes);
        writeWholeFile(folder / "s.json",
                       std::string(R"({"version": 1, "characters": [{"asset": "tube.pnb", "time": 0.3},
                           {"asset": "tube.pnb", "position": [0.6, 0, 0.1], "yaw": 40}], "ground": {)") +
                           (GetParam() ? R"("heights": {"analytic": "waves:height=0.2,length=2", "rows": 12,
                               "columns": 12, "cell": 0.3}}})"
                                       : R"("size": 6, "resolution": 9}})"));
    }
    void TearDown() override { fs::remove_all(folder); }

    Scene open() {
        const std::array files = {folder / "s.json"};
        Scene scene = openScene(files, 1);
        const AssetView& asset = scene.characters[0]->asset;
        moments.resize(asset.animation.frameCount() * asset.mesh.positions.size() * 25, 0.05f);
        for (std::size_t i = 0; i < moments.size(); i += 25) moments[i] = 1.2f;
        AssetView& truth = truths.emplace_back();
        truth.has_mesh = truth.has_truth = true;
        truth.mesh = asset.mesh;
        truth.animation = asset.animation;
        truth.truth = {5, false, AssetPrecision::kF32, std::as_bytes(std::span(moments))};
        for (const auto& character : scene.characters) character->truth = &truth;
        return scene;
    }
    // A state in which every key has something to do.
    static ViewState livedIn(const Scene& scene) {
        ViewState state = stateFor(scene, {});
        applySceneFile(scene, state);
        state.playhead.time = 0.1;
        state.frame_all = false;
        state.lighting.yaw = 30;
        state.inspect.picked = PickedVertex{0, 3};
        state.inspect.score_edit = ScoreEdit{0, 0, {0.1f, 0, 0}};
        state.window.help = true;
        state.window.sequence = 3;
        return state;
    }
    bool update(Scene& scene, const ViewState& state) {
        return updateScene(scene, state, {.values = true, .threads = 1}, cost);
    }
    // Goes through all controls that are there. Each is given another value.
    static void changeEach(const Scene& scene, const ViewState& state,
                           const std::function<void(const ViewState& changed, const std::string& name)>& use) {
        for (const Control& control : controls()) {
            if (control.exists && !control.exists(scene, state)) continue;
            if (control.works && !control.works(scene, state)) continue;
            const auto change = [&](auto&& how) {
                ViewState changed = state;
                how(changed);
                use(changed, control.id);
            };
            if (const auto* menu = std::get_if<const Menu*>(&control.does)) {
                for (std::size_t i = 0; i < (*menu)->names(scene, state).size(); ++i)
                    if (i != (*menu)->chosen(state) && (*menu)->offers(scene, i))
                        change([&](ViewState& changed) { (*menu)->choose(changed, scene, i); });
            } else if (const auto* turn = std::get_if<Switch>(&control.does)) {
                change([&](ViewState& changed) { turn->of(changed) = !turn->of(changed); });
            } else {
                const auto& slider = std::get<Slider>(control.does);
                const SliderRange range = slider.rangeOf(scene, state);
                for (const double value : {range.least, 0.3 * range.least + 0.7 * range.most, range.most})
                    if (float(value) != float(slider.get(scene, state)))
                        change([&](ViewState& changed) { slider.set(changed, scene, value); });
            }
        }
    }
    static void expectAlike(std::span<const Vec3> shown, std::span<const Vec3> fresh, const std::string& name) {
        ASSERT_EQ(shown.size(), fresh.size()) << name;
        for (std::size_t v = 0; v < shown.size(); ++v)
            ASSERT_LT(length(shown[v] - fresh[v]), 2e-4f * (1 + length(fresh[v]))) << name << ", vertex " << v;
    }
    // Expects that a scene with a history shows the same as one that was just opened.
    void expectFresh(const Scene& scene, const ViewState& state, const std::string& name) {
        Scene fresh = open();
        update(fresh, state);
        const Compare compare = shownCompare(state);
        for (std::size_t i = 0; i < scene.characters.size(); ++i) {
            const Character &shown = *scene.characters[i], &other = *fresh.characters[i];
            EXPECT_EQ(shown.posed.to_scene, other.posed.to_scene) << name;
            EXPECT_EQ(shown.shown.channel, other.shown.channel) << name;
            if (compare != Compare::kTruth)
                expectAlike(shown.shown.of(Shown::kModel), other.shown.of(Shown::kModel), name);
            if (compare != Compare::kModel)
                expectAlike(shown.shown.of(Shown::kTruth), other.shown.of(Shown::kTruth), name);
            if (compare == Compare::kDifference)
                expectAlike(shown.shown.of(Shown::kDifference), other.shown.of(Shown::kDifference), name);
            if (state.inspect.picked) {
                EXPECT_EQ(shown.posed.factors->size(), other.posed.factors->size()) << name;
            }
        }
        if (state.show.ground) expectAlike(*scene.ground.values, *fresh.ground.values, name);
    }
};
INSTANTIATE_TEST_SUITE_P(OnBothGrounds, ViewKeysTest, testing::Bool(),
                         [](const auto& of) { return of.param ? "Heights" : "Level"; });

TEST_P(ViewKeysTest, NothingIsMadeOrDrawnWhereNothingChanged) {
    Scene scene = open();
    const ViewState state = livedIn(scene);
    EXPECT_TRUE(update(scene, state));
    const FrameKey drawn = frameKey(scene, state);
    EXPECT_FALSE(update(scene, state));
    EXPECT_EQ(frameKey(scene, state), drawn);
    changeEach(scene, state, [&](const ViewState& changed, const std::string& name) {
        update(scene, changed);
        EXPECT_FALSE(update(scene, changed)) << name;
    });
}

// A key has another effect with Shift or the same.
TEST_P(ViewKeysTest, EveryKeyDrawsAnotherFrame) {
    Scene scene = open();
    const ViewState state = livedIn(scene);
    update(scene, state);
    for (const Shortcut& shortcut : shortcuts())
        for (const bool shift : {false, true}) {
            if (shortcut.key == '0' && !GetParam()) continue;  // the brush is for heights
            if (shortcut.key == 'E' && shift) continue;        // the exposure is automatic already
            ViewState changed = state;
            if (shortcut.key == '1') changed.show.channel = Channel::kNormals;  // shaded is what is on
            if (shortcut.key == 'Q') changed.window.sequence.reset();  // nobody quits while pictures are written
            const FrameKey before = frameKey(scene, changed);
            applyKey(changed, scene, {shortcut.key, shift});
            EXPECT_NE(frameKey(scene, changed), before) << shortcut.name << (shift ? ", Shift" : "");
        }
}

TEST_P(ViewKeysTest, EveryControlDrawsAnotherFrame) {
    Scene scene = open();
    std::set<std::string> tried;
    for (const int key : std::array<int, 6>{0, '3', '6', 'C', 'c', '0'}) {  // keys that bring controls of their own
        ViewState state = livedIn(scene);
        state.lighting.parameters[1] = 30;
        chooseMaterial(state, 1);
        if (key == 'C' || key == 'c')
            state.show.compare = key == 'C' ? Compare::kWipe : Compare::kDifference;
        else if (key)
            applyKey(state, scene, {key, false});
        update(scene, state);
        const FrameKey before = frameKey(scene, state);
        changeEach(scene, state, [&](const ViewState& changed, const std::string& name) {
            EXPECT_NE(frameKey(scene, changed), before) << name;
            tried.insert(name);
        });
    }
    for (const Control& control : controls()) {
        const std::string id = control.id;
        const bool needs_other = GetParam() ? id == "join" : id == "brush" || id == "radius" || id == "strength";
        EXPECT_NE(tried.contains(id), needs_other) << id;
    }
}

// Each control and each key in turn, one after the other: what one of them made before another takes part must not be
// seen.
TEST_P(ViewKeysTest, AChangedSceneShowsWhatAnOpenedOneShows) {
    Scene scene = open();
    ViewState state = livedIn(scene);
    state.lighting.shading = {};
    update(scene, state);
    expectFresh(scene, state, "at first");
    ViewState turned = state;
    chooseMaterial(turned, 1);
    turned.camera.yaw += 1;
    turned.playhead.time += 0.05;
    update(scene, turned);
    expectFresh(scene, turned, "seen from elsewhere");
    changeEach(scene, state, [&](const ViewState& changed, const std::string& name) {
        update(scene, changed);
        expectFresh(scene, changed, name);
    });
    for (const Shortcut& shortcut : shortcuts()) {
        applyKey(state, scene, {shortcut.key, false});
        update(scene, state);
        expectFresh(scene, state, std::string(shortcut.name));
    }
    state.characters[1].moved = {0.2f, 0, 0.1f};
    update(scene, state);
    expectFresh(scene, state, "moved");
}

// The sliders of morph targets pose the character, and "as the clip has them" gives the clip's weights back.
TEST_P(ViewKeysTest, WeightsOfTheUserPoseTheCharacter) {
    const Model model = synthetic::morphTube();
    const fs::path file = folder / "face.pnb";
    writeWholeFile(file, packAsset(model, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1).bytes);
    Scene scene = openScene(std::array{file}, 1);
    ViewState state = stateFor(scene, {});
    state.playhead.time = 0;
    update(scene, state);
    const std::vector<Vec3> of_clip = scene.characters[0]->posed.vertices.positions;
    state.inspect.weight_edit = WeightEdit{0, {1, 0.3f}};
    EXPECT_TRUE(update(scene, state));
    RestShape wanted;
    const std::size_t joints = model.skin.jointCount();
    const std::vector<Affine> bones(model.bones.begin(), model.bones.begin() + std::ptrdiff_t(joints));
    skinMorphed(model.mesh, model.skin, model.rest_normals, {bones, std::array{1.0f, 0.3f}}, wanted);
    std::vector<Vec3> in_asset;
    for (const std::uint32_t v : scene.characters[0]->asset.mesh.shading_point) in_asset.push_back(wanted.positions[v]);
    expectAlike(scene.characters[0]->posed.vertices.positions, in_asset, "edited");
    EXPECT_NE(of_clip, in_asset);
    state.inspect.weight_edit.reset();
    EXPECT_TRUE(update(scene, state));
    expectAlike(scene.characters[0]->posed.vertices.positions, of_clip, "as the clip has them");
}

}  // namespace
}  // namespace penumbra::test_view_keys
