// Tests truth and check of a deforming, two-sided mesh, where the bake's positions pose the asset.
#include <gtest/gtest.h>
#include <unistd.h>

#include "formats/asset/mapped_file.h"
#include "formats/common/errors.h"
#include "pack/check/check_asset.h"
#include "pack/pack_asset.h"
#include "pack/pack_truth.h"
#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading.h"
#include "sh/sh_rotation.h"
#include "tests/posed_vertices.h"
#include "tests/refusal.h"
#include "tests/synthetic_cloth.h"

namespace penumbra::test_check_deforming {
namespace {

namespace fs = std::filesystem;

const auto kNoProgress = [](std::size_t) {};

Model modelOf(synthetic::ClothOptions options) {
    options.convention = parseConvention("B4");
    return synthetic::clothModel(options);
}

// A bake whose visibility is what the model says for its positions. Convention B's numbers are the moments
// themselves.
struct ClothBake {
    Model model;
    std::vector<std::byte> bytes;
    AssetView asset;
    fs::path path;

    explicit ClothBake(const synthetic::ClothOptions& options = {})
        : model(modelOf(options)), path(fs::temp_directory_path() / name()) {
        bytes = packAsset(model, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1).bytes;
        asset = openAsset(bytes);
        write();
    }
    ~ClothBake() { fs::remove(path); }
    static std::string name() { return "cloth" + std::to_string(::getpid()) + ".vis.h5"; }

    void write() const {
        VisibilityHeader header;
        header.order = model.convention.order;
        header.rays = 16;
        header.mesh = model.mesh;
        header.rest_normals = model.rest_normals;
        header.frames = model.frames;
        header.edges = innerEdges(header.mesh.frontTriangles());
        header.input_names = model.input_names;
        header.pose_size = int(header.edges.size() + header.input_names.size());
        header.pose_parameterisation = kDihedralAngles;
        header.provenance = model.provenance;
        VisibilityWriter writer(path, header, Precision::kFloat32);
        for (std::size_t f = 0; f < model.frames.frameCount(); ++f) writer.writeFrame(frame(f, header));
        writer.finish();
    }

    VisibilityFrame frame(std::size_t f, const VisibilityHeader& header) const {
        Evaluator evaluator(asset);
        const std::size_t count = evaluator.vertexCount(), points = asset.mesh.pointCount();
        const std::size_t n = header.coefficientCount();
        const std::span<const Vec3> places = std::span(model.positions).subspan(f * points, points);
        const std::vector<float> inputs = synthetic::clothInputs(model.frames.time[f]);
        evaluator.setPositions(places, inputs);
        const auto [positions, normals, tangents, coefficients, indirect] = PosedArrays(evaluator);
        VisibilityFrame out;
        out.positions.resize(count);
        out.normals.resize(count);
        out.coefficients.resize(count * n);
        out.pose.resize(header.edges.size());
        dihedralAngles(header.edges, places, out.pose);
        out.pose.insert(out.pose.end(), inputs.begin(), inputs.end());
        for (std::size_t v = 0; v < count; ++v) {
            const std::size_t point = asset.mesh.shading_point[v];
            out.positions[point] = positions[v];
            out.normals[point] = normals[v];
            applyTransposed(makeShRotation(header.order, toLocalFrame(normals[v], tangents[v])),
                            std::span<const float>(coefficients).subspan(v * n, n),
                            std::span(out.coefficients).subspan(point * n, n));
        }
        return out;
    }
};

// Measured: 3e-6, from single-precision rotations there and back.
TEST(CheckDeforming, AModelThatMadeTheTruthHasNoError) {
    for (const FeatureKind features : {FeatureKind::kRelativeBones, FeatureKind::kDihedrals}) {
        const ClothBake bake({.features = features});
        const VisibilityReader truth(bake.path);
        const CheckResult result = checkAsset(bake.asset, truth, {.second_bake = nullptr}, 2, kNoProgress);
        ASSERT_EQ(result.clips.size(), 2u);
        EXPECT_LT(result.training.relative_error, 3e-5);
        EXPECT_LT(result.held_out.relative_error, 3e-5);
        EXPECT_TRUE(result.clips[1].held_out);
    }
}

TEST(CheckDeforming, RefusesWhatDoesNotFit) {
    ClothBake bake;
    const auto refusal = [&] {
        bake.write();
        const VisibilityReader reader(bake.path);
        return refusalBy([&] { checkAsset(bake.asset, reader, {}, 1, kNoProgress); });
    };
    EXPECT_EQ(refusal(), "accepted");
    bake.model.input_names[2] = "elsewhere";
    EXPECT_EQ(refusal(), "/inputs/names are not those of the asset");
    const ClothBake one_sided({.two_sided = false});
    const VisibilityReader reader(one_sided.path);
    EXPECT_THROW(checkAsset(bake.asset, reader, {}, 1, kNoProgress), InvalidInput);
}

TEST(TruthOfDeforming, HoldsPositionsInputsAndBothSides) {
    const ClothBake bake;
    const VisibilityReader reader(bake.path);
    const fs::path out = bake.path.string() + ".truth.pnb";
    const TruthOptions options{AssetPrecision::kF32, {"gust"}};
    packTruth(reader, planTruth(reader, options), options, "{}", out, kNoProgress);
    const MappedFile file(out);
    const AssetView truth = openAsset(file.bytes(), out.string());
    ASSERT_TRUE(truth.has_truth && !truth.has_model);
    EXPECT_TRUE(truth.mesh.two_sided);
    ASSERT_EQ(truth.animation.frameCount(), 2u);
    EXPECT_EQ(truth.animation.input_names.size(), 4u);
    EXPECT_EQ(truth.animation.inputsOf(1)[0], synthetic::clothInputs(4 / 3.0)[0]);
    std::vector<Vec3> points(truth.mesh.pointCount());
    readPositions(truth, 1, points);
    for (std::size_t s = 0; s < points.size(); ++s)
        EXPECT_LE(length(points[s] - bake.model.positions[4 * points.size() + s]), truth.animation.playback.error);
    fs::remove(out);
}

}  // namespace
}  // namespace penumbra::test_check_deforming
