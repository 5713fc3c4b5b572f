// The brush of the window, and its ground with heights by both paths.
#include <gtest/gtest.h>
#include <unistd.h>

#include "formats/common/write_file.h"
#include "pack/pack_asset.h"
#include "player/gl/gl_context.h"
#include "player/view/view_actions.h"
#include "player/view/view_painter.h"
#include "player/view/view_pick.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_view_brush {
namespace {

namespace fs = std::filesystem;

const synthetic::TubeOptions kTube{
    .rings = 20, .segments = 9, .joints = 6, .clusters = 4, .components = 5, .inputs = 4};

class ViewBrush : public testing::Test {
protected:
    fs::path folder = fs::path(testing::TempDir()) / ("view_brush_" + std::to_string(getpid()));
    UpdateCost cost;

    void SetUp() override {
        fs::create_directories(folder);
        const std::array materials = {synthetic::lambert({0.5, 0.5, 0.5})};
        const std::array lights = {synthetic::light(4, 0.3)};
        writeWholeFile(folder / "tube.pnb", packAsset(synthetic::composedTube(kTube), materials, lights,
                                                      {.precision = AssetPrecision::kF32}, "{}", 1)
                                                .bytes);
    }
    void TearDown() override { fs::remove_all(folder); }

    Scene open(const std::string& heights) const {
        writeWholeFile(folder / "s.json",
                       std::string(R"({"version": 1, "characters": [{"asset": "tube.pnb", "position": [3, 0, 3]}],
                          "ground": {"height": -0.5, "heights": {)") +
                           heights + "}}}");
        const std::array files = {folder / "s.json"};
        return openScene(files, 1);
    }
    static ViewState stateOf(const Scene& scene) {
        ViewState state = stateFor(scene, {});
        applySceneFile(scene, state);
        state.camera.pitch = 0.6;
        state.camera.distance = 8;
        return state;
    }
};

const char* const kDunes = R"("analytic": "dunes:height=0.6,length=3", "rows": 96, "columns": 128, "cell": 0.1)";

TEST_F(ViewBrush, FindsWhereARayMeetsTheField) {
    const Scene level = open(R"("analytic": "waves:height=0", "rows": 11, "columns": 21, "cell": 0.1)");
    const GroundHeights& heights = level.field->heights();
    const auto at = pointOnField(heights, {0.5, 1.5, -0.2}, {-1, -5, 1});  // 2 m above
    ASSERT_TRUE(at);
    EXPECT_NEAR(length(*at - Vec3d{0.1, -0.5, 0.2}), 0, 1e-5);
    EXPECT_TRUE(pointOnField(heights, {0.3, 3, 0.1}, {0, -1, 0}));
    EXPECT_FALSE(pointOnField(heights, {0.3, 3, 0.1}, {0, 1, 0}));   // upwards
    EXPECT_FALSE(pointOnField(heights, {0.3, -2, 0.1}, {0, 1, 0}));  // from below
    EXPECT_FALSE(pointOnField(heights, {1.7, 3, 0.1}, {0, -1, 0}));  // beside it
    EXPECT_FALSE(pointOnField(heights, {0, 3, 0}, {1, 0, 0}));       // over it
    const Scene hills = open(kDunes);
    for (const double x : {-5.0, -1.0, 2.5, 5.5}) {
        const auto on = pointOnField(hills.field->heights(), {x, 2, -4}, {0.1, -0.6, 1});
        ASSERT_TRUE(on);
        EXPECT_NEAR(on->y, hills.field->heights().heightAt(on->x, on->z), 1e-4);
    }
}

TEST_F(ViewBrush, RaisesAndLowersUnderThePointerAndOnlyWhatSeesItIsComputed) {
    Scene scene = open(kDunes);
    ViewState state = stateOf(scene);
    applyKey(state, scene, {'0', false});
    EXPECT_TRUE(state.tool.brush.on);
    applyKey(state, scene, {',', false});
    EXPECT_DOUBLE_EQ(state.tool.brush.radius, 0.4);
    applyKey(state, scene, {'.', true});
    EXPECT_DOUBLE_EQ(state.tool.brush.strength, 0.625);
    updateScene(scene, state, {.threads = 1}, cost);
    EXPECT_EQ(scene.ground.updated, 96u * 128u);
    const Rectangle picture{0, 0, 200, 100};
    const auto stroke = strokeUnder(scene, state, picture, 90, 60, 0.05);
    ASSERT_TRUE(stroke);
    EXPECT_FLOAT_EQ(stroke->rise, 0.03125f);
    EXPECT_FLOAT_EQ(strokeUnder(scene, state, picture, 90, 60, -7)->rise, -0.0625f);  // a slow frame
    EXPECT_FALSE(strokeUnder(scene, state, picture, 90, -500, 0.05));
    const float before = scene.field->heights().heightAt(stroke->at.x, stroke->at.z);
    const std::vector<Vec3> values = *scene.ground.values;
    scene.field->brush(stroke->at, stroke->radius, 0.3f);
    updateScene(scene, state, {.threads = 1}, cost);
    EXPECT_NEAR(scene.field->heights().heightAt(stroke->at.x, stroke->at.z), before + 0.3f, 0.03f);
    EXPECT_LT(scene.ground.updated, 96u * 128u / 2);
    EXPECT_GT(scene.ground.updated, 50u);
    EXPECT_NE(*scene.ground.values, values);
    // A camera that moves computes no point anew.
    const std::optional<GroundKey> key = scene.ground.values.key();
    state.camera.yaw += 0.2;
    updateScene(scene, state, {.threads = 1}, cost);
    EXPECT_EQ(scene.ground.values.key(), key);
}

// The automatic exposure is measured on what is drawn of characters and ground.
TEST_F(ViewBrush, BothPathsDrawTheSameGround) {
    const std::unique_ptr<GlContext> context = createGlContext(GlBackend::kAuto);
    const Rectangle picture{0, 0, 200, 100};
    Scene of_cpu = open(kDunes), of_gpu = open(kDunes);
    ViewState state = stateOf(of_cpu);
    ScenePainter cpu(of_cpu, EvaluationPath::kCpu), gpu(of_gpu, EvaluationPath::kGlsl);
    const auto exposure = [&](Scene& scene, ScenePainter& painter) {
        updateScene(scene, state, painter.needs(state, 1), cost);
        return double(painter.measureExposure(state, picture));
    };
    EXPECT_FALSE(gpu.needs(state, 1).field);
    EXPECT_TRUE(cpu.needs(state, 1).field);
    const double first = exposure(of_cpu, cpu);
    EXPECT_NEAR(exposure(of_gpu, gpu), first, 1e-4 * first);
    state.tool.brush.radius = 2;
    const auto stroke = strokeUnder(of_cpu, state, picture, 100, 60, 0.05);
    ASSERT_TRUE(stroke);
    for (const Scene* scene : {&of_cpu, &of_gpu}) scene->field->brush(stroke->at, 2, 1.5f);
    state.lighting.yaw = 50;
    const double edited = exposure(of_cpu, cpu);
    EXPECT_GT(std::abs(edited - first), 0.01 * first);
    EXPECT_NEAR(exposure(of_gpu, gpu), edited, 1e-4 * edited);
    EXPECT_TRUE(of_gpu.ground.points.coefficients.empty()) << "the CPU has computed them";
    // Only some of the shadows: the CPU computes, and so it does beside the truth.
    state.show.shadows = Shadows::kCast;
    EXPECT_TRUE(gpu.needs(state, 1).field);
    const double some = exposure(of_cpu, cpu);
    EXPECT_NEAR(exposure(of_gpu, gpu), some, 1e-4 * some);
}

}  // namespace
}  // namespace penumbra::test_view_brush
