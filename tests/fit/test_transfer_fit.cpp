#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <span>
#include <utility>

#include "fit/papers/transfer/fit_transfer.h"
#include "fit/papers/transfer/predict_transfer.h"
#include "fit/papers/transfer/transfer_source.h"
#include "formats/common/errors.h"
#include "sh/quadrature.h"
#include "sh/sh_basis.h"
#include "tests/fit/synthetic_character.h"
#include "tests/sh/sh_project.h"

namespace penumbra::test_transfer_fit {
namespace {

using synthetic::TemporaryFile;
using testing::HasSubstr;

// A model with `vertices` and `angles` of the sizes of Nowrouzezahrai 2007; its numbers are zeros.
TransferModel sizedModel(std::size_t vertices, std::size_t angles, std::size_t k, std::size_t m) {
    TransferModel model;
    model.mesh.rest_positions.resize(vertices);
    model.angles.resize(angles);
    if (k == 0) {
        model.kind = TransferModelKind::kLinear;
        model.weights.resize(36 * (angles + 1) * vertices);
        return model;
    }
    model.pose_basis.resize(angles * k);
    model.weights.resize(36 * (k + 1) * m);
    model.basis.resize(m * vertices);
    model.mean.resize(vertices);
    return model;
}

// Table 2 of Nowrouzezahrai 2007: Master Pai has 11,534 vertices and 54 angles, Armadillo 24,893 and 25.
TEST(TransferModel, HasThePapersSizesToTheDigit) {
    EXPECT_EQ(paperMeshBytes(sizedModel(11534, 54, 8, 22)), 1660896u);
    EXPECT_EQ(paperBytes(sizedModel(11534, 54, 8, 22)), 1045232u);
    EXPECT_EQ(paperBytes(sizedModel(11534, 54, 15, 500)), 24223240u);
    EXPECT_EQ(paperBytes(sizedModel(11534, 54, 0, 0)), 89688384u);
    EXPECT_EQ(paperMeshBytes(sizedModel(24893, 25, 8, 22)), 3584592u);
    EXPECT_EQ(paperBytes(sizedModel(24893, 25, 8, 22)), 2219896u);
    EXPECT_EQ(paperBytes(sizedModel(24893, 25, 15, 500)), 50939500u);
    EXPECT_EQ(paperBytes(sizedModel(24893, 25, 0, 0)), 89614800u);
    // The mean of the vertices and the bias of a linear model are ours to count.
    EXPECT_EQ(modelBytes(sizedModel(11534, 54, 8, 22)), 1045232u + 4 * 11534);
    EXPECT_EQ(modelBytes(sizedModel(11534, 54, 0, 0)), 89688384u + 4 * 36 * 11534);
}

TEST(HemisphereNorm, MatchesGoldenTransferError) {
    std::ifstream in(PENUMBRA_SOURCE_DIR "/tests/golden/transfer.json");
    const nlohmann::json golden = nlohmann::json::parse(in);
    const std::vector<double> a = golden["t1"], b = golden["t2"];
    std::vector<double> difference(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) difference[i] = a[i] - b[i];
    const double expected = golden["E"], tolerance = golden["tol_E"];
    EXPECT_NEAR(HemisphereNorm(6).squared(difference, a, {0, 0, 1})[0], expected, tolerance);
}

// By its definition: the integral of the squared function over the hemisphere about the normal.
TEST(HemisphereNorm, IsTheIntegralOverTheVisibleHemisphere) {
    const Vec3 normal = normalized(Vec3{0.3f, -0.5f, 0.8f});
    std::vector<double> t(16), none(16);
    for (std::size_t i = 0; i < t.size(); ++i) t[i] = std::sin(1 + 1.7 * double(i));
    double expected = 0;
    for (const WeightedDirection& sample : gaussSphere(400, 400)) {
        if (dot(sample.direction, toDouble(normal)) < 0) continue;
        std::array<double, 16> y;
        evalBasis(4, sample.direction, std::span<double>(y));
        double f = 0;
        for (std::size_t i = 0; i < t.size(); ++i) f += t[i] * y[i];
        expected += sample.weight * f * f;
    }
    const auto [found, zero] = HemisphereNorm(4).squared(t, none, normal);
    EXPECT_NEAR(found, expected, 2e-3 * expected);  // the edge of the hemisphere lies between samples
    EXPECT_EQ(zero, 0);
}

// An open point: b are the moments of the hemisphere, and the transfer those of the clamped cosine.
TEST(CosineProduct, TurnsMomentsOfVisibilityIntoTransfer) {
    const Vec3 normal = normalized(Vec3{-0.2f, 0.9f, 0.4f});
    const auto samples = gaussSphere(500, 500);
    std::vector<double> moments(49), transfer(36);
    const auto cosine = [&](Vec3d s) { return dot(s, toDouble(normal)); };
    project(
        7, samples, [&](Vec3d s) { return cosine(s) > 0 ? 1.0 : 0.0; }, moments);
    project(
        6, samples, [&](Vec3d s) { return std::max(cosine(s), 0.0); }, transfer);
    const std::vector<float> b(moments.begin(), moments.end());
    std::vector<float> found(36);
    CosineProduct(6).apply(b, normal, found);
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], transfer[i], 2e-6) << i;
}

// An open point again: V = 1 has the coefficient sqrt(4 pi), and its transfer is that of the clamped cosine. And for
// any function the matrix does what the product with its moments over the hemisphere does.
TEST(CosineMatrix, TakesFunctionsToTransfer) {
    const double pi = std::numbers::pi;
    const std::vector<double> matrix = cosineMatrix(4, 5);
    const std::array<std::pair<int, double>, 4> open{
        {{0, std::sqrt(pi) / 2}, {2, std::sqrt(pi / 3)}, {6, std::sqrt(5 * pi) / 8}, {12, 0}}};
    for (const auto& [index, value] : open)
        EXPECT_NEAR(matrix[std::size_t(index) * 25] * std::sqrt(4 * pi), value, 1e-12) << index;
    std::vector<double> function(25), moments(25), y(25);
    for (std::size_t i = 0; i < function.size(); ++i) function[i] = std::cos(1.3 * double(i));
    for (const WeightedDirection& sample : gaussHemisphere(20, 40)) {
        evalBasis(5, sample.direction, std::span(y));
        double f = 0;
        for (std::size_t i = 0; i < y.size(); ++i) f += function[i] * y[i];
        for (std::size_t i = 0; i < y.size(); ++i) moments[i] += sample.weight * f * y[i];
    }
    const std::vector<float> b(moments.begin(), moments.end());
    std::vector<float> expected(16);
    CosineProduct(4).apply(b, {0, 0, 1}, expected);
    for (std::size_t i = 0; i < expected.size(); ++i) {
        double sum = 0;
        for (std::size_t j = 0; j < function.size(); ++j) sum += matrix[i * 25 + j] * function[j];
        EXPECT_NEAR(sum, expected[i], 2e-6) << i;
    }
}

// --- Fits -----------------------------------------------------------------------------------------------------------

constexpr std::size_t kRings = 5, kSides = 14, kFrames = 40;

// The transfer of a made character: a linear function of its angles, different for each vertex and coefficient.
float linearTransfer(std::span<const float> pose, std::size_t vertex, std::size_t coefficient) {
    double sum = 0.4 + 0.1 * std::sin(double(vertex + 3 * coefficient));
    for (std::size_t i = 0; i < pose.size(); ++i)
        sum += 0.1 * pose[i] * std::cos(double(i + 1) * (0.7 * double(vertex) + double(coefficient)));
    return float(sum);
}

// Writes two clips of a tube with four joints, of which the last never turns.
void writeTransferBake(const std::filesystem::path& path, int order, bool moving = true) {
    VisibilityHeader header;
    header.order = order;
    header.quantity = kDiffuseTransfer;
    header.mesh = synthetic::tube(kRings, kSides);
    header.skin = synthetic::chainSkin(header.mesh);
    header.rest_normals.assign(header.mesh.vertexCount(), {0, 1, 0});
    header.frames.clip_names = {"train", "test"};
    for (std::size_t f = 0; f < kFrames; ++f) {
        header.frames.clip.push_back(f >= kFrames - 8);
        header.frames.time.push_back(double(f));
    }
    header.pose_size = 12;
    VisibilityWriter writer(path, header, Precision::kFloat32);
    for (std::size_t f = 0; f < kFrames; ++f) {
        VisibilityFrame frame;
        frame.positions = header.mesh.rest_positions;
        frame.normals = header.rest_normals;
        frame.bones.assign(4, {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}});
        for (std::size_t i = 0; i < 12; ++i)
            frame.pose.push_back(i < 9 && moving ? float(std::sin(double((i + 2) * f) + double(i))) : 0.25f);
        for (std::size_t v = 0; v < header.mesh.vertexCount(); ++v)
            for (std::size_t c = 0; c < header.coefficientCount(); ++c)
                frame.coefficients.push_back(linearTransfer(frame.pose, v, c));
        writer.writeFrame(frame);
    }
    writer.finish();
}

TransferFitOptions linearOptions() {
    TransferFitOptions options;
    options.model = TransferModelKind::kLinear;
    options.order = 3;
    options.holdout = {"test"};
    return options;
}

TEST(FitTransfer, LinearTransferIsFoundExactly) {
    const TemporaryFile file("linear.vis.h5");
    writeTransferBake(file.path, 3);
    const VisibilityReader reader(file.path);
    TransferFitOptions options = linearOptions();
    for (const CrossValidation validation : kCrossValidations) {
        options.cross_validation = validation;
        const TransferFit fit = fitTransfer(reader, "x", options, {});
        EXPECT_EQ(fit.model.angles.size(), 9u);
        EXPECT_EQ(fit.model.pose.size(), 12 * kFrames);  // held-out frames are there for playback
        EXPECT_EQ(fit.model.bones.size(), 4 * kFrames);
        EXPECT_EQ(fit.report.constant_angles, 3u);
        EXPECT_EQ(fit.report.train_frames, kFrames - 8);
        EXPECT_LT(fit.report.train.relative_error, 1e-4);
        EXPECT_LT(fit.report.held_out.relative_error, 1e-4);
        EXPECT_LT(fit.report.leave_one_out_error, 1e-3);
        EXPECT_LT(fit.report.blocked_error, 1e-3);
    }
    options.prior = 0;
    EXPECT_LT(fitTransfer(reader, "x", options, {}).report.held_out.relative_error, 1e-4);
    options.prior = 1e4;
    EXPECT_GT(fitTransfer(reader, "x", options, {}).report.train.relative_error, 0.99);  // the mean alone
}

// With all components of angles and vertices, the reduced model is the linear one.
TEST(FitTransfer, AllComponentsGiveTheLinearModel) {
    const TemporaryFile file("pca.vis.h5");
    writeTransferBake(file.path, 3);
    const VisibilityReader reader(file.path);
    TransferFitOptions options = linearOptions();
    options.prior = 0.5;
    const TransferModel linear = fitTransfer(reader, "x", options, {}).model;
    options.model = TransferModelKind::kPca;
    options.pose_components = 9;
    options.vertex_components = kRings * kSides;
    const TransferFit fit = fitTransfer(reader, "x", options, {});
    EXPECT_NEAR(fit.report.pose_variance, 1, 1e-9);
    EXPECT_NEAR(fit.report.vertex_variance, 1, 1e-5);
    const std::vector<float> pose = reader.readPose(kFrames - 1).pose;
    const std::vector<float> a = predictTransfer(linear, pose, 1), b = predictTransfer(fit.model, pose, 2);
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 2e-4) << i;
}

TEST(FitTransfer, MoreComponentsFitBetter) {
    const TemporaryFile file("more.vis.h5");
    writeTransferBake(file.path, 3);
    const VisibilityReader reader(file.path);
    TransferFitOptions options = linearOptions();
    options.model = TransferModelKind::kPca;
    double before = 1;
    for (const auto& [k, m] : {std::pair<std::size_t, std::size_t>{2, 3}, {4, 8}, {8, 16}}) {
        options.pose_components = k;
        options.vertex_components = m;
        const double error = fitTransfer(reader, "x", options, {}).report.train.relative_error;
        EXPECT_LT(error, before) << k;
        before = error;
    }
}

TEST(ShadeTransfer, LightContractedFirstIsLightTimesTransfer) {
    const TemporaryFile file("lit.vis.h5");
    writeTransferBake(file.path, 3);
    const VisibilityReader reader(file.path);
    std::vector<float> light(3 * 9);
    for (std::size_t i = 0; i < light.size(); ++i) light[i] = float(std::sin(0.3 + double(i)));
    TransferFitOptions options = linearOptions();
    options.pose_components = 4;
    options.vertex_components = 12;
    for (const TransferModelKind kind : kTransferModelKinds) {
        options.model = kind;
        const TransferModel model = fitTransfer(reader, "x", options, {}).model;
        const std::vector<float> pose = reader.readPose(3).pose, transfer = predictTransfer(model, pose, 1);
        const std::size_t vertices = model.mesh.vertexCount();
        std::vector<float> shaded(3 * vertices);
        shadeTransfer(model, contractLight(model, light), pose, shaded);
        for (std::size_t v = 0; v < vertices; ++v)
            for (std::size_t channel = 0; channel < 3; ++channel) {
                double sum = 0;
                for (std::size_t c = 0; c < 9; ++c) sum += double(light[3 * c + channel]) * transfer[9 * v + c];
                ASSERT_NEAR(shaded[channel * vertices + v], sum, 2e-5) << nameOf(kind) << " " << v;
            }
    }
}

TEST(FitTransfer, SameForAnyNumberOfThreads) {
    const TemporaryFile file("threads.vis.h5");
    writeTransferBake(file.path, 3);
    const VisibilityReader reader(file.path);
    TransferFitOptions options = linearOptions();
    for (const TransferModelKind kind : kTransferModelKinds) {
        options.model = kind;
        options.vertex_components = 10;
        options.threads = 1;
        const TransferFit one = fitTransfer(reader, "x", options, {});
        options.threads = 8;
        const TransferFit eight = fitTransfer(reader, "x", options, {});
        EXPECT_EQ(one.model.weights, eight.model.weights);
        EXPECT_EQ(one.model.basis, eight.model.basis);
        EXPECT_EQ(one.report.held_out.transfer_error, eight.report.held_out.transfer_error);
    }
}

TEST(FitTransfer, RefusesWhatItCannotFit) {
    const TemporaryFile file("refused.vis.h5"), still("still.vis.h5");
    writeTransferBake(file.path, 3);
    writeTransferBake(still.path, 3, false);
    const VisibilityReader reader(file.path);
    const auto message = [](const VisibilityReader& from, const TransferFitOptions& options) -> std::string {
        try {
            (void)fitTransfer(from, "x.vis.h5", options, {});
        } catch (const UsageError& error) {
            return error.what();
        } catch (const InvalidInput& error) {
            return error.what();
        }
        return "";
    };
    TransferFitOptions options = linearOptions();
    EXPECT_EQ(message(reader, options), "");
    EXPECT_THAT(message(VisibilityReader(still.path), options), HasSubstr("all joint angles are constant"));
    options.order = 6;
    EXPECT_THAT(message(reader, options),
                HasSubstr("order: 6 needs diffuse_transfer of order 6; x.vis.h5 has order 3"));
    options.order = 3;
    options.holdout = {"nobody"};
    EXPECT_THAT(message(reader, options), HasSubstr("holdout: no clip 'nobody'"));
    options.holdout = {"train", "test"};
    EXPECT_THAT(message(reader, options), HasSubstr("no clip is left"));
    options.holdout = {"train"};
    options.model = TransferModelKind::kPca;
    options.vertex_components = 10;
    EXPECT_THAT(message(reader, options), HasSubstr("8 training frames, and 8 components of the angles need one more"));
    options.holdout = {"test"};
    options.pose_components = 10;
    EXPECT_THAT(message(reader, options), HasSubstr("9 joint angles that change"));
    options.pose_components = 8;
    options.vertex_components = 71;
    EXPECT_THAT(message(reader, options), HasSubstr("70 vertices"));
}

}  // namespace
}  // namespace penumbra::test_transfer_fit
