// Tests what keys and drags make of the viewer's state, without a window.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "player/frame/orbit_camera.h"
#include "player/view/view_actions.h"
#include "player/view/view_layout.h"
#include "sh/light/light_rotation.h"

namespace penumbra::test_view_state {
namespace {

// Clip "a" has frames at 0, 0.5, 1 s and clip "b" one at 7 s, since an animation's times may run on from clip to
// clip.
struct Contents {
    std::array<double, 4> times = {0, 0.5, 1, 7};
    std::array<float, 4> bias{};
    Scene scene;
    Character& character;
    ViewState state;
    Contents() : character(*scene.characters.emplace_back(std::make_unique<Character>())) {
        character.asset.animation.clips = {{"a", 0, 3}, {"b", 3, 1}};
        character.asset.animation.times = times;
        character.asset.mesh.slots = {"skin", "cloth"};
        character.asset.model.clusters.emplace_back().bias = bias;  // four components
        character.truth = &character.asset;
        scene.material_names = {"grey", "red", "green"};
        scene.light_names = {"sky", "sun"};
        scene.cast = std::make_unique<CastShadow>(std::span<const Evaluator* const>());
        state.characters = {{0, {0, 1}}};
    }
    const AnimationView& animation() const { return character.asset.animation; }
    const ClipView& clip() const { return animation().clips[0]; }
    void press(int key, bool shift = false) { EXPECT_TRUE(applyKey(state, scene, {key, shift})) << key; }
    std::size_t frame() const { return selectedClip(state, scene).first_frame + shownPosition(state, scene, 0).frame; }
};

TEST(Playhead, EveryFrameIsShownFromItsTimeToTheNext) {
    Contents c;
    EXPECT_DOUBLE_EQ(clipSeconds(c.animation(), c.clip()), 1.5);
    const std::array<std::pair<double, std::size_t>, 8> expected = {
        {{0, 0}, {0.49, 0}, {0.5, 1}, {0.99, 1}, {1, 2}, {1.49, 2}, {1.5, 0}, {-0.1, 2}}};
    for (const auto& [time, number] : expected) EXPECT_EQ(frameNumber(c.animation(), c.clip(), time), number) << time;
    EXPECT_EQ(clipSeconds(c.animation(), c.animation().clips[1]), 0);
    EXPECT_EQ(frameNumber(c.animation(), c.animation().clips[1], 12.3), 0u);
}

TEST(Playhead, PlaysAtTheClipsRateTimesTheSpeed) {
    Contents c;
    advanceView(c.state, c.scene, 0.6);
    EXPECT_EQ(c.state.playhead.time, 0) << "paused";
    c.press(' ');
    advanceView(c.state, c.scene, 0.6);
    EXPECT_EQ(c.frame(), 1u);
    c.press(kKeyUp);
    c.press('I');
    advanceView(c.state, c.scene, 0.5);  // 0.6 + 2 * 0.5 = 1.6: 0.1 after the start
    EXPECT_NEAR(c.state.playhead.time, 0.1, 1e-12);
    c.press(kKeyRight);
    EXPECT_FALSE(c.state.playhead.playing);
    EXPECT_EQ(c.frame(), 1u);
}

TEST(ViewActions, StepsGoRoundTheClip) {
    Contents c;
    for (const std::size_t frame : {2u, 1u, 0u, 2u}) {
        c.press(kKeyLeft);
        EXPECT_EQ(c.frame(), frame);
    }
    c.press(kKeyRight, /*shift=*/true);  // ten frames of three
    EXPECT_EQ(c.frame(), 0u);
    c.press(kKeyPageUp);
    EXPECT_EQ(c.frame(), 3u) << "the other clip's only frame";
}

TEST(ViewActions, TruthKeepsTimeOnSampledFrames) {
    Contents c;
    c.state.playhead.time = 0.75;
    EXPECT_EQ(shownPosition(c.state, c.scene, 0), (ClipPosition{1, 2, 0.5}));
    for (const int key : {'I', 'T', '3'}) {
        c.press(key);
        EXPECT_EQ(shownPosition(c.state, c.scene, 0), (ClipPosition{1, 1, 0})) << char(key);
        c.press(key == '3' ? '2' : key);
        EXPECT_GT(shownPosition(c.state, c.scene, 0).part, 0) << char(key);
    }
    c.press(kKeyLeft);
    EXPECT_EQ(shownPosition(c.state, c.scene, 0), (ClipPosition{1, 2, 0})) << "back to the frame before";
    c.state.playhead.time = 0.75;
    c.press(kKeyRight);
    EXPECT_EQ(shownPosition(c.state, c.scene, 0), (ClipPosition{2, 2, 0}));
}

TEST(ViewActions, WorstFramesAreFound) {
    Contents c;
    const std::array<FrameError, 3> errors = {{{0.1f, 0.5f, true}, {0.3f, 0.4f, true}, {0.2f, 0.9f, true}}};
    const std::array<float, 3> ranges = {0, 0, 0.7f};
    c.press('W');
    EXPECT_EQ(c.state.playhead.time, 0) << "nothing is known yet";
    c.character.timeline.figures.errors.assign(errors.begin(), errors.end());
    c.character.timeline.figures.out_of_range.assign(ranges.begin(), ranges.end());
    c.press('W');
    EXPECT_EQ(c.frame(), 1u);
    c.press('W', /*shift=*/true);
    EXPECT_EQ(c.frame(), 2u);
    c.press(kKeyPageDown);
    c.press('W');
    EXPECT_EQ(c.frame(), 3u) << "the figures are of the other clip";
    EXPECT_EQ(c.state.playhead.time, 0);
}

// The user asks while figures are still missing: first the worst so far is shown, then the worst, unless the user has
// left.
TEST(ViewActions, TheWorstVertexIsPicked) {
    Contents c;
    pickWorst(c.state, c.scene);
    EXPECT_FALSE(c.state.inspect.picked) << "errors are not shown";
    c.character.shown.channel = Channel::kError;
    *c.character.posed.truth_frame = 0;
    std::vector<Vec3>& errors = (*c.character.shown.values)[std::size_t(Shown::kModel)];
    errors = {{0.1f, 0, 0}, {0.3f, 0, 0}, {0.2f, 0, 0}};
    pickWorst(c.state, c.scene);
    EXPECT_EQ(c.state.inspect.picked, (PickedVertex{0, 1}));
    c.state.inspect.picked.reset();
    *c.character.posed.truth_frame = std::nullopt;
    pickWorst(c.state, c.scene);
    EXPECT_FALSE(c.state.inspect.picked) << "the pose has no truth";
}

TEST(ViewActions, QuittingWaitsForPictures) {
    Contents c;
    c.press(kKeyF11);
    c.press('Q');
    EXPECT_FALSE(c.state.window.quit);
    c.press(kKeyEscape);
    c.press('Q');
    EXPECT_TRUE(c.state.window.quit);
}

TEST(ViewActions, TheWorstFrameIsShownWhenAllAreKnown) {
    const std::array<FrameError, 3> errors = {{{0.1f, 0.5f, true}, {0.2f, 0.4f, true}, {0.3f, 0.9f, true}}};
    for (const bool goes_away : {false, true}) {
        Contents c;
        c.character.timeline.figures.errors.assign(errors.begin(), errors.begin() + 2);
        c.press('W');
        EXPECT_EQ(c.frame(), 1u) << "so far";
        advanceView(c.state, c.scene, 0.1);
        EXPECT_EQ(c.frame(), 1u);
        EXPECT_TRUE(c.state.awaited);
        if (goes_away) c.press(kKeyHome);
        c.character.timeline.figures.errors.assign(errors.begin(), errors.end());
        advanceView(c.state, c.scene, 0.1);
        EXPECT_EQ(c.frame(), goes_away ? 0u : 2u);
        EXPECT_FALSE(c.state.awaited);
    }
    Contents c;
    c.character.truth = nullptr;
    const std::array<float, 3> ranges = {0, 0.7f, 0};
    c.character.timeline.figures.out_of_range.assign(ranges.begin(), ranges.end());
    c.press('W', /*shift=*/true);
    EXPECT_EQ(c.frame(), 1u);
    EXPECT_FALSE(c.state.awaited);
    c.press('W');
    EXPECT_FALSE(c.state.awaited) << "without truth there are no errors to wait for";
}

TEST(ViewActions, FactorsOfThePickedVertexTakeTurns) {
    Contents c;
    c.press('Y');
    EXPECT_EQ(c.state.inspect.factor, FactorChoice()) << "nothing is picked";
    c.state.inspect.picked = PickedVertex{0, 7};
    c.press('Y');
    EXPECT_EQ(c.state.inspect.factor, FactorChoice()) << "the character is not composed";
    const std::vector<VisibilityFactor> factors = {
        {{}, {}, {}, 0}, {{FactorKind::kLocal}, {}, {}, 0}, {{FactorKind::kPart, 3}, {}, {}, 0}};
    *c.character.posed.factors = factors;
    for (const std::size_t i : {1, 2, 0}) {
        c.press('Y');
        EXPECT_EQ(c.state.inspect.factor, factors[i].choice);
    }
    c.press('Y', /*shift=*/true);
    EXPECT_EQ(c.state.inspect.factor, factors[2].choice);
    c.state.inspect.factor = {FactorKind::kPart, 5};  // counted in another pose
    c.press('Y');
    EXPECT_EQ(c.state.inspect.factor, factors[1].choice) << "it goes on from the whole";
    c.press('7');
    EXPECT_NE(c.state.show.channel, Channel::kParts) << "there are none";
    c.character.asset.model.composition.emplace();
    c.press('7');
    EXPECT_EQ(c.state.show.channel, Channel::kParts);
    c.press('U');
    EXPECT_TRUE(c.state.show.boxes);
}

TEST(ViewActions, MaterialsChangeOnTheChosenSlots) {
    Contents c;
    using Slots = std::vector<std::size_t>;
    const Slots& slots = c.state.characters[0].material_of_slot;
    c.press('M');
    EXPECT_EQ(slots, (Slots{1, 1}));
    c.press('S');
    c.press('M', true);
    EXPECT_EQ(slots, (Slots{1, 0}));
    c.press('S');  // all
    c.press('M');
    EXPECT_EQ(slots, (Slots{2, 2}));
    c.press('L');
    c.press('L');
    EXPECT_EQ(c.state.lighting.light, 0u);
}

TEST(ViewActions, WithoutTruthThereIsNothingToCompare) {
    Contents c;
    c.press('T');
    EXPECT_EQ(c.state.show.compare, Compare::kTruth);
    c.press('T');
    for (int i = 0; i < 4; ++i) c.press('C');
    EXPECT_EQ(c.state.show.compare, Compare::kDifference);
    c.press('4');
    EXPECT_EQ(shownCompare(c.state), Compare::kModel) << "clusters are the model's";
    Contents bare;
    bare.character.truth = nullptr;
    bare.scene.light_names.clear();
    bare.state.show.channel = Channel::kAmbient;
    for (const int key : {'T', 'C', '3', '1'}) bare.press(key);
    EXPECT_EQ(bare.state.show.compare, Compare::kModel);
    EXPECT_EQ(bare.state.show.channel, Channel::kAmbient);
}

// The first clip is not in the truth. Nothing that stands in for truth may pass for it.
TEST(ViewActions, AClipWithoutTruthIsSaidToHaveNone) {
    Contents c;
    AssetView partial = c.character.asset;
    partial.animation.clips = {{"b", 3, 1}};
    c.character.truth = &partial;
    const std::array<FrameError, 3> errors = {FrameError{0.1f, 0.2f, false}, {0.3f, 0.4f, false}, {0, 0, false}};
    c.character.timeline.figures.errors.assign(errors.begin(), errors.end());
    EXPECT_EQ(whyNoTruth(c.scene, c.state), "no baked truth of this clip");
    c.press('W');
    EXPECT_EQ(c.frame(), 0u) << "no frame has an error";
    c.press('T');
    EXPECT_EQ(whyUnseen(c.state, c.scene, {'T', false}), "T (baked truth or model): no baked truth of this clip");
    c.press('3');
    EXPECT_EQ(whyUnseen(c.state, c.scene, {'3', false}), "3 (error against the truth): no baked truth of this clip");
    chooseClip(c.state, 1);
    EXPECT_EQ(whyNoTruth(c.scene, c.state), "");
    EXPECT_EQ(whyUnseen(c.state, c.scene, {'3', false}), "");
    c.state.inspect.weight_edit = WeightEdit{0, {1}};
    EXPECT_EQ(whyNoTruth(c.scene, c.state), "no baked truth of this pose");
    c.character.truth = nullptr;
    EXPECT_EQ(whyNoTruth(c.scene, c.state), "no baked truth is open (F2)");
}

// Keys change what the picture that is on does not show, and say where it shows.
TEST(ViewActions, AKeyWhoseChangeIsNotSeenSaysSo) {
    Contents c;
    const auto unseen = [&](int key) { return whyUnseen(c.state, c.scene, {key, false}); };
    for (const int key : {'M', 'L', 'K', 'V', 'P', 'E', 'D', 'O', 'B', 'J', 'C', 'G', 'N'}) EXPECT_EQ(unseen(key), "");
    EXPECT_EQ(unseen('H'), "H (suns of the light with shadow maps, or all light as SH): no material or no light");
    EXPECT_EQ(unseen('['), "[ (error scale to a smaller number): shows in the picture of errors (3)");
    EXPECT_EQ(unseen('U'),
              "U (boxes of fields, or spheres, that characters cast by): no character here has boxes or "
              "spheres to cast by");
    EXPECT_EQ(unseen('.'), ". (larger brush): shows with the brush (0)");
    EXPECT_EQ(unseen(';'), "");
    c.press('5');
    for (const int key : {'M', 'L', 'K', 'H', 'V', 'P', 'E', 'D', 'O', 'B'})
        EXPECT_TRUE(unseen(key).ends_with("): shows in shaded pictures (1)")) << unseen(key);
    EXPECT_TRUE(unseen('J').ends_with("): shows in shaded pictures, ambient visibility and errors (1, 2, 3)"));
    const ViewState normals = c.state;
    for (const int key : {'C', 'T'}) c.press(key);
    EXPECT_EQ(c.state, normals) << "nothing is compared where the change would not be seen";
    c.press('2');
    c.press('C');
    EXPECT_EQ(unseen('C'), "");
    EXPECT_TRUE(unseen('I').ends_with("between sampled frames there is none"));
}

TEST(ViewActions, KeysAndFilesTakeTurnsInThePanel) {
    Contents c;
    c.state.window.recent = {"/rigs/man.pnb"};
    c.press(kKeyF2);
    EXPECT_EQ(c.state.window.browsed, "/rigs") << "where the last file came from";
    c.press(kKeyF1);
    EXPECT_TRUE(c.state.window.help);
    EXPECT_FALSE(c.state.window.browsed);
    c.press(kKeyF2);
    EXPECT_TRUE(c.state.window.browsed);
    EXPECT_FALSE(c.state.window.help);
    c.press(kKeyF2);
    EXPECT_FALSE(showsPanels(c.state) && (c.state.window.browsed || c.state.window.help));
    c.press(kKeyF1);
    c.press(kKeyF1);
    EXPECT_FALSE(c.state.window.help);
}

TEST(ViewActions, ComponentsTakeTheChannelsPlace) {
    Contents c;
    c.press('T');
    for (const std::size_t component : {0u, 1u, 2u, 3u, 0u}) {
        c.press('6');
        EXPECT_EQ(c.state.show.component, component);
    }
    c.press('6', /*shift=*/true);
    EXPECT_EQ(c.state.show.component, 3u);
    EXPECT_EQ(shownCompare(c.state), Compare::kModel) << "truth has no components";
    c.press('1');
    EXPECT_FALSE(c.state.show.component);
    EXPECT_EQ(shownCompare(c.state), Compare::kTruth);
}

TEST(ViewActions, ScalesAndFormsGoByKeys) {
    Contents c;
    for (int i = 0; i < 100; ++i) c.press(']');
    EXPECT_EQ(c.state.show.error_max, 1);
    for (int i = 0; i < 100; ++i) c.press('[');
    EXPECT_EQ(c.state.show.error_max, 1e-3f);
    c.press('V');
    EXPECT_EQ(c.state.lighting.shading.light_form, LightForm::kLobes);
    c.press('V', /*shift=*/true);
    EXPECT_EQ(c.state.lighting.shading.light_form, LightForm::kRotation);
    c.press('P');
    EXPECT_EQ(c.state.lighting.shading.reflectance, Reflectance::kOperators);
    c.state.inspect.score_edit = ScoreEdit{0, 0, {1}};
    c.press('Z');
    EXPECT_FALSE(c.state.inspect.score_edit);
}

TEST(ViewActions, ExposureIsAutomaticUntilItIsFixed) {
    Contents c;
    EXPECT_TRUE(c.state.automatic_exposure);
    c.state.display.exposure = 0.01f;  // the value that automatic exposure measured
    c.press('D');
    EXPECT_FALSE(c.state.automatic_exposure);
    EXPECT_FLOAT_EQ(c.state.display.exposure, 0.008f);
    c.press('E');
    EXPECT_FLOAT_EQ(c.state.display.exposure, 0.01f);
    EXPECT_FALSE(c.state.automatic_exposure);
    c.press('E', /*shift=*/true);
    EXPECT_TRUE(c.state.automatic_exposure);
    EXPECT_FLOAT_EQ(c.state.display.exposure, 0.01f) << "until it is measured";
}

TEST(ViewActions, EveryKeyIsThereOnce) {
    std::set<int> keys;
    for (const Shortcut& shortcut : shortcuts()) {
        EXPECT_TRUE(keys.insert(shortcut.key).second) << shortcut.name;
        EXPECT_FALSE(shortcut.text.empty());
        Contents c;
        c.press(shortcut.key);
        c.press(shortcut.key, true);
    }
    Contents c;
    EXPECT_FALSE(applyKey(c.state, c.scene, {';', false}));
}

TEST(ViewState, LightTurnsAsOnTheCommandLine) {
    ViewState state;
    state.lighting.yaw = 33;
    state.lighting.pitch = -72;
    const Mat3d expected = parseLightRotation("yaw=33,pitch=-72");
    const Mat3 rotation = lightRotation(state);
    for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(double(rotation.m[i]), expected.m[i], 1e-6);  // float
    dragLight(state, 100, -50, 200);  // half the height to the right, a quarter up
    EXPECT_DOUBLE_EQ(state.lighting.yaw, 33 + 90);
    EXPECT_DOUBLE_EQ(state.lighting.pitch, -72 + 45);
}

TEST(OrbitCamera, FrameAllHoldsTheSphereAroundTheBox) {
    const BoundingBox box = boundsOf(std::array<Vec3, 3>{{{-1, 0, 2}, {3, 1, 2}, {0, 4, -5}}});
    EXPECT_EQ(box.low, (Vec3{-1, 0, -5}));
    EXPECT_EQ(box.high, (Vec3{3, 4, 2}));
    EXPECT_DOUBLE_EQ(box.radius(), 4.5);  // half of sqrt(16 + 16 + 49)
    for (const double aspect : {0.25, 1.0, 3.0}) {
        Camera camera;
        frameAll(camera, box, aspect);
        EXPECT_EQ(camera.target, (Vec3d{1, 2, -1.5}));
        // The sphere touches the narrower pair of sides.
        const double half = std::atan(std::tan(camera.vertical_fov / 2) * std::min(1.0, aspect));
        EXPECT_NEAR(camera.distance * std::sin(half), 4.5, 1e-12);
    }
}

TEST(OrbitCamera, DragsAndTheirOppositesCancel) {
    Camera camera;
    const Vec3d before = cameraPosition(camera);
    orbit(camera, 30, 40, 100);
    EXPECT_GT(cameraPosition(camera).y, before.y) << "dragged down, seen from above";
    orbit(camera, -30, -40, 100);
    pan(camera, 5, 7, 100);
    pan(camera, -5, -7, 100);
    EXPECT_NEAR(length(cameraPosition(camera) - before), 0, 1e-12);
    orbit(camera, 0, 1000, 100);
    EXPECT_NEAR(camera.pitch, 89 * std::numbers::pi / 180, 1e-12);
}

// A point at the target's depth moves with the pointer. The picture is 100 pixels high.
TEST(OrbitCamera, PanFollowsThePointer) {
    Camera camera{.target = {1, 2, 3}, .yaw = 0.7, .pitch = 0.4, .distance = 5};
    const Vec3d point = camera.target;
    pan(camera, 20, 10, 100);
    const Vec3d towards = normalized(point - cameraPosition(camera));
    const Vec3d pixel = pixelDirection(camera, 50 + 20, 50 + 10, 100, 100);
    EXPECT_NEAR(length(towards - pixel), 0, 1e-9);
}

TEST(ViewLayout, PanesCoverThePictureOnce) {
    const Rectangle picture = pictureArea(1001, 700, 1.5f);
    EXPECT_EQ(picture.x + picture.width, 1001);
    ViewState state;
    for (const Compare compare :
         {Compare::kModel, Compare::kTruth, Compare::kSideBySide, Compare::kWipe, Compare::kDifference}) {
        state.show.compare = compare;
        int area = 0;
        for (const Pane& pane : panesOf(state, picture)) area += pane.clip.width * pane.clip.height;
        EXPECT_EQ(area, picture.width * picture.height);
    }
    const Rectangle tiny = pictureArea(10, 10, 2);
    EXPECT_GE(tiny.width, 1);
    EXPECT_GE(tiny.height, 1);
}

}  // namespace
}  // namespace penumbra::test_view_state
