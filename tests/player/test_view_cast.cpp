// Scenes in the window: who stands where, and whose shadow is shown.
#include <gtest/gtest.h>
#include <unistd.h>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "formats/scene/scene_placement.h"
#include "pack/pack_asset.h"
#include "player/papers/sphere_cast.h"
#include "player/render/scene_frames.h"
#include "player/scene/scene_receivers.h"
#include "player/scene/side_by_side.h"
#include "player/view/view_controls.h"
#include "player/view/view_pick.h"
#include "tests/difference.h"
#include "tests/runtime/count_allocations.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_view_cast {
namespace {

namespace fs = std::filesystem;

const synthetic::TubeOptions kTube{
    .rings = 20, .segments = 9, .joints = 6, .clusters = 4, .components = 5, .inputs = 4};

class ViewCast : public testing::Test {
protected:
    fs::path folder = fs::path(testing::TempDir()) / ("view_cast_" + std::to_string(getpid()));
    UpdateCost cost;

    void SetUp() override {
        fs::create_directories(folder);
        const std::array materials = {synthetic::lambert({0.5, 0.5, 0.5})};
        const std::array lights = {synthetic::light(4, 0.1)};
        writeWholeFile(folder / "tube.pnb", packAsset(synthetic::composedTube(kTube), materials, lights,
                                                      {.precision = AssetPrecision::kF32}, "{}", 1)
                                                .bytes);
    }
    void TearDown() override { fs::remove_all(folder); }

    fs::path file(const std::string& members, const std::string& more = "") const {
        writeWholeFile(folder / "s.json", R"({"version": 1, "characters": [)" + members + "]" + more + "}");
        return folder / "s.json";
    }
    Scene open(const std::string& members, const std::string& more = "") const {
        const std::array files = {file(members, more)};
        return openScene(files, 1);
    }
    static ViewState stateOf(const Scene& scene) {
        ViewState state = stateFor(scene, {});
        applySceneFile(scene, state);
        return state;
    }
    void update(Scene& scene, const ViewState& state) {
        updateScene(scene, state, {.values = true, .threads = 2}, cost);
    }
};

const std::string kPair = R"({"asset": "tube.pnb", "time": 0.5}, )"
                          R"({"asset": "tube.pnb", "position": [0.6, 0, 0.1], "yaw": 40})";

TEST_F(ViewCast, ShowsTheNumbersOfTheScene) {
    const PosedScene posed(readScene(file(kPair)));
    Scene scene = open(kPair);
    ViewState state = stateOf(scene);
    state.smooth = false;
    update(scene, state);
    for (std::size_t i = 0; i < 2; ++i) {
        const FrameVertices expected = memberVertices(posed, i, 1);
        const Character& character = *scene.characters[i];
        EXPECT_EQ(character.posed.pose().frame, posed.members()[i]->frame);
        EXPECT_EQ(character.posed.to_scene, posed.members()[i]->to_scene);
        EXPECT_LT(largestDifference(character.posed.vertices.coefficients, expected.coefficients), 1e-5);
    }
}

// Without a file characters stand in the window where render puts them.
TEST_F(ViewCast, AssetsStandAsTheyAreRendered) {
    const std::vector<fs::path> files(3, folder / "tube.pnb");
    const SceneDescription row = sceneSideBySide(files);
    const Scene scene = openScene(files, 1);
    ASSERT_EQ(row.characters.size(), 3u);
    const BoundingBox rest = boundsOf(scene.characters[0]->asset.mesh.positions);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(scene.characters[i]->placement, placementOf(row.characters[i]));
        EXPECT_NEAR(row.characters[i].position.x, (double(i) - 1) * 4 / 3 * double(rest.high.x - rest.low.x), 1e-5);
        EXPECT_EQ(row.characters[i].name, i == 0 ? "tube" : "tube-" + std::to_string(i + 1));
    }
    ASSERT_TRUE(row.ground && scene.ground_file);
    EXPECT_NEAR(row.ground->height, rest.low.y, 1e-6);
    EXPECT_NEAR(row.ground->height, scene.ground_file->height, 1e-6);
    EXPECT_NEAR(row.ground->size, scene.ground_file->size, 1e-5);
    EXPECT_NEAR(length(row.ground->center - scene.ground_file->center), 0, 1e-6);
    EXPECT_EQ(PosedScene(row).cast().casterCount(), 3u);
}

TEST_F(ViewCast, ShadowsGoOnAndOff) {
    Scene scene = open(kPair), single = open(R"({"asset": "tube.pnb", "time": 0.5})");
    ViewState state = stateOf(scene), one = stateOf(single);
    update(scene, state);
    update(single, one);
    const std::vector<float>& coefficients = scene.characters[0]->posed.vertices.coefficients;
    const std::vector<float> both = coefficients, alone = single.characters[0]->posed.vertices.coefficients;
    EXPECT_GT(largestDifference(both, alone), 0.3);
    state.show.shadows = Shadows::kSelf;
    update(scene, state);
    EXPECT_EQ(coefficients, alone);
    state.show.shadows = Shadows::kNone;
    update(scene, state);
    const auto stride = std::size_t(scene.characters[0]->asset.model.stride);
    for (std::size_t i = 0; i < coefficients.size(); ++i)
        EXPECT_NEAR(coefficients[i], i % stride == 0 ? 2 * std::sqrt(std::numbers::pi) : 0, 1e-5);
    state.show.shadows = Shadows::kCast;
    update(scene, state);
    EXPECT_GT(largestDifference(coefficients, both), 0.3) << "without its own";
    state.show.shadows = Shadows::kBoth;
    update(scene, state);
    EXPECT_EQ(coefficients, both);
}

// How far the colours of everyone and of the ground in the window are from those of render, and how far render's are
// from what it shows of direct light.
struct LightApart {
    Largest members, ground, between, between_ground;
};

// The light that characters and the ground reflect to one another is the same in the window as in render. Both switches
// leave it out.
TEST_F(ViewCast, LightBetweenThingsIsThatOfRender) {
    for (const auto& [ground, bounces] :
         {std::pair(R"({"height": -0.6, "size": 3, "resolution": 40})", Bounces::kBoth),
          {R"({"height": -0.6, "size": 3, "resolution": 40})", Bounces::kDirect},
          {R"({"height": -0.6, "size": 3, "resolution": 40, "casts": false})", Bounces::kBoth}}) {
        const std::string more = std::string(R"(, "light": {"rotation": "yaw=40"}, "ground": )") + ground;
        const PosedScene posed(readScene(file(kPair, more)));
        const auto rendered = [&](Bounces of) {
            RenderOptions options;
            options.bounces = of;
            auto frames = std::make_unique<SceneFrames>(posed, options, 2);
            frames->evaluateMembers();
            frames->evaluateGround();
            frames->frameCamera();
            frames->shade();
            return frames;
        };
        const auto frames = rendered(bounces), direct = rendered(Bounces::kDirect);
        Scene scene = open(kPair, more);
        ViewState state = stateOf(scene);
        state.smooth = false;
        state.lighting.bounces = bounces;
        update(scene, state);
        LightApart apart;
        for (std::size_t i = 0; i < 2; ++i) {
            apart.members.add(largestDifference(scene.characters[i]->shown.of(Shown::kModel), frames->valuesOf(i)));
            apart.between.add(largestDifference(direct->valuesOf(i), frames->valuesOf(i)));
        }
        apart.ground.add(largestDifference(*scene.ground.values, frames->meshes().back().values));
        apart.between_ground.add(largestDifference(direct->meshes().back().values, frames->meshes().back().values));
        EXPECT_LT(apart.members, 1e-5);
        EXPECT_LT(apart.ground, 1e-5);
        EXPECT_EQ(apart.between > 0.01, bounces == Bounces::kBoth) << ground;
        EXPECT_EQ(apart.between_ground > 0.002, scene.ground_file->casts && bounces == Bounces::kBoth) << ground;
    }
}

// A frame keeps the room of the one before it. What is left are the functions that go to parallelFor() and tables of
// the light, which are as many for every mesh and ground: 87.
TEST_F(ViewCast, FramesOfLightBetweenThingsKeepTheirRoom) {
    PosedScene posed(readScene(file(kPair, R"(, "ground": {"height": -0.6, "size": 3, "resolution": 40})")));
    SceneFrames frames(posed, RenderOptions(), 1);
    const auto frame = [&] {
        posed.pose({});
        frames.evaluateMembers();
        frames.evaluateGround();
        frames.shade();
    };
    frame();
    frames.frameCamera();
    frame();
    const std::size_t before = allocationCount();
    frame();
    EXPECT_LT(allocationCount() - before, 100u);
}

// A ground that is not shown neither hides nor sends light.
TEST_F(ViewCast, AGroundThatIsNotShownTakesNothing) {
    const std::string one = R"({"asset": "tube.pnb", "time": 0.5})";
    Scene scene = open(one, R"(, "ground": {"height": -0.6, "size": 3, "resolution": 20})"), bare = open(one);
    ViewState state = stateOf(scene), of_bare = stateOf(bare);
    update(scene, state);
    update(bare, of_bare);
    const auto values = [](const Scene& of) { return of.characters[0]->shown.of(Shown::kModel); };
    EXPECT_GT(largestDifference(values(scene), values(bare)), 0.01);
    state.show.ground = false;
    update(scene, state);
    EXPECT_EQ(largestDifference(values(scene), values(bare)), 0);
}

// E of the first character, as it is shown.
std::vector<float> shownAmbient(const Scene& scene) {
    std::vector<float> e;
    for (const Vec3 value : scene.characters[0]->shown.of(Shown::kModel)) e.push_back(value.x);
    return e;
}

// The same where render draws the scene.
std::vector<float> renderedAmbient(const PosedScene& scene) {
    const SceneMember& member = *scene.members()[0];
    const CastMode mode = scene.castWay().mode;
    FrameVertices own;
    ownVertices(member, 1, own);
    std::vector<float> others;
    castOverSphere(scene.cast(), {.except = member.caster}, castOrderOf(mode),
                   {own.positions, own.normals, own.tangents}, 1, others);
    return castAmbient(mode, member.evaluator.asset().model, own, others);
}

// The casters have fields only, so that the papers' ways, which need spheres, are passed over.
TEST_F(ViewCast, ShadowsOfOthersJoinInOtherWays) {
    Scene scene = open(kPair);
    ViewState state = stateOf(scene);
    state.show.channel = Channel::kAmbient;
    state.smooth = false;
    update(scene, state);
    const std::vector<float> product = shownAmbient(scene);
    state.show.shadows = Shadows::kSelf;
    update(scene, state);
    const std::vector<float> alone = shownAmbient(scene);
    state.show.shadows = Shadows::kBoth;
    chooseNext(kCastModeMenu, state, scene, 1);
    EXPECT_EQ(state.show.cast_mode, CastMode::kFolded);
    EXPECT_EQ(shownCastMode(state), CastMode::kFolded);
    update(scene, state);
    const std::vector<float> folded = shownAmbient(scene);
    EXPECT_GT(largestDifference(product, alone), 0.1);
    EXPECT_GT(largestDifference(folded, alone), 0.1);
    EXPECT_GT(largestDifference(folded, product), 1e-4) << "another way";
    EXPECT_LT(largestDifference(folded, product), largestDifference(folded, alone)) << "of the same shadow";
    EXPECT_LT(largestDifference(folded, renderedAmbient(PosedScene(readScene(file(kPair)), {CastMode::kFolded, {}}))),
              1e-5);
    // Whoever moves away is out of it.
    state.characters[0].moved = {-900, 0, 0};
    update(scene, state);
    EXPECT_LT(largestDifference(shownAmbient(scene), alone), 0.01);
    state.characters[0].moved = {};
    state.show.shadows = Shadows::kSelf;
    EXPECT_EQ(shownCastMode(state), CastMode::kProduct) << "no shadow joins";
    state.show.shadows = Shadows::kBoth;
    chooseNext(kCastModeMenu, state, scene, 1);
    EXPECT_EQ(state.show.cast_mode, CastMode::kProduct);
    update(scene, state);
    EXPECT_EQ(shownAmbient(scene), product);
    chooseNext(kCastModeMenu, state, scene, -1);
    EXPECT_EQ(state.show.cast_mode, CastMode::kFolded);
}

// A character that casts nothing still receives: if it is moved, others cast on it anew.
TEST_F(ViewCast, ReceiversThatCastNothingMoveToo) {
    Scene scene = open(R"({"asset": "tube.pnb", "casts": "nothing"}, {"asset": "tube.pnb", "position": [0.6, 0, 0]})");
    ViewState state = stateOf(scene);
    update(scene, state);
    const std::vector<float>& coefficients = scene.characters[0]->posed.vertices.coefficients;
    const std::vector<float> near = coefficients;
    state.characters[0].moved = {-900, 0, 0};
    update(scene, state);
    EXPECT_GT(largestDifference(near, coefficients), 0.3);
}

// Two files that both have a material of one name show their own.
TEST_F(ViewCast, MaterialsAreThoseOfTheirOwnFile) {
    BrdfFile red = synthetic::lambert({0.9, 0.1, 0.1});
    const std::array materials = {red};
    const std::array lights = {synthetic::light(4, 0.1)};
    writeWholeFile(folder / "red.pnb", packAsset(synthetic::composedTube(kTube), materials, lights,
                                                 {.precision = AssetPrecision::kF32}, "{}", 1)
                                           .bytes);
    const std::string name = red.name;
    const Scene scene = open(R"({"asset": "tube.pnb", "material": ")" + name +
                             R"("}, {"asset": "red.pnb", "material": ")" + name + R"("})");
    const ViewState state = stateOf(scene);
    EXPECT_EQ(state.characters[0].material_of_slot, std::vector<std::size_t>{0});
    EXPECT_EQ(state.characters[1].material_of_slot, std::vector<std::size_t>{1});
}

// Somebody who is moved away hides nothing any more, and comes back to the very picture.
TEST_F(ViewCast, MovesWithThePointer) {
    Scene scene = open(kPair, R"(, "ground": {"size": 6, "resolution": 33})");
    ViewState state = stateOf(scene);
    update(scene, state);
    const std::vector<float>& coefficients = scene.characters[0]->posed.vertices.coefficients;
    const std::vector<float> near = coefficients;
    const std::vector<Vec3> shadow = *scene.ground.values;
    state.characters[1].moved = {900, 0, 0};
    update(scene, state);
    EXPECT_GT(largestDifference(near, coefficients), 0.3);
    state.characters[1].moved = {};
    update(scene, state);
    EXPECT_EQ(coefficients, near);
    EXPECT_EQ(*scene.ground.values, shadow);
}

// The window and a picture show the same: numbers past the field, and a ground that moves with who stands on it.
TEST_F(ViewCast, AGroundWithHeightsMovesAndShadowsAsInPictures) {
    writeWholeFile(
        folder / "s.json",
        std::string(R"({"version": 1, "characters": [{"asset": "tube.pnb", "on_ground": true}], "ground": )") +
            R"({"heights": {"analytic": "waves:height=0.4,length=2", "rows": 40, "columns": 33, "cell": 0.1}}})");
    const std::array files = {folder / "s.json"};
    Scene scene = openScene(files, 1);
    ViewState state = stateOf(scene);
    state.smooth = false;
    update(scene, state);
    PosedScene posed(readScene(files[0]));
    EXPECT_EQ(scene.characters[0]->posed.to_scene, posed.members()[0]->to_scene);
    EXPECT_LT(
        largestDifference(scene.characters[0]->posed.vertices.coefficients, memberVertices(posed, 0, 1).coefficients),
        1e-5);
    FrameVertices points;
    posed.field()->evaluate(1, points);
    posed.field()->castOn(posed.cast(), 1, points);
    EXPECT_LT(largestDifference(scene.ground.points.coefficients, points.coefficients), 1e-5);
    EXPECT_EQ(scene.ground.values->size(), 40u * 33u);
    const std::vector<Vec3> before = *scene.ground.values;
    state.playhead.time = 0.7;
    update(scene, state);
    EXPECT_NE(*scene.ground.values, before);
    const Character& tube = *scene.characters[0];
    EXPECT_FLOAT_EQ(tube.posed.to_scene.m[7],
                    float(scene.field->heights().heightUnder(tube.posed.vertices.positions, tube.posed.to_scene)));
    state.characters[0].moved = {0.3f, 0.1f, -0.2f};  // by the user: the ground of the new place
    update(scene, state);
    EXPECT_FLOAT_EQ(tube.posed.to_scene.m[3], 0.3f);
    EXPECT_FLOAT_EQ(
        tube.posed.to_scene.m[7],
        float(scene.field->heights().heightUnder(tube.posed.vertices.positions, tube.posed.to_scene)) + 0.1f);
}

TEST_F(ViewCast, TheGroundIsDarkUnderThem) {
    Scene scene = open(kPair, R"(, "ground": {"size": 8, "resolution": 65})");
    ViewState state = stateOf(scene);
    ASSERT_TRUE(state.show.ground);
    update(scene, state);
    const auto at = [&](float x, float z) {
        const std::vector<Vec3>& positions = scene.ground.vertices.positions;
        const auto nearest = std::ranges::min_element(positions, {}, [&](Vec3 p) { return length(p - Vec3{x, 0, z}); });
        return (*scene.ground.values)[std::size_t(nearest - positions.begin())].y;
    };
    EXPECT_LT(at(0.3f, 0), 0.7f * at(3.9f, 3.9f));
    const float dark = at(0.3f, 0);
    state.show.shadows = Shadows::kSelf;
    update(scene, state);
    EXPECT_GT(at(0.3f, 0), 1.3f * dark);
    EXPECT_FALSE(stateOf(scene = open(kPair)).show.ground);
}

// A prop stays, and a character that starts later in its clip is shown in the frame that is nearest.
TEST_F(ViewCast, EveryoneHasTheirOwnTime) {
    Scene scene = open(R"({"asset": "tube.pnb"}, {"asset": "tube.pnb", "time": 0.34})",
                       R"(, "props": [{"asset": "tube.pnb", "position": [4, 0, 0]}])");
    ViewState state = stateOf(scene);
    update(scene, state);
    EXPECT_EQ(scene.characters[0]->posed.pose().frame, 0u);
    EXPECT_EQ(scene.characters[1]->posed.pose().frame, 1u);
    state.playhead.time = 0.2;
    update(scene, state);
    EXPECT_GT(scene.characters[0]->posed.pose().part, 0.5);
    EXPECT_EQ(scene.characters[2]->posed.pose().frame, 0u);
    EXPECT_EQ(scene.characters[2]->posed.pose().part, 0);
    state.selected = 1;
    const std::span<const double> times = scene.characters[1]->asset.animation.times;
    EXPECT_NEAR(clipTime(state), 0.2 + times[1] - times[0], 1e-12);
    showClipTime(state, times[1] - times[0]);
    EXPECT_NEAR(state.playhead.time, 0, 1e-12);
}

// Past the end of a clip everyone is in its last frame at first, as in render.
TEST_F(ViewCast, PastTheEndIsTheLastFrame) {
    Scene scene = open(R"({"asset": "tube.pnb", "time": 1000})");
    const ViewState state = stateOf(scene);
    update(scene, state);
    const Character& character = *scene.characters[0];
    EXPECT_EQ(character.posed.pose().frame + 1, character.asset.animation.clips[0].frame_count);
    EXPECT_EQ(character.posed.pose().part, 0);
}

TEST_F(ViewCast, APoseOfAFileIsShownUntilAClipIsChosen) {
    Scene scene = open(R"({"asset": "tube.pnb"}, {"asset": "tube.pnb", "time": 0.34})");
    ViewState state = stateOf(scene);
    update(scene, state);
    const std::span<const Affine> bones = scene.characters[1]->posed.evaluator->bones();
    const BonePose pose{"", 0, {bones.begin(), bones.end()}, std::vector<float>(3 * bones.size())};
    scene.characters[0]->file_pose = &pose;
    state.characters[0].still = true;
    state.playhead.time = 0.2;
    update(scene, state);
    EXPECT_TRUE(std::ranges::equal(scene.characters[0]->posed.evaluator->bones(), pose.bones));
    chooseClip(state, 0);
    update(scene, state);
    EXPECT_FALSE(std::ranges::equal(scene.characters[0]->posed.evaluator->bones(), pose.bones));
}

TEST_F(ViewCast, RefusesWhatIsNoScene) {
    const std::array twice = {file(kPair), file(kPair)};
    EXPECT_THROW(openScene(twice, 1), InvalidInput);
    EXPECT_THROW(open(R"({"asset": "nobody.pnb"})"), IoError);
}

TEST_F(ViewCast, ThePointerMeetsTheGround) {
    ViewState state;
    state.window.panels = false;
    state.camera.pitch = 0.5;
    state.camera.distance = 4;
    const Rectangle picture{0, 0, 400, 300};
    const auto middle = pointAtHeight(state, 0, picture, 200, 150);
    ASSERT_TRUE(middle);
    EXPECT_NEAR(length(*middle - state.camera.target), 0, 1e-9);
    state.camera.pitch = 0.1;
    EXPECT_FALSE(pointAtHeight(state, 0, picture, 200, 5)) << "above the horizon";
}

}  // namespace
}  // namespace penumbra::test_view_cast
