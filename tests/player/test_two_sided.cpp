// Tests a thin sheet from both sides: each side shows its own vertices, on both paths, and is what a click finds.
#include <gtest/gtest.h>

#include "formats/common/errors.h"
#include "pack/pack_asset.h"
#include "player/render/render_offscreen.h"
#include "player/view/view_pick.h"
#include "tests/difference.h"
#include "tests/synthetic_cloth.h"

namespace penumbra::test_two_sided {
namespace {

constexpr int kSize = 48;

struct Sheet {
    std::vector<std::byte> bytes;
    AssetView asset;

    Sheet() {
        const std::vector<BrdfFile> brdfs = {synthetic::lambert()};
        const std::vector<LightFile> lights = {synthetic::light(4, 0.3)};
        bytes = packAsset(synthetic::clothModel(), brdfs, lights, {.precision = AssetPrecision::kI8}, "{}", 1).bytes;
        asset = openAsset(bytes);
    }
    Image picture(Channel channel, EvaluationPath path, const std::string& camera, int frame = 0) const {
        RenderOptions options;
        options.width = options.height = kSize;
        options.samples = 1;
        options.channel = channel;
        options.path = path;
        options.camera = camera;
        options.frame = frame;
        return renderOffscreen(options, asset, nullptr, 1).image;
    }
};

constexpr const char* kAbove = "pitch=80";
constexpr const char* kBelow = "pitch=-80";

// The sheet is flat at y = 1 in frame 0. The normals channel is (n + 1) / 2.
TEST(TwoSided, EachSideShowsItsOwnNormals) {
    const Sheet sheet;
    for (const EvaluationPath path : {EvaluationPath::kCpu, EvaluationPath::kGlsl})
        for (const char* camera : {kAbove, kBelow}) {
            const Image image = sheet.picture(Channel::kNormals, path, camera);
            const Vec3 middle = image.pixels[kSize * kSize / 2 + kSize / 2];
            EXPECT_NEAR(middle.y, camera == kAbove ? 1 : 0, 1e-5f);
            EXPECT_NEAR(middle.x, 0.5f, 1e-5f);
        }
}

TEST(TwoSided, BothPathsDrawTheSame) {
    const Sheet sheet;
    for (const Channel channel : {Channel::kShaded, Channel::kAmbient, Channel::kNormals})
        for (const char* camera : {kAbove, kBelow, "pitch=10"}) {
            const Image cpu = sheet.picture(channel, EvaluationPath::kCpu, camera, 1);
            const Image gpu = sheet.picture(channel, EvaluationPath::kGlsl, camera, 1);
            EXPECT_LT(largestDifference(cpu.pixels, gpu.pixels), 2e-3) << "channel " << int(channel) << ", " << camera;
        }
}

TEST(TwoSided, TheSideThatIsSeenIsPicked) {
    const std::vector<Vec3> positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const std::vector<std::uint32_t> triangles = {0, 1, 2, 3, 5, 4};
    MeshView mesh;
    mesh.triangles = triangles;
    mesh.two_sided = mesh.cull_backs = true;
    double distance = 0;
    EXPECT_EQ(pickVertex(positions, mesh, {0.1, 0.1, 2}, {0, 0, -1}, distance), 0u);
    EXPECT_EQ(pickVertex(positions, mesh, {0.1, 0.1, -2}, {0, 0, 1}, distance), 3u);
    EXPECT_EQ(pickVertex(positions, mesh, {0.8, 0.1, -2}, {0, 0, 1}, distance), 4u);
}

TEST(TwoSided, FramesThatWereLeftOutAreSaidSo) {
    const std::vector<std::byte> bytes =
        packAsset(synthetic::clothModel(), {}, {}, {.precision = AssetPrecision::kI8, .playback = false}, "{}", 1)
            .bytes;
    RenderOptions options;
    options.channel = Channel::kAmbient;
    try {
        renderOffscreen(options, openAsset(bytes, "sheet.pnb"), nullptr, 1);
        FAIL();
    } catch (const Unsupported& error) {
        EXPECT_NE(std::string(error.what()).find("sheet.pnb: its frames were left out"), std::string::npos);
    }
}

}  // namespace
}  // namespace penumbra::test_two_sided
