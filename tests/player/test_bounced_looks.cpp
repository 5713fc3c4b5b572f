// Tests light that bounces on live materials and on membranes, on the CPU and on the GPU.
#include <gtest/gtest.h>

#include "pack/pack_asset.h"
#include "player/draw/model_painter.h"
#include "player/draw/picture_view.h"
#include "player/frame/frame_values.h"
#include "player/gl/offscreen_target.h"
#include "runtime/shade/shading_set.h"
#include "tests/difference.h"
#include "tests/synthetic_cloth.h"
#include "tests/synthetic_indirect.h"

namespace penumbra::test_bounced_looks {
namespace {

constexpr Vec3 kRho{0.5f, 0.3f, 0.1f}, kTau{0.2f, 0.4f, 0.6f};

// A waving sheet on which light bounces, packed and opened, in one pose.
struct LitSheet {
    enum Material : std::size_t { kWhite, kMembrane, kOpenMembrane, kPhong, kGgx, kMaterials };
    enum Light : std::size_t { kSky, kNoise };
    std::vector<std::byte> bytes;
    AssetView asset;
    std::optional<Evaluator> evaluator;
    FrameVertices at;

    LitSheet() {
        std::vector<BrdfFile> brdfs(kMaterials, synthetic::lambert());
        for (const std::size_t m : {kMembrane, kOpenMembrane}) {
            brdfs[m].name = m == kMembrane ? "membrane" : "open";
            brdfs[m].lobes = {lobeOf({})};
            brdfs[m].membrane = Membrane{kRho, kTau, m == kOpenMembrane};
        }
        for (const std::size_t m : {kPhong, kGgx}) {
            brdfs[m] = {};
            brdfs[m].name = m == kPhong ? "phong" : "ggx";
            brdfs[m].slice_order = brdfs[m].view_order = 1;
            brdfs[m].even_index = {0};
            brdfs[m].lobes = {lobeOf(parseBrdf(m == kPhong ? "phong-live:exponent=3" : "ggx-live:alpha=0.4"))};
        }
        const std::vector<LightFile> lights = {synthetic::light(4, 0), synthetic::light(4, 0.6)};
        Model model = synthetic::clothModel();
        synthetic::addIndirect(model);
        bytes = packAsset(model, brdfs, lights, {.precision = AssetPrecision::kF32}, "{}", 1).bytes;
        asset = openAsset(bytes);
        evaluator.emplace(asset);
        Shot shot;
        shot.asset = &asset;
        shot.frame = 2;
        evaluateFrame(shot, VisibilitySource::kModel, *evaluator, 1, at);
    }
    std::vector<Vec3> shade(ShadingSet& set, Bounces bounces, std::span<const float> coefficients) const {
        set.setBounces(bounces);
        std::vector<Vec3> out(at.positions.size());
        set.shade({at.positions, at.normals, at.tangents, coefficients, 0, out.size(), at.indirect}, {0.5f, 3, 1}, out);
        return out;
    }
};

// What comes from where the sky is hidden is E_ind / pi (a - t_u) / (1 - E). A white Lambertian surface shows E_ind /
// pi, and a white sky shows a and t_u.
TEST(BouncedLooks, LiveLobesReflectWhatComesFromWhereTheSkyIsHidden) {
    const LitSheet sheet;
    ShadingSet set(sheet.asset);
    const std::size_t count = sheet.at.positions.size();
    std::vector<float> e(count), open;
    ambient(sheet.asset, sheet.at.coefficients, e);
    for (std::size_t v = 0; v < count; ++v) {
        std::vector<float> free = freeSight(sheet.asset.model.convention);
        free.resize(std::size_t(sheet.asset.model.stride));
        open.insert(open.end(), free.begin(), free.end());
    }
    for (const ShadePath& path : shadePaths())
        for (const std::size_t material : {LitSheet::kPhong, LitSheet::kGgx}) {
            set.usePath(path);
            set.setLight(LitSheet::kNoise);
            set.setMaterial(LitSheet::kWhite);
            const std::vector<Vec3> white = sheet.shade(set, Bounces::kIndirect, sheet.at.coefficients);
            set.setMaterial(material);
            const std::vector<Vec3> bounced = sheet.shade(set, Bounces::kIndirect, sheet.at.coefficients);
            set.setLight(LitSheet::kSky);
            const std::vector<Vec3> albedo = sheet.shade(set, Bounces::kDirect, open);
            const std::vector<Vec3> seen = sheet.shade(set, Bounces::kDirect, sheet.at.coefficients);
            Largest most;
            for (std::size_t v = 0; v < count; ++v) {
                if (e[v] > 0.95f) continue;
                const Vec3 expected = white[v] * (std::max(albedo[v].x - seen[v].x, 0.0f) / (1 - e[v]));
                for (int c = 0; c < 3; ++c) EXPECT_NEAR(bounced[v][c], expected[c], 2e-5f) << path.name << v;
                most.add(bounced[v].x);
            }
            EXPECT_GT(most, 0.02f);
        }
}

TEST(BouncedLooks, MembranesMixTheLightThatBouncesToEitherSide) {
    const LitSheet sheet;
    ShadingSet set(sheet.asset);
    set.setLight(LitSheet::kNoise);
    for (const Bounces bounces : {Bounces::kBoth, Bounces::kIndirect}) {
        set.setMaterial(LitSheet::kWhite);
        const std::vector<Vec3> white = sheet.shade(set, bounces, sheet.at.coefficients);
        set.setMaterial(LitSheet::kMembrane);
        const std::vector<Vec3> mixed = sheet.shade(set, bounces, sheet.at.coefficients);
        for (std::size_t v = 0; v < white.size(); ++v)
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(mixed[v][c], kRho[c] * white[v][c] + kTau[c] * white[set.otherSides()[v]][c], 2e-6f);
        if (bounces != Bounces::kIndirect) continue;
        set.setMaterial(LitSheet::kOpenMembrane);
        const std::vector<Vec3> open = sheet.shade(set, bounces, sheet.at.coefficients);
        for (std::size_t v = 0; v < white.size(); ++v)
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(open[v][c], kRho[c] * white[v][c], 1e-5f);
    }
}

// Bound: half a step of 255.
TEST(BouncedLooks, TheGpuGivesWhatTheCpuGives) {
    LitSheet sheet;
    const std::unique_ptr<GlContext> context = createGlContext(GlBackend::kAuto);
    OffscreenTarget target{64, 64, 1};
    ShadingSet set(sheet.asset);
    set.setLight(LitSheet::kNoise);
    ModelPainter painter(std::make_shared<GlAsset>(sheet.asset, &set), 1);
    ValuePainter values(sheet.asset.mesh, Channel::kShaded, Sides::kSeen);
    RenderOptions options;
    options.width = options.height = 64;
    options.camera = "pitch=60";
    const FrameView view = makePictureView(options, sheet.asset, sheet.at.positions);
    for (std::size_t material = 0; material < LitSheet::kMaterials; ++material)
        for (const Bounces bounces : {Bounces::kBoth, Bounces::kDirect, Bounces::kIndirect}) {
            set.setMaterial(material);
            set.setBounces(bounces);
            const PosedCharacter character{&*sheet.evaluator, {}, &set};
            painter.evaluate(Channel::kShaded, {&character, 1}, view.eye);
            target.begin();
            painter.draw(view);
            const Image drawn = target.read();
            std::vector<Vec3> radiance;
            shadeFrame(set, sheet.at, view.eye, 1, radiance);
            target.begin();
            values.draw(view, sheet.at.positions, radiance);
            const Image expected = target.read();
            EXPECT_LT(largestDifference(drawn.pixels, expected.pixels), 0.5f / 255)
                << "material " << material << " bounces " << int(bounces);
            EXPECT_GT(largestOf(expected.pixels), 0.01) << "material " << material << " bounces " << int(bounces);
        }
}

}  // namespace
}  // namespace penumbra::test_bounced_looks
