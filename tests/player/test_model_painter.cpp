// Tests characters of one asset on the GPU. Many in one draw equal as many draws of one; what they share is there
// once; a frame allocates nothing.
#include <gtest/gtest.h>

#include <deque>

#include "formats/common/errors.h"
#include "player/draw/model_painter.h"
#include "player/draw/picture_view.h"
#include "player/frame/frame_values.h"
#include "player/gl/offscreen_target.h"
#include "player/gl/upload_ring.h"
#include "tests/difference.h"
#include "tests/player/gl_calls.h"
#include "tests/runtime/count_allocations.h"
#include "tests/runtime/synthetic_asset.h"

namespace penumbra::test_model_painter {
namespace {

using player_test::AssetRecipe;
using player_test::GlCalls;
using player_test::SyntheticAsset;

constexpr int kSize = 96;  // pixels

Mat3 aboutY(float angle) {
    const float c = std::cos(angle), s = std::sin(angle);
    return {{c, 0, s, 0, 1, 0, -s, 0, c}};
}

// Characters side by side and behind one another, each with a pose, materials, a light and its rotation of its own.
// Every third one has given numbers.
struct Crowd {
    const SyntheticAsset data;
    std::unique_ptr<GlContext> context = createGlContext(GlBackend::kAuto);
    OffscreenTarget target{kSize, kSize, 1};
    std::deque<Evaluator> evaluators;
    std::deque<ShadingSet> sets;
    std::deque<std::vector<float>> coefficients, ambients;
    std::deque<FrameVertices> vertices;
    std::vector<PosedCharacter> characters;
    std::shared_ptr<GlAsset> asset;
    FrameView view;

    explicit Crowd(std::size_t count, const AssetRecipe& recipe = {.mixed = true, .rings = 8, .slots = 3})
        : data(recipe) {
        Shot shot;
        shot.asset = &data.asset;
        for (std::size_t i = 0; i < count; ++i) {
            Evaluator& evaluator =
                i == 0 ? evaluators.emplace_back(data.asset) : evaluators.emplace_back(evaluators[0]);
            FrameVertices& at = vertices.emplace_back();
            shot.frame = i % data.asset.animation.frameCount();
            evaluateFrame(shot, VisibilitySource::kModel, evaluator, 1, at);
            ShadingSet& set = sets.emplace_back(data.asset);
            for (std::size_t slot = 0; slot < set.slotCount(); ++slot) set.setMaterial(slot, (i + slot) % 3);
            set.setLight(i % 2);
            set.setLightRotation(aboutY(0.7f * float(i)));
            ambients.push_back(std::vector<float>(at.positions.size(), 0.1f * float(i)));
            const Vec3 offset{0.9f * float(i % 3) - 0.9f, 0.7f * float(i / 3) - 0.5f, -0.6f * float(i % 2)};
            characters.push_back({&evaluator, placedAt(offset), &set, {}, ambients.back()});
            if (i % 3 != 2) continue;
            for (float& n : at.coefficients) n *= 0.5f;
            characters.back().coefficients = at.coefficients;
        }
        asset = std::make_shared<GlAsset>(data.asset, &sets.front());
        RenderOptions options;
        options.width = options.height = kSize;
        options.camera = "distance=6";
        view = makePictureView(options, data.asset, vertices.front().positions);
    }
    Image drawTogether(Channel channel) {
        ModelPainter painter(asset, characters.size());
        painter.evaluate(channel, characters, view.eye);
        target.begin();
        painter.draw(view);
        return target.read();
    }
    // Draws each by a painter and an upload of its own.
    Image drawOneByOne(Channel channel) {
        target.begin();
        for (const PosedCharacter& character : characters) {
            ModelPainter painter(asset, 1);
            painter.evaluate(channel, {&character, 1}, view.eye);
            painter.draw(view);
        }
        return target.read();
    }
    Image drawOnCpu() {
        target.begin();
        ValuePainter painter(data.asset.mesh.triangles, Channel::kShaded);
        for (std::size_t i = 0; i < characters.size(); ++i) {
            std::vector<Vec3> radiance, positions = vertices[i].positions;
            shadeFrame(sets[i], vertices[i], view.eye - characters[i].to_scene.translation(), 1, radiance);
            for (Vec3& p : positions) p = characters[i].to_scene.point(p);
            painter.draw(view, positions, radiance);
        }
        return target.read();
    }
};

TEST(ModelPainter, ManyInOneDrawAreAsManyDraws) {
    Crowd crowd(7);
    Image before;
    for (const Channel channel :
         {Channel::kShaded, Channel::kAmbient, Channel::kError, Channel::kClusters, Channel::kNormals}) {
        const Image together = crowd.drawTogether(channel);
        EXPECT_EQ(together.pixels, crowd.drawOneByOne(channel).pixels) << "channel " << int(channel);
        EXPECT_NE(together.pixels, before.pixels);
        before = together;
    }
}

// Colours reach 1; measured: 1e-5, on llvmpipe.
TEST(ModelPainter, ManyAreWhatTheCpuGives) {
    Crowd crowd(7);
    const Image cpu = crowd.drawOnCpu(), gpu = crowd.drawTogether(Channel::kShaded);
    const auto covered = std::size_t(std::ranges::count_if(cpu.alpha, [](float alpha) { return alpha > 0; }));
    EXPECT_EQ(cpu.alpha, gpu.alpha);
    const double largest = largestDifference(cpu.pixels, gpu.pixels);
    std::printf("largest difference %.1e\n", largest);
    EXPECT_LT(largest, 1e-4);
    EXPECT_GT(covered, std::size_t(kSize * kSize / 4));
}

// Draws fewer than there is room for, in another order, and twice from two sides.
TEST(ModelPainter, DrawsWhatWasEvaluatedLast) {
    Crowd crowd(4);
    ModelPainter painter(crowd.asset, 9);
    painter.evaluate(Channel::kNormals, crowd.characters, crowd.view.eye);
    std::swap(crowd.characters[0], crowd.characters[3]);
    crowd.characters.pop_back();
    painter.evaluate(Channel::kShaded, crowd.characters, crowd.view.eye);
    FrameView other = crowd.view;
    other.clip_from_model[0] *= -1;
    for (const FrameView& view : {crowd.view, other, crowd.view}) {
        crowd.target.begin();
        painter.draw(view);
        const Image image = crowd.target.read();
        crowd.view = view;
        EXPECT_EQ(image.pixels, crowd.drawOneByOne(Channel::kShaded).pixels);
    }
    painter.evaluate(Channel::kShaded, {}, crowd.view.eye);
    crowd.target.begin();
    painter.draw(crowd.view);
    EXPECT_EQ(crowd.target.read().pixels, std::vector<Vec3>(kSize * kSize)) << "no character";
}

// Takes buffer storage away, as in an OpenGL 4.3 without the extension.
class WithoutBufferStorage {
public:
    WithoutBufferStorage() { gl::BufferStorage = nullptr; }
    ~WithoutBufferStorage() { gl::BufferStorage = storage_; }

private:
    PFNGLBUFFERSTORAGEPROC storage_ = gl::BufferStorage;
};

TEST(ModelPainter, Gives43WhatItGivesWithBufferStorage) {
    Crowd crowd(3);
    ASSERT_NE(gl::BufferStorage, nullptr) << crowd.context->description;
    const Image stored = crowd.drawTogether(Channel::kShaded);
    const WithoutBufferStorage without;
    crowd.asset = std::make_shared<GlAsset>(crowd.data.asset, &crowd.sets.front());
    EXPECT_EQ(crowd.drawTogether(Channel::kShaded).pixels, stored.pixels);
}

// Poses, materials and lights change every frame. The first frames compile.
TEST(ModelPainter, NothingIsAllocatedInAThousandFrames) {
    for (const bool storage : {true, false}) {
        Crowd crowd(3, {.precision = AssetPrecision::kI8, .rings = 4, .slots = 3});
        std::optional<WithoutBufferStorage> without;
        if (!storage) without.emplace();
        ModelPainter painter(crowd.asset, crowd.characters.size());
        const OffscreenTarget target(8, 8, 1);
        target.begin();
        const AnimationView& animation = crowd.data.asset.animation;
        const auto frames = [&](std::size_t count) {
            for (std::size_t f = 0; f < count; ++f) {
                for (std::size_t i = 0; i < crowd.characters.size(); ++i) {
                    crowd.evaluators[i].setPose(animation.bonesOf((f + i) % animation.frameCount()), {});
                    crowd.sets[i].setMaterial(f % 3, (f + i) % 3);
                    crowd.sets[i].setLightRotation(aboutY(0.01f * float(f)));
                }
                painter.evaluate(Channel::kShaded, crowd.characters, crowd.view.eye);
                painter.draw(crowd.view);
            }
            gl::Finish();
        };
        frames(20);
        const GlCalls calls;
        const std::size_t before = allocationCount();
        frames(1000);
        EXPECT_EQ(allocationCount(), before) << "with buffer storage: " << storage;
        EXPECT_EQ(calls.made(), 0);
        const auto another = std::make_unique<ModelPainter>(crowd.asset, 1);
        EXPECT_GT(calls.made(), 0) << "the counter counts";
        EXPECT_GT(allocationCount(), before) << "the counter counts";
    }
}

// For N characters there is the asset once, and what each of them has of its own.
TEST(ModelPainter, CharactersShareTheAsset) {
    Crowd crowd(1, {.precision = AssetPrecision::kF16, .rings = 24, .slots = 3});
    std::size_t arrays = 0;
    for (const ClusterView& cluster : crowd.data.asset.model.clusters)
        arrays += 2 * (cluster.mean.count + cluster.basis.count);
    std::size_t first = 0, of_one = 0;
    std::printf("characters  bytes of GL buffers\n");
    for (const std::size_t count : {1, 2, 10, 100}) {
        const GlCalls calls;
        const auto asset = std::make_shared<GlAsset>(crowd.data.asset, &crowd.sets.front());
        const std::size_t shared = calls.bufferBytes();
        EXPECT_EQ(asset->bytes(), shared);
        EXPECT_GT(shared, arrays);
        EXPECT_LT(shared, arrays + 200 * asset->vertexCount()) << "the mesh, and nothing decoded";
        const ModelPainter painter(asset, count);
        const std::size_t own = calls.bufferBytes() - shared;
        EXPECT_EQ(painter.bytes(), own);
        std::printf("%10zu  %zu shared + %zu\n", count, shared, own);
        if (count == 1) first = own;
        if (count == 2) of_one = own - first;
        EXPECT_NEAR(double(own), double(first + (count - 1) * of_one), 3 * 256) << "linear, but for the parts' ends";
    }
    EXPECT_LT(of_one, 40 * crowd.data.asset.mesh.positions.size())
        << "a position and a value of every vertex, and a pose";
}

TEST(UploadRing, PartsTakeTurns) {
    const auto context = createGlContext(GlBackend::kAuto);
    UploadRing ring(100);
    std::vector<const float*> parts;
    for (int i = 0; i < 7; ++i) {
        const std::span<float> part = ring.next();
        ASSERT_EQ(part.size(), 100u);
        parts.push_back(part.data());
        ring.bind(0);
        ring.release();
    }
    for (std::size_t i = 0; i + 3 < parts.size(); ++i) {
        EXPECT_EQ(parts[i + 3], parts[i]);
        EXPECT_GE(std::abs(parts[i + 1] - parts[i]), 100);
        EXPECT_GE(std::abs(parts[i + 2] - parts[i]), 100);
    }
    EXPECT_THROW(UploadRing(std::size_t(1) << 40), Unsupported);
}

}  // namespace
}  // namespace penumbra::test_model_painter
