#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "formats/common/errors.h"
#include "pack/border_corners.h"
#include "pack/pack_asset.h"
#include "pack/resample_model.h"
#include "runtime/evaluate/evaluator.h"
#include "sh/sh_rotation.h"
#include "tests/synthetic_composition.h"
#include "tests/synthetic_model.h"

namespace penumbra::test_resample_model {
namespace {

DrawnMesh itself(const Model& model) {
    DrawnMesh drawn{model.mesh, model.skin, model.rest_normals, {}, {}};
    for (std::uint32_t v = 0; v < model.mesh.vertexCount(); ++v) {
        drawn.points.corners.push_back({v, v, v});
        drawn.points.weights.push_back({1, 0, 0});
    }
    return drawn;
}

// The rotation of SH is the closed form of a turn about z.
TEST(Turn, IsTheRotationAboutTheNormal) {
    const Convention b = parseConvention("B5");
    const TurnTable turns = turnsOf(b);
    const double angle = 0.7;
    const Mat3 about_z{{float(std::cos(angle)), -float(std::sin(angle)), 0, float(std::sin(angle)),
                        float(std::cos(angle)), 0, 0, 0, 1}};
    const ShRotation rotation = makeShRotation(5, about_z);
    synthetic::Noise noise(2);
    std::vector<float> in, turned(25), rotated(25);
    synthetic::fillNoise(in, 25, 1, noise);
    apply(makeTurn(turns, angle), in, turned);
    apply(rotation, in, rotated);
    for (std::size_t i = 0; i < 25; ++i) EXPECT_NEAR(turned[i], rotated[i], 1e-6) << i;
}

// A tangent that stands 90 degrees about the normal from another one.
TEST(Turn, AnglesGoFromTheSecondTangentAboutTheNormal) {
    EXPECT_NEAR(angleBetween({0, 0, 1}, {0, 1, 0}, {1, 0, 0}), std::acos(0.0), 1e-6);
}

TEST(ResampleModel, AMeshThatIsTheFittedOneChangesNothing) {
    for (const char* convention : {"A4", "D5"}) {
        const Model model = synthetic::tubeModel({.convention = parseConvention(convention)});
        const Resampled same = resampledModel(model, itself(model), 1);
        EXPECT_EQ(same.border_corners, 0u);
        ASSERT_EQ(same.model.clusters.size(), model.clusters.size());
        for (std::size_t c = 0; c < model.clusters.size(); ++c) {
            const ClusterModel &a = model.clusters[c], &b = same.model.clusters[c];
            EXPECT_EQ(a.vertices, b.vertices);
            ASSERT_EQ(a.basis.size(), b.basis.size());
            for (std::size_t i = 0; i < a.mean.size(); ++i) EXPECT_NEAR(a.mean[i], b.mean[i], 1e-6);
            for (std::size_t i = 0; i < a.basis.size(); ++i) EXPECT_NEAR(a.basis[i], b.basis[i], 1e-6);
        }
    }
}

// A point halfway between two of one cluster has the mean of their numbers, turned to its tangent.
TEST(ResampleModel, PointsBetweenInterpolate) {
    Model model = synthetic::tubeModel({.clusters = 1});
    DrawnMesh drawn = itself(model);
    const std::uint32_t a = 0, b = 5;  // one above the other: the same normal
    ASSERT_EQ(model.rest_normals[a], model.rest_normals[b]);
    drawn.points.corners[a] = {a, b, b};
    drawn.points.weights[a] = {0.5f, 0.5f, 0};
    const Resampled half = resampledModel(model, drawn, 1);
    const std::size_t n = std::size_t(model.convention.size());
    const std::vector<float>&from = model.clusters[0].mean, &to = half.model.clusters[0].mean;
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(to[a * n + i], (from[a * n + i] + from[b * n + i]) / 2, 1e-6);
}

// Gains are interpolated between points of one part. Over a border a point says 1 for what is far from it, and nothing
// for its own part.
TEST(ResampleModel, GainsInterpolate) {
    Model model = synthetic::composedTube();
    synthetic::addNearParts(model, 2);
    Composition& composition = *model.composition;
    std::vector<std::uint32_t> of_part(composition.fields.parts.size());  // one vertex of each
    for (std::uint32_t v = 0; v < model.mesh.vertexCount(); ++v) of_part[composition.part_of_vertex[v]] = v;
    const std::uint32_t own = of_part[2], beside = of_part[3];
    std::uint32_t other = 0;  // another vertex of part 2
    while (composition.part_of_vertex[other] != 2 || other == own) ++other;
    DrawnMesh drawn = itself(model);
    drawn.points.corners[own] = {own, other, beside};
    drawn.points.weights[own] = {0.5f, 0.25f, 0.25f};
    const auto set = [&](std::uint32_t v, std::uint8_t a, std::uint8_t b) {
        composition.near_gains[2 * v] = a;
        composition.near_gains[2 * v + 1] = b;
    };
    // The near parts of 2 are 1 and 3. For part 3 they are 2 and 4, and part 1 is far.
    set(own, 40, 100);
    set(other, 80, 40);
    set(beside, 7, 7);
    const Model resampled = resampledModel(model, drawn, 1).model;
    const std::vector<std::uint8_t>& gains = resampled.composition->near_gains;
    ASSERT_EQ(gains.size(), composition.near_gains.size());
    EXPECT_EQ(gains[2 * own], (2 * 40 + 80 + 128) / 4);
    EXPECT_EQ(gains[2 * own + 1], (2 * 100 + 40) / 3);
    EXPECT_EQ(gains[2 * other], 80);
}

// Where two clusters have the same regression, a vertex of one is expressed exactly by the scores of the other, up to
// the ridge (1e-4).
TEST(BorderCorners, AreWhatTheirOwnClusterPredicts) {
    Model model = synthetic::tubeModel({.clusters = 2, .frames = 60});
    ClusterModel copy = model.clusters[0];
    copy.vertices = model.clusters[1].vertices;
    copy.mean = model.clusters[1].mean;
    copy.basis = model.clusters[1].basis;
    model.clusters[1] = copy;
    const std::uint32_t vertex = model.clusters[1].vertices[2];
    const std::vector<BorderCorner> corners{{0, vertex}};
    const std::vector<float> rows = borderRows(model, corners, 1)[0][0];
    const std::size_t n = std::size_t(model.convention.size()), count = copy.vertices.size();
    ASSERT_EQ(rows.size(), (1 + copy.components()) * n);
    PackOptions exact;
    exact.precision = AssetPrecision::kF32;
    const std::vector<std::byte> bytes = packAsset(model, {}, {}, exact, "{}", 1).bytes;
    const AssetView asset = openAsset(bytes);
    Evaluator evaluator(asset);
    double error = 0, signal = 0;
    for (std::size_t f = 0; f < 30; f += 3) {  // the first clip, which is not held out
        evaluator.setFrame(f);
        for (std::size_t i = 0; i < n; ++i) {
            double own = copy.mean[2 * n + i], here = rows[i];
            for (std::size_t k = 0; k < copy.components(); ++k) {
                const double y = evaluator.scores(0)[k];
                own += y * copy.basis[(k * count + 2) * n + i];
                here += y * rows[(1 + k) * n + i];
            }
            error += (own - here) * (own - here);
            signal += (own - copy.mean[2 * n + i]) * (own - copy.mean[2 * n + i]);
        }
    }
    EXPECT_LT(std::sqrt(error / signal), 1e-2);
}

}  // namespace
}  // namespace penumbra::test_resample_model
