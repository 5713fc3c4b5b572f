#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fit/visibility/near_gains.h"
#include "sh/visibility_convention.h"
#include "tests/difference.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_near_gains {

using namespace synthetic;

namespace {

constexpr TubeOptions kTube{.joints = 5, .frames = 240};

// A composed tube without far parts, whose near parts count with gains at random.
struct Scene {
    Model model = composedTube(kTube, {.local_steps = kTube.joints});
    PoseTable poses;
    std::vector<PosedPart> posed;
    std::vector<std::size_t> train;
    std::vector<std::uint32_t> vertices;  // all of them
    std::vector<int> joints;              // joints of the clusters

    Scene() : vertices(model.mesh.vertexCount()) {
        std::iota(vertices.begin(), vertices.end(), 0u);
        for (const ClusterModel& cluster : model.clusters) joints.push_back(cluster.joint);
        turnJointsApart(model);
        addNearParts(model, 2);
        // Gains are found up to 1.5.
        for (std::uint8_t& gain : model.composition->near_gains) gain = std::min(gain, std::uint8_t(180));
        poses.joints = model.skin.jointCount();
        poses.bones = model.bones;
        for (std::size_t f = 0; f < poses.frameCount(); ++f)
            if (f % 4 != 3) train.push_back(f);
    }
    NearProblem problem(const FarTables& far) {
        posed.resize(poses.frameCount() * far.partCount());
        for (std::size_t f = 0; f < poses.frameCount(); ++f)
            poseParts(far.fields(), poses.bonesOf(f), std::span(posed).subspan(f * far.partCount(), far.partCount()));
        return {&far, &model, &poses, posed, joints, train};
    }
    VertexSet allVertices() const { return vertexSet(model, vertices, joints); }
};

// Multiplies numbers [F, V n] by the near parts.
void multiplyByNear(const NearProblem& problem, const VertexSet& vertices, MatrixF& coefficients) {
    std::vector<float> factors(vertices.part.size() * kFarCoefficients);
    const std::size_t parts = problem.far->partCount();
    for (std::size_t f = 0; f < coefficients.rows; ++f) {
        farFactors(*problem.far, vertices,
                   poseOfSet(vertices, *problem.poses, f, problem.posed.subspan(f * parts, parts)), factors);
        multiplyByFar(*problem.far, factors, coefficients.row(f));
    }
}

// Numbers of an open sky with some noise, the same in all frames.
MatrixF steadyCoefficients(std::size_t frames, std::size_t vertices, std::size_t size) {
    MatrixF coefficients(frames, vertices * size);
    Noise noise(41);
    for (std::size_t c = 0; c < coefficients.columns; ++c) {
        const float x = (c % size == 0 ? 2.5f : 0.0f) + 0.2f * noise();
        for (std::size_t f = 0; f < frames; ++f) coefficients(f, c) = x;
    }
    return coefficients;
}

// Sum over all frames of squared distances from the mean of the frames.
double variationOf(const MatrixF& coefficients) {
    const std::vector<double> mean = meanOfRows(coefficients, indices(coefficients.rows));
    double sum = 0;
    for (std::size_t f = 0; f < coefficients.rows; ++f)
        for (std::size_t c = 0; c < coefficients.columns; ++c) sum += std::pow(coefficients(f, c) - mean[c], 2);
    return sum;
}

double rmsDistance(std::span<const std::uint8_t> gains, std::span<const std::uint8_t> from) {
    RelativeRms rms;
    for (std::size_t i = 0; i < gains.size(); ++i) rms.add(gains[i], from[i]);
    return std::sqrt(rms.error / double(gains.size()));
}

// Binds a vertex to the center of the first near part of its part.
void buryInNearPart(Model& model, std::uint32_t v) {
    const Composition& composition = *model.composition;
    const std::size_t near = composition.near_parts[composition.part_of_vertex[v] * composition.near_count];
    const PartField& part = composition.fields.parts[near];
    const auto influences = std::size_t(model.skin.influences);
    model.mesh.rest_positions[v] = part.center;
    for (std::size_t i = 0; i < influences; ++i) {
        model.skin.joints[v * influences + i] = std::uint16_t(part.joint);
        model.skin.weights[v * influences + i] = i == 0 ? 1.0f : 0.0f;
    }
}

}  // namespace

// Geometry is exact here: every vertex has the same numbers in all poses, and rigid parts hide it by known gains.
TEST(NearGains, ComeBackFromWhatVerticesSee) {
    Scene scene;
    const FarTables far = makeFarTables(*scene.model.composition, scene.model.convention);
    const NearProblem problem = scene.problem(far);
    VertexSet vertices = scene.allVertices();
    MatrixF local =
        steadyCoefficients(scene.poses.frameCount(), scene.vertices.size(), std::size_t(scene.model.convention.size()));
    multiplyByNear(problem, vertices, local);

    MatrixF coefficients = local;
    const std::vector<std::uint8_t> found = takeOutNearParts(problem, scene.vertices, coefficients);
    ASSERT_EQ(found.size(), vertices.gains.size());
    const std::vector<std::uint8_t> ones(found.size(), std::uint8_t(1 / kPerGain));
    EXPECT_LT(rmsDistance(found, vertices.gains), 0.5 * rmsDistance(ones, vertices.gains));
    EXPECT_LT(variationOf(coefficients), 0.1 * variationOf(local));
    vertices.gains = found;
    multiplyByNear(problem, vertices, coefficients);
    EXPECT_LT(largestDifference(coefficients.values, local.values), 0.1);
}

// A vertex that no training frame shows because it lies inside of another part has the whole sky, so that it is seen
// when it comes out. One that is dark for other reasons, or that some frame shows, stays as it was learned.
TEST(NearGains, VerticesThatPartsAlwaysHideHaveTheWholeSky) {
    constexpr std::uint32_t kVertex = 3;
    Scene scene;
    const FarTables far = makeFarTables(*scene.model.composition, scene.model.convention);
    const auto n = std::size_t(scene.model.convention.size());
    std::vector<float> ambient(n);
    ambientWeights(scene.model.convention, ambient);
    const MatrixF dark(scene.poses.frameCount(), scene.vertices.size() * n);
    EXPECT_FALSE(hiddenByParts(scene.problem(far), scene.vertices, dark, ambient)[kVertex]);

    buryInNearPart(scene.model, kVertex);
    const NearProblem problem = scene.problem(far);
    std::vector<bool> hidden = hiddenByParts(problem, scene.vertices, dark, ambient);
    EXPECT_TRUE(hidden[kVertex]);
    MatrixF seen = dark;
    seen(scene.train.back(), kVertex * n) = 2.5f;
    hidden[kVertex] = false;  // the others stay as they are
    EXPECT_EQ(hiddenByParts(problem, scene.vertices, seen, ambient), hidden);

    hidden.assign(hidden.size(), false);
    hidden[kVertex] = true;
    std::vector<std::uint8_t> gains(2 * hidden.size(), 7);
    MatrixF coefficients = dark;
    openHidden(hidden, gains, coefficients);
    EXPECT_EQ(gains[2 * kVertex], std::uint8_t(1 / kPerGain));
    EXPECT_EQ(gains[2 * kVertex + 1], std::uint8_t(1 / kPerGain));
    EXPECT_EQ(std::count(gains.begin(), gains.end(), 7), std::ptrdiff_t(gains.size() - 2));
    for (std::size_t f = 0; f < coefficients.rows; ++f) {
        const std::span<const float> row = coefficients.row(f);
        EXPECT_NEAR(std::inner_product(ambient.begin(), ambient.end(), &row[kVertex * n], 0.0f), 1, 0.01);
        EXPECT_EQ(std::count(row.begin(), row.end(), 0.0f), std::ptrdiff_t(row.size() - 1));
    }
}

}  // namespace penumbra::test_near_gains
