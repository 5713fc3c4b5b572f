#include <gtest/gtest.h>

#include "fit/visibility/fit_visibility.h"
#include "fit/visibility/predict.h"
#include "formats/common/errors.h"
#include "sh/dihedral_angles.h"
#include "tests/fit/hinged_sheet.h"
#include "tests/fit/synthetic_character.h"

namespace penumbra::test_deforming_fit {
namespace {

using synthetic::TemporaryFile;

constexpr std::size_t kFrames = 60;  // in three clips

// A hinged sheet with backs, and two inputs: a ball that moves and a wind.
struct Sheet {
    VisibilityHeader header;
    std::vector<VisibilityFrame> frames;  // their coefficients are zero
};

Sheet makeSheet() {
    const synthetic::HingedSheet source = synthetic::hingedSheet(kFrames, 0.002, 8);
    Sheet sheet;
    sheet.header.order = 3;
    sheet.header.rays = 1;
    sheet.header.mesh = withBacks(source.mesh);
    sheet.header.rest_normals = meshNormals(sheet.header.mesh, sheet.header.mesh.rest_positions);
    sheet.header.frames.clip_names = {"a", "b", "c"};
    sheet.header.edges = innerEdges(source.mesh.triangles);
    sheet.header.input_names = {"ball.x", "ball.y", "ball.z", "wind"};
    sheet.header.pose_parameterisation = kDihedralAngles;
    sheet.header.pose_size = int(sheet.header.edges.size() + 4);
    sheet.header.provenance = {"test", "0", "{}", {}};
    const std::size_t vertices = source.mesh.vertexCount();
    for (std::size_t f = 0; f < kFrames; ++f) {
        sheet.header.frames.clip.push_back(std::uint16_t(3 * f / kFrames));
        sheet.header.frames.time.push_back(double(f) / 30);
        VisibilityFrame& frame = sheet.frames.emplace_back();
        frame.positions.assign(source.positions.begin() + long(f * vertices),
                               source.positions.begin() + long((f + 1) * vertices));
        frame.pose.resize(sheet.header.edges.size());
        dihedralAngles(sheet.header.edges, frame.positions, frame.pose);
        appendBackPositions(frame.positions);
        frame.normals = meshNormals(sheet.header.mesh, frame.positions);
        const float t = float(f);
        frame.pose.insert(frame.pose.end(),
                          {std::sin(0.3f * t), std::cos(0.2f * t), 0.1f * t / 60, 5 + 2 * std::sin(0.5f * t)});
        frame.coefficients.resize(2 * vertices * 9);
    }
    return sheet;
}

void write(const std::filesystem::path& path, const Sheet& sheet) {
    VisibilityWriter writer(path, sheet.header, Precision::kFloat32);
    for (const VisibilityFrame& frame : sheet.frames) writer.writeFrame(frame);
    writer.finish();
}

FitOptions optionsFor(FeatureKind features) {
    FitOptions options;
    options.model = ModelKind::kLinear;
    options.features = features;
    options.convention = parseConvention("D3");
    options.input_variance = options.output_variance = 1;
    options.threads = 2;
    return options;
}

// Writes visibility that is exactly linear in what the model of `options` sees, with the parts and clusters of the same
// fit.
void writeLinearSheet(const std::filesystem::path& path, const FitOptions& options) {
    Sheet sheet = makeSheet();
    write(path, sheet);
    const VisibilityReader reader(path);
    const Model model = fitVisibility(reader, "empty", options, {}).model;
    const FeatureRecipe recipe = recipeOf(model);
    std::vector<double> raw(recipe.count());
    for (std::size_t f = 0; f < kFrames; ++f) {
        VisibilityFrame& frame = sheet.frames[f];
        const std::span<const Affine> bones =
            std::span(model.bones).subspan(f * model.skin.jointCount()).first(model.skin.jointCount());
        const std::span<const float> pose =
            std::span(model.pose).subspan(f * std::size_t(model.pose_size), std::size_t(model.pose_size));
        std::vector<Mat3> rotations;
        for (const Affine& bone : bones) rotations.push_back(nearestRotation(bone.linear()));
        frame.coefficients.clear();
        for (std::size_t v = 0; v < model.mesh.vertexCount(); ++v) {
            const int joint = model.clusters[model.cluster_of_vertex[v]].joint;
            rawFeatures(recipe, joint, bones, rotations, pose, raw);
            std::vector<double> few(12 * ((raw.size() + 11) / 12));  // numbersOf() takes every first 3 of 12
            for (std::size_t i = 0; i < raw.size(); ++i) few[i] = 0.3 * raw[i];
            const std::vector<float> local =
                synthetic::momentsFrom(model.convention, synthetic::coefficientsOf(v, model.convention, few));
            const Vec3 t = carriedTangent(frame.normals[v], rotations[std::size_t(joint)], model.rest_tangents[v]);
            std::vector<float> moments(local.size());
            apply(makeShRotation(3, localFrame(frame.normals[v], t)), local, moments);
            frame.coefficients.insert(frame.coefficients.end(), moments.begin(), moments.end());
        }
    }
    write(path, sheet);
}

TEST(DeformingFit, FindsAFunctionThatIsLinearInTheFeatures) {
    for (FeatureKind features : {FeatureKind::kRelativeBones, FeatureKind::kDihedrals}) {
        const TemporaryFile file("sheet.vis.h5");
        const FitOptions options = optionsFor(features);
        writeLinearSheet(file.path, options);
        const FitResult result = fitVisibility(VisibilityReader(file.path), "sheet", options, {});
        EXPECT_LT(result.report.train.relative_error, 1e-2) << nameOf(features);
        EXPECT_TRUE(result.model.deforming);
        EXPECT_EQ(result.model.skin.joint_names.back(), "wind");
        EXPECT_EQ(result.model.input_joints.size(), 2u);
        EXPECT_EQ(result.model.positions.size(), kFrames * result.model.mesh.frontVertexCount());
    }
}

// The file that predict writes has the errors that the fit counted. Bones, angles and inputs are computed again from
// the file.
TEST(DeformingFit, PredictionOfTheFileIsTheFit) {
    for (FeatureKind features : {FeatureKind::kRelativeBones, FeatureKind::kDihedrals}) {
        const TemporaryFile file("sheet.vis.h5"), model_file("sheet.model.h5"), predicted("predicted.vis.h5");
        const FitOptions options = optionsFor(features);
        writeLinearSheet(file.path, options);
        const VisibilityReader reader(file.path);
        writeModel(model_file.path, fitVisibility(reader, "sheet", options, {}).model);
        predictFile(readModel(model_file.path), reader, {predicted.path, {"test", "0", "{}", {}}, 2});
        const VisibilityReader prediction(predicted.path);
        double squared = 0, total = 0;
        for (std::size_t f = 0; f < kFrames; f += 7) {
            // Coefficients of a mirrored function are twice the moments here, because the moments have no odd numbers.
            const std::vector<float> a = reader.readFrame(f).coefficients, b = prediction.readFrame(f).coefficients;
            for (std::size_t i = 0; i < a.size(); ++i) {
                squared += (2 * double(a[i]) - b[i]) * (2 * double(a[i]) - b[i]);
                total += 4 * double(a[i]) * a[i];
            }
        }
        EXPECT_LT(std::sqrt(squared / total), 2e-3) << nameOf(features);
    }
}

TEST(DeformingFit, FrontsAndBacksAreInClustersOfTheirOwn) {
    const TemporaryFile file("sheet.vis.h5");
    write(file.path, makeSheet());
    FitOptions options = optionsFor(FeatureKind::kRelativeBones);
    for (int clusters : {0, 2, 6, 15}) {
        options.clusters = clusters;
        const Model model = fitVisibility(VisibilityReader(file.path), "sheet", options, {}).model;
        const std::size_t fronts = model.mesh.frontVertexCount();
        for (const ClusterModel& cluster : model.clusters)
            EXPECT_EQ(cluster.vertices.front() < fronts, cluster.vertices.back() < fronts) << clusters;
        if (clusters) {
            EXPECT_EQ(model.clusters.size(), std::size_t(clusters + 1) / 2 * 2);
        }
    }
}

TEST(DeformingFit, RefusesWhatDoesNotGoTogether) {
    const TemporaryFile sheet("sheet.vis.h5"), character("character.vis.h5");
    write(sheet.path, makeSheet());
    synthetic::writeCharacter(character.path, {});
    const auto refused = [](const std::filesystem::path& path, const FitOptions& options) {
        EXPECT_THROW(fitVisibility(VisibilityReader(path), "x", options, {}), UsageError);
    };
    refused(sheet.path, optionsFor(FeatureKind::kJointAngles));
    refused(character.path, optionsFor(FeatureKind::kDihedrals));
    FitOptions parts = optionsFor(FeatureKind::kRelativeBones);
    parts.parts = 5;
    refused(character.path, parts);
    parts.parts = 5000;
    refused(sheet.path, parts);
}

}  // namespace
}  // namespace penumbra::test_deforming_fit
