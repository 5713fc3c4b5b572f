#include <gtest/gtest.h>

#include <cmath>

#include "fit/numerics/pca.h"
#include "fit/papers/compare/compare_grid.h"
#include "fit/papers/compare/eigenvalue_decay.h"
#include "fit/papers/compare/joint_sweep.h"
#include "tests/fit/compared_character.h"

namespace penumbra::test_compare {
namespace {

TEST(CompareGrid, HoldsEachFitOnceAndAllThatTheFiguresAskFor) {
    CompareOptions options;
    options.models = {ModelKind::kLinear};
    options.conventions = {parseConvention("A4"), parseConvention("D5")};
    const std::vector<FitOptions> grid = makeGrid(options, 5);
    for (std::size_t i = 0; i < grid.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) EXPECT_FALSE(sameFit(grid[i], grid[j]));
    }
    // For each of the features: clusters, variances, D5, and the papers' way plain, with the cosine and in the model
    // frame.
    EXPECT_EQ(grid.size(), 2 * (4 + 3 + 1 + 3u));
    EXPECT_EQ(options.referenceClusters(), 32);
    EXPECT_EQ(options.referenceVariance(), 0.95);
}

TEST(CompareGrid, FieldsAddAComposedModelAndTheAdditiveOneBesideIt) {
    CompareOptions options;
    options.models = {ModelKind::kLinear};
    options.conventions = {parseConvention("A4"), parseConvention("D3")};
    const std::size_t without = makeGrid(options, 5).size();
    options.fields.resize(1);
    const std::vector<FitOptions> grid = makeGrid(options, 5);
    ASSERT_EQ(grid.size(), without + 2);
    EXPECT_TRUE(sameFit(grid[without], mirroredAdditiveFit(options, 5)));
    EXPECT_TRUE(sameFit(grid[without + 1], composedFit(options, 5)));
    EXPECT_FALSE(sameFit(grid[without], grid[without + 1]));
    EXPECT_EQ(grid[without + 1].convention, parseConvention("D3")) << "the first mirrored one of the list";
    EXPECT_EQ(labelOf(grid[without + 1]), "composed, additive, D3");
    options.conventions = {parseConvention("A4")};
    EXPECT_EQ(composedFit(options, 4).convention, parseConvention("D4")) << "no more than the file has";
    // Where the additive model is in the grid anyway, it is there once.
    options.models = {ModelKind::kAdditive};
    options.conventions = {parseConvention("D5")};
    const std::size_t with = makeGrid(options, 5).size();
    options.fields.clear();
    EXPECT_EQ(with, makeGrid(options, 5).size() + 1);
}

// The cosine takes moments of one order more than it has numbers.
TEST(CompareGrid, NeverAsksForMomentsThatTheFileLacks) {
    CompareOptions options;
    options.conventions = {parseConvention("D4")};
    for (int file_order : {4, 5, 8})
        for (const FitOptions& fit : makeGrid(options, file_order)) {
            EXPECT_LE(fit.convention.order + fit.form->more_bands, file_order) << describe(fit);
        }
}

TEST(EigenvalueDecay, OfAllVerticesIsThatOfTheWholeMatrix) {
    const ComparedCharacter c("decay.vis.h5", "A3");
    const std::vector<EigenvalueDecay> decays = outputDecays(c.input, c.character, c.options, {});
    ClusterCoefficientsRequest request;
    request.convention = c.options.referenceConvention();
    request.frames = c.character.frames();
    std::vector<std::vector<std::uint32_t>> all(1);
    for (std::uint32_t v = 0; v < c.reader.header().mesh.vertexCount(); ++v) all[0].push_back(v);
    request.vertices_of_cluster = all;
    const MatrixF coefficients = readClusterCoefficients(c.reader, c.poses, request)[0];
    const std::vector<double> mean = meanOfRows(coefficients, c.character.train);
    Matrix centered(c.character.train.size(), coefficients.columns);
    for (std::size_t r = 0; r < centered.rows; ++r)
        for (std::size_t i = 0; i < centered.columns; ++i)
            centered(r, i) = double(coefficients(c.character.train[r], i)) - mean[i];
    const Pca pca = principalComponents(centered);
    ASSERT_GE(decays[0].shares.size(), pca.energies.size());
    for (std::size_t k = 0; k < pca.energies.size(); ++k)
        EXPECT_NEAR(decays[0].shares[k], pca.energies[k] / pca.total, 1e-9) << k;  // 1.9e-10 measured
    EXPECT_EQ(decays[0].componentsFor(0.9), componentsFor(pca, 0.9));
    EXPECT_EQ(decays[0].componentsFor(0.99), componentsFor(pca, 0.99));
}

// Nowrouzezahrai 2007, section 5: a row for each training pose and each number, with one column a vertex.
TEST(EigenvalueDecay, OfRowsOfVerticesIsThatOfTheLinearModels) {
    const ComparedCharacter c("stacked.vis.h5", "A3");
    const EigenvalueDecay decay = outputDecays(c.input, c.character, c.options, {})[1];
    ClusterCoefficientsRequest request;
    request.convention = c.options.referenceConvention();
    request.frames = c.character.frames();
    std::vector<std::vector<std::uint32_t>> all(1);
    for (std::uint32_t v = 0; v < c.reader.header().mesh.vertexCount(); ++v) all[0].push_back(v);
    request.vertices_of_cluster = all;
    const MatrixF coefficients = readClusterCoefficients(c.reader, c.poses, request)[0];
    const std::size_t n = std::size_t(request.convention.size());
    Matrix rows(c.character.train.size() * n, all[0].size());
    for (std::size_t r = 0; r < rows.rows; ++r)
        for (std::size_t v = 0; v < rows.columns; ++v)
            rows(r, v) = coefficients(c.character.train[r / n], v * n + r % n);
    std::vector<std::size_t> every(rows.rows);
    for (std::size_t r = 0; r < every.size(); ++r) every[r] = r;
    const Pca pca = principalComponents(centeredRows(rows, every, meanOfRows(rows, every)));
    for (std::size_t k = 0; k < 10; ++k)
        EXPECT_NEAR(decay.shares[k], pca.energies[k] / pca.total, 1e-4 * pca.energies[k] / pca.total) << k;
    EXPECT_EQ(decay.componentsFor(0.9), componentsFor(pca, 0.9));
}

TEST(EigenvalueDecay, SharesAddUpToOne) {
    const ComparedCharacter c("shares.vis.h5", "A3");
    std::vector<EigenvalueDecay> decays = inputDecays(c.input, c.character);
    for (EigenvalueDecay& decay : outputDecays(c.input, c.character, c.options, {})) decays.push_back(decay);
    ASSERT_EQ(decays.size(), 5u);
    for (std::size_t i = 0; i < decays.size(); ++i) {
        const EigenvalueDecay& decay = decays[i];
        double sum = 0;
        for (double share : decay.shares) sum += share;
        // The stacked rows are multiplied as floats: 2.5e-7 measured.
        EXPECT_NEAR(sum, 1, i == 3 ? 1e-6 : 1e-9) << decay.name;
        EXPECT_TRUE(decay.reaches(0.99)) << decay.name;
        EXPECT_EQ(decay.componentsFor(1e-12), 1u);
    }
}

TEST(EigenvalueDecay, ReachesOnlyWhatTheKnownComponentsHave) {
    const EigenvalueDecay decay{"", {0.5, 0.25, 0.125}};
    EXPECT_TRUE(decay.reaches(0.875));
    EXPECT_FALSE(decay.reaches(0.9));
    EXPECT_EQ(decay.componentsFor(0.9), 3u);
}

TEST(Eigenvalues, OfADiagonalMatrixAreItsEntries) {
    Matrix m(3, 3);
    m(0, 0) = 2;
    m(1, 1) = 7;
    m(2, 2) = -1;  // counts as zero
    const std::vector<double> values = eigenvalues(m);
    EXPECT_NEAR(values[0], 7, 1e-12);
    EXPECT_NEAR(values[1], 2, 1e-12);
    EXPECT_EQ(values[2], 0);
}

// Measured errors: pivots 1.3e-8, bones 1.8e-7, pose 6e-8. The joints of the tube sit at y = 0, 0.5, 1, 1.5, and a pose
// vector consists of their rotation vectors.
TEST(JointTurn, FindsTheJointAndTurnsItAlone) {
    const ComparedCharacter c("turn.vis.h5", "A3");
    for (int joint : {1, 2, 3}) {
        const JointTurn turn = makeJointTurn(c.input, c.character, joint);
        EXPECT_NEAR(turn.pivot.x, 0, 1e-7) << joint;
        EXPECT_NEAR(turn.pivot.y, 0.5 * joint, 1e-7) << joint;
        EXPECT_NEAR(turn.pivot.z, 0, 1e-7) << joint;
        for (double angle : {turn.base_angle, turn.base_angle - 0.7, turn.base_angle + 0.4}) {
            const TurnedPose turned = poseAt(c.input, turn, angle);
            Affine parent;
            for (int j = 0; j < 4; ++j) {
                const float* w = c.poses.poseOf(turn.base_frame).data() + 3 * j;
                Vec3 rotation{w[0], w[1], w[2]};
                if (j == joint) rotation += toFloat(turn.axis * (angle - turn.base_angle));
                const Mat3 r = synthetic::rotationAbout(rotation, length(rotation));
                const Vec3 pivot{0, 0.5f * float(j), 0};
                parent = synthetic::compose(parent, synthetic::affine(r, pivot - r * pivot));
                for (std::size_t i = 0; i < 12; ++i)
                    EXPECT_NEAR(turned.bones[std::size_t(j)].m[i], parent.m[i], 1e-6)
                        << "joint " << j << " entry " << i;
                for (int i = 0; i < 3; ++i)
                    EXPECT_NEAR(turned.pose[std::size_t(3 * j + i)], rotation[i], 3e-7) << "joint " << j;
            }
        }
    }
}

TEST(JointTurn, RelativeRotationsAreThePoseVector) {
    const ComparedCharacter c("relative.vis.h5", "A3");
    const std::vector<Vec3d> rotations = relativeRotations(c.poses, c.reader.header().skin->parents);
    for (std::size_t f = 0; f < c.poses.frameCount(); ++f)
        for (std::size_t j = 1; j < 4; ++j)
            for (int i = 0; i < 3; ++i)
                EXPECT_NEAR(rotations[4 * f + j][i], c.poses.poseOf(f)[3 * j + std::size_t(i)], 5e-7)
                    << f << " " << j;  // 1e-7
}

TEST(JointSweep, CoversTheBakedAnglesAndGivesTheModelsOwnValueThere) {
    const ComparedCharacter c("sweep.vis.h5", "A3");
    const std::optional<JointSweep> sweep = findJointSweep(c.input, c.character, c.options);
    ASSERT_TRUE(sweep);
    EXPECT_GT(sweep->explained, 0);
    EXPECT_LE(sweep->explained, 1);
    EXPECT_EQ(sweep->baked_angles.size(), c.poses.frameCount());
    for (double angle : sweep->baked_angles) {
        EXPECT_GE(angle, sweep->angles.front());
        EXPECT_LE(angle, sweep->angles.back());
    }
    // An exact model gives the base frame's E at the base frame's angle (6e-8 measured).
    FitOptions options = referenceFit(c.options, ModelKind::kLinear, FeatureKind::kRelativeBones);
    options.input_variance = options.output_variance = 1;
    const FitResult fit = fitVisibility(c.reader, c.poses, "sweep", options, {});
    JointSweep at_base = *sweep;
    at_base.angles = {sweep->turn.base_angle};
    EXPECT_NEAR(sweepAmbient(c.input, at_base, fit.model)[0], sweep->baked_ambient[sweep->turn.base_frame], 1e-6);
}

}  // namespace
}  // namespace penumbra::test_compare
