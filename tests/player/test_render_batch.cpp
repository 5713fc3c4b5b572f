// Tests many frames in one run: the pictures equal those of frames alone, one context makes them, and nothing is
// compiled after the first.
#include <gtest/gtest.h>

#include "formats/common/errors.h"
#include "formats/image/exposure.h"
#include "player/draw/picture_view.h"
#include "player/render/render_batch.h"
#include "player/render/render_sheet.h"
#include "tests/runtime/synthetic_asset.h"

namespace penumbra::test_render_batch {
namespace {

using player_test::SyntheticAsset;

RenderOptions smallPicture(EvaluationPath path) {
    RenderOptions options;
    options.width = options.height = 64;
    options.path = path;
    options.camera = "distance=3.4";
    return options;
}

BatchPlan planOf(const SyntheticAsset& data, const RenderOptions& options) {
    BatchPlan plan;
    plan.options = options;
    plan.look = resolveLook(options, data.asset, &data.truth);
    plan.chosen = chooseFrames(data.asset, {.sequence = true});
    plan.files.resize(plan.chosen.frames.size());  // no name: the sink writes nothing
    const SheetOptions sheet{.panels = {SheetPanel::kModel, SheetPanel::kTruth, SheetPanel::kError}};
    plan.panels = picturesOf(sheet, options.channel);
    plan.image_error = true;
    findTruth(plan);
    return plan;
}

// Counts what is compiled from now on.
int compiled = 0;
PFNGLCREATEPROGRAMPROC create_program = nullptr;
PFNGLCOMPILESHADERPROC compile_shader = nullptr;

void countCompilations() {
    compiled = 0;
    create_program = gl::CreateProgram;
    compile_shader = gl::CompileShader;
    gl::CreateProgram = [] { return ++compiled, create_program(); };
    gl::CompileShader = [](GLuint shader) { ++compiled, compile_shader(shader); };
}

void stopCounting() {
    gl::CreateProgram = create_program;
    gl::CompileShader = compile_shader;
}

TEST(RenderBatch, DrawsWhatAFrameAloneShowsAndCompilesForTheFirstOnly) {
    const SyntheticAsset data;
    for (const EvaluationPath path : {EvaluationPath::kCpu, EvaluationPath::kGlsl}) {
        const BatchPlan plan = planOf(data, smallPicture(path));
        std::vector<Image> pictures;
        std::vector<std::vector<Image>> panels;
        const BatchSink sink{[&](std::size_t, const Image& picture) { pictures.push_back(picture); },
                             [&](std::size_t, std::vector<Image> shown) { panels.push_back(std::move(shown)); },
                             [&](std::size_t done) {
                                 if (done == 1) countCompilations();
                             }};
        const BatchResult result = runBatch(plan, 2, sink);
        stopCounting();
        EXPECT_EQ(compiled, 0);
        ASSERT_EQ(pictures.size(), 4u);
        for (std::size_t i = 0; i < pictures.size(); ++i) {
            RenderOptions alone = plan.options;
            alone.clip = data.asset.animation.clips[plan.chosen.frames[i].clip].name;
            alone.frame = int(plan.chosen.frames[i].number);
            EXPECT_EQ(pictures[i].pixels, renderOffscreen(alone, data.asset, &data.truth, 1).image.pixels) << i;
            EXPECT_EQ(panels[i][0].pixels, pictures[i].pixels) << i;
            alone.source = VisibilitySource::kTruth;
            EXPECT_EQ(panels[i][1].pixels, renderOffscreen(alone, data.asset, &data.truth, 1).image.pixels) << i;
            alone.source = VisibilitySource::kModel;
            alone.channel = Channel::kError;
            EXPECT_EQ(panels[i][2].pixels, renderOffscreen(alone, data.asset, &data.truth, 1).image.pixels) << i;
            EXPECT_GT(result.frames[i].image->rmse(), 1) << "the model is darker than the truth";
        }
    }
}

// With the whole sequence's camera a point that does not move stays on its pixel, and all of the mesh is in the
// picture.
TEST(RenderBatch, OneCameraHoldsEveryFrame) {
    const SyntheticAsset data;
    RenderOptions options = smallPicture(EvaluationPath::kCpu);
    options.camera = "";
    BatchPlan plan = planOf(data, options);
    plan.framing = Framing::kClips;
    const auto nothing = [](std::size_t, const auto&) {};
    const BatchSink sink{[&](std::size_t i, const Image& picture) {
                             for (int k = 0; k < 64; ++k)
                                 for (const int edge : {k, 63 * 64 + k, 64 * k, 64 * k + 63})
                                     EXPECT_EQ(picture.alpha[std::size_t(edge)], 0) << i << " " << edge;
                         },
                         nothing, [](std::size_t) {}};
    runBatch(plan, 1, sink);

    PosedFrame frame(plan.look, 1);
    const std::size_t one[] = {0}, all[] = {0, 1};
    const BoundingBox swing = boundsOfClips(frame, one), both = boundsOfClips(frame, all);
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_LE(both.low[axis], swing.low[axis]);
        EXPECT_GE(both.high[axis], swing.high[axis]);
    }
    for (std::size_t f = 0; f < data.asset.animation.frameCount(); ++f) {
        frame.pose(f, std::nullopt);
        for (const Vec3& p : frame.positions())
            for (int axis = 0; axis < 3; ++axis) {
                EXPECT_GE(p[axis], both.low[axis]);
                EXPECT_LE(p[axis], both.high[axis]);
            }
    }
}

// The truth's picture of the clips' first frame decides, and the model's where the truth lacks that frame. Neither
// depends on which frames are drawn.
TEST(RenderBatch, OneExposureForAllFramesAndSlices) {
    SyntheticAsset data;
    const auto nothing = [](std::size_t, const auto&) {};
    std::vector<float> told;
    const BatchSink sink{nothing, nothing, [](std::size_t) {}, [&](float exposure) { told.push_back(exposure); }};
    RenderOptions options = smallPicture(EvaluationPath::kCpu);
    const auto exposureOf = [&](const BatchPlan& plan) { return runBatch(plan, 1, sink).exposure; };
    const auto alone = [&](VisibilitySource source) {
        RenderOptions first = options;
        first.clip = data.asset.animation.clips[0].name;
        first.source = source;
        return automaticExposure(renderOffscreen(first, data.asset, &data.truth, 1).image);
    };
    BatchPlan plan = planOf(data, options);
    const float truth = exposureOf(plan), model = alone(VisibilitySource::kModel);
    EXPECT_EQ(truth, alone(VisibilitySource::kTruth));
    EXPECT_LT(truth, model) << "the model is darker than the truth";
    plan.chosen = chooseFrames(data.asset, {.frames = FrameRange{2, 4, 1}, .sequence = true});
    plan.truth_frames.clear();
    findTruth(plan);
    EXPECT_EQ(exposureOf(plan), truth);
    plan.options.exposure = 3;
    EXPECT_EQ(exposureOf(plan), 3);
    EXPECT_EQ(told, (std::vector<float>{truth, truth, 3}));
    data.truth.animation.clips[0].name = "another";
    EXPECT_EQ(exposureOf(planOf(data, options)), model);
    options.channel = Channel::kAmbient;
    EXPECT_EQ(exposureOf(planOf(data, options)), 1);
}

TEST(RenderBatch, AFrameWithoutTruthHasNeitherErrorsNorPanelsOfIt) {
    SyntheticAsset data;
    data.truth.animation.clips[1].name = "another";
    BatchPlan plan = planOf(data, smallPicture(EvaluationPath::kCpu));
    std::vector<std::vector<Image>> panels;
    const BatchSink sink{[](std::size_t, const Image&) {},
                         [&](std::size_t, std::vector<Image> shown) { panels.push_back(std::move(shown)); },
                         [](std::size_t) {}};
    const BatchResult result = runBatch(plan, 1, sink);
    EXPECT_TRUE(result.frames[2].errors && result.frames[2].image);
    EXPECT_FALSE(result.frames[3].errors || result.frames[3].image);
    EXPECT_EQ(panels[3][0].width, 64);
    EXPECT_EQ(panels[3][1].width, 0);
    EXPECT_EQ(panels[3][2].width, 0);
    plan.options.channel = Channel::kError;
    plan.truth_frames.clear();
    EXPECT_THROW(findTruth(plan), InvalidInput);
}

}  // namespace
}  // namespace penumbra::test_render_batch
