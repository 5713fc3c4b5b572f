// Composed assets on the GPU: the far parts by far.glsl against the evaluator, and the tables that it reads.
#include <gtest/gtest.h>

#include <bit>
#include <set>

#include "pack/pack_asset.h"
#include "player/draw/model_painter.h"
#include "player/draw/picture_view.h"
#include "player/frame/frame_values.h"
#include "player/gl/offscreen_target.h"
#include "runtime/glsl/far_glsl.h"
#include "tests/difference.h"
#include "tests/player/gl_calls.h"
#include "tests/runtime/count_allocations.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_composed_gpu {
namespace {

using player_test::GlCalls;

constexpr int kSize = 96;  // pixels

// The parts at the ends of this one have anchors.
const synthetic::TubeOptions kTube{
    .rings = 120, .segments = 16, .joints = 6, .clusters = 4, .components = 5, .inputs = 4};

struct Tube {
    Packed packed;
    AssetView asset;
    Evaluator evaluator;

    explicit Tube(const Model& model, AssetPrecision precision = AssetPrecision::kI8)
        : packed(packAsset(model, std::vector<BrdfFile>{synthetic::lambert()},
                           std::vector<LightFile>{synthetic::light(4, 0.3)}, {.precision = precision}, "{}", 1)),
          asset(openAsset(packed.bytes)),
          evaluator(asset) {}
};

// Draws a frame of several characters, by both paths. Some characters have their numbers given.
class Pictures {
public:
    Pictures(const Tube& tube, std::size_t count)
        : tube_(tube), context_(createGlContext(GlBackend::kAuto)), target_(kSize, kSize, 1) {
        gl_asset = std::make_shared<GlAsset>(tube.asset, nullptr, &tube.evaluator);
        for (std::size_t i = 0; i < count; ++i) evaluators.push_back(tube.evaluator);
        vertices_.resize(count);
    }
    std::vector<Evaluator> evaluators;
    std::shared_ptr<GlAsset> gl_asset;
    FrameView view;

    // Returns the RMSE of E and the largest difference, in 8-bit steps, of a frame of the animation.
    std::array<double, 2> difference(std::size_t frame, std::size_t given) {
        pose(frame);
        const Image gpu = onGpu(given), cpu = onCpu(given);
        Largest largest;
        double sum = 0, covered = 0;
        for (std::size_t p = 0; p < cpu.pixels.size(); ++p) {
            const double d = 255 * std::abs(double(gpu.pixels[p].x) - cpu.pixels[p].x);
            sum += d * d;
            largest.add(d);
            covered += cpu.alpha[p] > 0;
        }
        EXPECT_GT(covered, kSize * kSize / 20.0);
        return {std::sqrt(sum / covered), largest};
    }
    std::vector<PosedCharacter> characters(std::size_t given) const {
        std::vector<PosedCharacter> posed;
        for (std::size_t i = 0; i < evaluators.size(); ++i) {
            posed.push_back({&evaluators[i], placedAt(offset(i))});
            if (i >= given) posed.back().coefficients = vertices_[i].coefficients;
        }
        return posed;
    }
    void pose(std::size_t frame) {
        const std::size_t frames = tube_.asset.animation.frameCount();
        for (std::size_t i = 0; i < evaluators.size(); ++i) {
            evaluators[i].setFrame((frame + i) % frames);
            skinFrame(evaluators[i], 1, vertices_[i]);
            evaluateCoefficients(evaluators[i], 1, vertices_[i]);
        }
        RenderOptions options;
        options.width = options.height = kSize;
        view = makePictureView(options, tube_.asset, vertices_[0].positions);
    }

private:
    const Tube& tube_;
    std::unique_ptr<GlContext> context_;
    OffscreenTarget target_;
    std::vector<FrameVertices> vertices_;

    static Vec3 offset(std::size_t i) { return {0.5f * float(i), 0, 0}; }
    Image onGpu(std::size_t given) {
        ModelPainter painter(gl_asset, evaluators.size());
        painter.evaluate(Channel::kAmbient, characters(given), view.eye);
        target_.begin();
        painter.draw(view);
        return target_.read();
    }
    Image onCpu(std::size_t) {
        Shot shot;
        shot.asset = &tube_.asset;
        target_.begin();
        ValuePainter painter(tube_.asset.mesh.triangles, Channel::kAmbient);
        for (std::size_t i = 0; i < evaluators.size(); ++i) {
            const std::vector<Vec3> values =
                channelValues(shot, Channel::kAmbient, nullptr, vertices_[i], {}, view.eye, 1);
            std::vector<Vec3> positions = vertices_[i].positions;
            for (Vec3& p : positions) p += offset(i);
            painter.draw(view, positions, values);
        }
        return target_.read();
    }
};

// The bound is the project's, 0.5 of a step. Measured on llvmpipe: RMSE 2e-3 at most, the target's half floats.
TEST(ComposedGpu, FarPartsAreThoseOfTheCpu) {
    // Each program takes seconds to compile.
    for (const auto& [residual, precision] : {std::pair(true, AssetPrecision::kI8), {false, AssetPrecision::kF16}}) {
        const Tube tube(synthetic::composedTube(kTube, {.residual = residual}), precision);
        Pictures pictures(tube, 1);
        EXPECT_GT(pictures.gl_asset->anchorCount(), 0u);
        EXPECT_FALSE(pictures.gl_asset->needsCoefficients());
        for (std::size_t frame = 0; frame < tube.asset.animation.frameCount(); ++frame) {
            const auto [rmse, largest] = pictures.difference(frame, 1);
            std::printf("frame %zu: RMSE %.1e, largest %.1e of a step\n", frame, rmse, largest);
            EXPECT_LT(rmse, 0.05);
            EXPECT_LT(largest, 0.5);
        }
    }
}

// Vertices with anchors multiply near parts in besides, each by a gain of its own.
TEST(ComposedGpu, NearPartsAreThoseOfTheCpu) {
    Model model = synthetic::composedTube(kTube, {.residual = false});
    synthetic::addNearParts(model, 3);
    const Tube tube(model);
    Pictures pictures(tube, 1);
    EXPECT_GT(pictures.gl_asset->anchorCount(), 0u);
    for (const std::size_t frame : {0, 3}) {
        const auto [rmse, largest] = pictures.difference(frame, 1);
        std::printf("frame %zu: RMSE %.1e, largest %.1e of a step\n", frame, rmse, largest);
        EXPECT_LT(rmse, 0.05);
        EXPECT_LT(largest, 0.5);
    }
}

// Without anchors every part is multiplied in one by one.
TEST(ComposedGpu, PartsWithoutAnchorsAreThoseOfTheCpu) {
    const synthetic::TubeOptions few{
        .rings = 20, .segments = 9, .joints = 6, .clusters = 4, .components = 5, .inputs = 4};
    const Tube tube(synthetic::composedTube(few));
    Pictures pictures(tube, 1);
    EXPECT_EQ(pictures.gl_asset->anchorCount(), 0u);
    EXPECT_LT(pictures.difference(3, 1)[1], 0.5);
}

// Each has a pose and anchors of its own. The last one's numbers are given.
TEST(ComposedGpu, CharactersOfOneAssetKeepApart) {
    const Tube tube(synthetic::composedTube(kTube));
    Pictures pictures(tube, 3);
    for (const std::size_t given : {3, 2, 0}) EXPECT_LT(pictures.difference(1, given)[1], 0.5) << given;
}

TEST(ComposedGpu, NumbersAreGivenWhereTheModelHasMoreBandsThanTheFields) {
    synthetic::TubeOptions many = kTube;
    many.rings = 20;
    many.convention.order = kFieldOrder + 1;
    const Tube tube(synthetic::composedTube(many));
    Pictures pictures(tube, 1);
    EXPECT_TRUE(pictures.gl_asset->needsCoefficients());
    EXPECT_LT(pictures.difference(2, 0)[1], 0.5);
    const GlAsset without(tube.asset, nullptr);
    EXPECT_TRUE(without.needsCoefficients()) << "nobody made the tables";
}

TEST(ComposedGpu, NothingIsAllocatedInFrames) {
    const Tube tube(synthetic::composedTube(kTube));
    Pictures pictures(tube, 2);
    pictures.pose(0);
    const std::vector<PosedCharacter> characters = pictures.characters(2);
    ModelPainter painter(pictures.gl_asset, 2);
    const auto frames = [&](std::size_t count) {
        for (std::size_t f = 0; f < count; ++f) {
            for (Evaluator& evaluator : pictures.evaluators) evaluator.setFrame(f % tube.asset.animation.frameCount());
            painter.evaluate(Channel::kAmbient, characters, pictures.view.eye);
        }
        gl::Finish();
    };
    frames(8);
    const GlCalls calls;
    const std::size_t before = allocationCount();
    frames(20);
    EXPECT_EQ(allocationCount(), before);
    EXPECT_EQ(calls.made(), 0);
}

TEST(FarWords, PosedPartsAreRotationsAndMaps) {
    Tube tube(synthetic::composedTube(kTube));
    tube.evaluator.setFrame(tube.asset.animation.frameCount() - 1);
    const std::span<const PosedPart> posed = tube.evaluator.posedParts();
    for (std::size_t p = 0; p < posed.size(); ++p) {
        std::array<float, 4 * kPosedPartRows> rows;
        writePosedPart(posed[p], {}, 0, rows.data());
        const Mat3 turn =
            nearestRotation(tube.evaluator.bones()[tube.asset.model.composition->parts[p].field.joint].linear());
        for (std::size_t i = 0; i < 12; ++i) EXPECT_EQ(rows[i], posed[p].to_part.m[i]);
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) EXPECT_NEAR(rows[12 + 4 * i + j], turn.m[3 * i + j], 1e-6) << p;
        EXPECT_EQ(rows[27], posed[p].radius);
    }
}

TEST(FarWords, EveryVertexFindsAnchorsOfItsPart) {
    const Tube tube(synthetic::composedTube(kTube));
    const FarTables& tables = tube.evaluator.farTables();
    const FarWords words = makeFarWords(tables, tube.evaluator.farLayout());
    const std::span<const std::uint16_t> part_of = tube.asset.model.composition->part_of_vertex;
    EXPECT_EQ(words.parts.size(), tables.partCount() * kFarPartWords);
    EXPECT_EQ(words.lists[tables.partCount()] + tables.partCount() + 1, words.lists.size());
    std::map<std::uint32_t, std::uint32_t> anchor_at;  // place: vertex
    for (std::size_t a = 0; a < words.anchors.size(); a += 2) {
        EXPECT_TRUE(anchor_at.emplace(words.anchors[a + 1], words.anchors[a]).second) << "a place of its own";
        EXPECT_LT(words.anchors[a + 1] + kFarAnchorSums, words.anchor_values);
    }
    std::size_t with_anchors = 0;
    for (std::size_t v = 0; v < part_of.size(); ++v) {
        const std::uint32_t* const row = words.receivers.data() + 8 * v;
        if (row[0] == kNoAnchor) continue;
        ++with_anchors;
        float sum = 0;
        for (std::size_t a = 0; a < 4; ++a) {
            EXPECT_EQ(part_of[anchor_at.at(row[a])], part_of[v]);
            sum += std::bit_cast<float>(row[4 + a]);
        }
        EXPECT_NEAR(sum, 1, 1e-5);
    }
    EXPECT_GT(with_anchors, part_of.size() / 8);
    EXPECT_LT(anchor_at.size(), part_of.size() / 3);
}

}  // namespace
}  // namespace penumbra::test_composed_gpu
