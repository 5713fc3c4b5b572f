// Pictures of light that bounces by the shaders, against those of the CPU: everything that the window's key 9 shows,
// and the ambient channel with bounces.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "pack/pack_asset.h"
#include "player/draw/model_painter.h"
#include "player/draw/picture_view.h"
#include "player/frame/frame_values.h"
#include "player/gl/offscreen_target.h"
#include "tests/capi/packed_asset.h"
#include "tests/difference.h"
#include "tests/synthetic_composition.h"
#include "tests/synthetic_indirect.h"

namespace penumbra::test_bounces_gpu {
namespace {

constexpr int kSize = 128;  // pixels

double srgb(double linear) { return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055; }

// The largest difference of two pictures in steps of 255, of linear and of sRGB values.
struct Steps {
    Largest linear, srgb, brightest;
};

Steps stepsBetween(const Image& a, const Image& b) {
    Steps steps;
    EXPECT_EQ(a.pixels.size(), b.pixels.size());
    for (std::size_t p = 0; p < a.pixels.size(); ++p)
        for (int c = 0; c < 3; ++c) {
            const double x = std::clamp<double>(a.pixels[p][c], 0, 1), y = std::clamp<double>(b.pixels[p][c], 0, 1);
            steps.linear.add(255 * std::abs(x - y));
            steps.srgb.add(255 * std::abs(srgb(x) - srgb(y)));
            steps.brightest.add(x);
        }
    return steps;
}

// A posed character that light bounces to, drawn by both paths.
class LitPictures {
public:
    LitPictures(const Model& model, AssetPrecision precision, Reflectance reflectance)
        : bytes_(packed(model, precision)), asset_(openAsset(bytes_)), evaluator_(asset_) {
        set.emplace(asset_, ShadingChoice{reflectance, LightForm::kRotation});
        set->setLight(1);
        shot_.asset = &asset_;
        shot_.frame = 1;
        evaluateFrame(shot_, VisibilitySource::kModel, evaluator_, 1, at_);
        painter_.emplace(std::make_shared<GlAsset>(asset_, &*set, &evaluator_), 1);
        RenderOptions options;
        options.width = options.height = kSize;
        view_ = makePictureView(options, asset_, at_.positions);
    }
    std::optional<ShadingSet> set;

    Image onGpu(Channel channel) {
        const PosedCharacter character{&evaluator_, {}, &*set};
        painter_->evaluate(channel, {&character, 1}, view_.eye);
        target_.begin();
        painter_->draw(view_);
        return target_.read();
    }
    Image onCpu(Channel channel) {
        ValuePainter painter(asset_.mesh.triangles, channel);
        target_.begin();
        painter.draw(view_, at_.positions, channelValues(shot_, channel, &*set, at_, {}, view_.eye, 1));
        return target_.read();
    }

private:
    std::unique_ptr<GlContext> context_ = createGlContext(GlBackend::kAuto);
    OffscreenTarget target_{kSize, kSize, 1};
    std::vector<std::byte> bytes_;
    AssetView asset_;
    Evaluator evaluator_;
    Shot shot_;
    FrameVertices at_;
    std::optional<ModelPainter> painter_;
    FrameView view_;

    static std::vector<std::byte> packed(Model model, AssetPrecision precision) {
        synthetic::addIndirect(model);
        return packAsset(model, capi_test::materials(), capi_test::lights(3),
                         {.precision = precision, .indirect_bytes_per_vertex = 1000}, "{}", 1)
            .bytes;
    }
};

// The bound is the project's, half a step, and holds for linear values as for those that a screen gets.
TEST(BouncesGpu, PicturesAreThoseOfTheCpu) {
    const synthetic::TubeOptions tube{
        .rings = 30, .segments = 12, .joints = 6, .clusters = 4, .components = 5, .inputs = 4};
    Steps worst;
    const auto compare = [&](LitPictures& pictures, Channel channel, const std::string& what) {
        const Steps steps = stepsBetween(pictures.onGpu(channel), pictures.onCpu(channel));
        EXPECT_LT(steps.linear, 0.5) << what;
        EXPECT_LT(steps.srgb, 0.5) << what;
        EXPECT_GT(steps.brightest, 0.02) << what;
        worst.linear.add(steps.linear);
        worst.srgb.add(steps.srgb);
    };
    const auto compareAll = [&](const Model& model, AssetPrecision precision, Reflectance reflectance) {
        LitPictures pictures(model, precision, reflectance);
        const std::string of = std::string(model.composition ? "composed, " : "additive, ") + nameOf(precision);
        for (const std::size_t material : {0u, 1u}) {
            if (!pictures.set->hasMaterial(material)) continue;  // "lambert" has no operators
            pictures.set->setMaterial(material);
            for (const Bounces bounces : {Bounces::kBoth, Bounces::kDirect, Bounces::kIndirect}) {
                pictures.set->setBounces(bounces);
                compare(pictures, Channel::kShaded,
                        of + ", material " + std::to_string(material) + ", bounces " + std::to_string(int(bounces)));
            }
        }
        compare(pictures, Channel::kBouncedAmbient, of + ", ambient");
    };
    compareAll(synthetic::tubeModel(tube), AssetPrecision::kI8, Reflectance::kSlices);
    compareAll(synthetic::composedTube(tube), AssetPrecision::kF16, Reflectance::kOperators);
    std::printf("largest difference of 255: %.1e linear, %.1e sRGB\n", worst.linear.value(), worst.srgb.value());
}

}  // namespace
}  // namespace penumbra::test_bounces_gpu
