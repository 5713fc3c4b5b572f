#include <gtest/gtest.h>

#include <cmath>

#include "bake/reference/bake_reference.h"
#include "bake/reference/posed_tangents.h"
#include "formats/common/errors.h"
#include "tests/bake/shapes.h"
#include "tests/synthetic_cloth.h"

namespace penumbra::test_posed_tangents {
namespace {

// A square in the plane z = 0 of two clusters, each with a joint of its own. Rest tangents are x and y.
struct TwoClusters {
    Model model;
    VisibilityFrame frame;

    TwoClusters() {
        Mesh& mesh = model.mesh;
        mesh.rest_positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
        mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
        model.skin.joint_names = {"a", "b"};
        model.cluster_of_vertex = {0, 1, 1, 0};
        model.clusters.resize(2);
        model.clusters[1].joint = 1;
        model.rest_tangents = {{1, 0, 0}, {0, 1, 0}, {0, 1, 0}, {1, 0, 0}};
        frame.positions = mesh.rest_positions;
        frame.normals.assign(4, {0, 0, 1});
        frame.bones.resize(2);
    }
    PosedTangents tangents() const { return posedTangents(model, model.mesh, frame, "x.model.h5"); }
};

// Joint b turns by 90 degrees about z and stretches. Joint a turns by 0.1 about x, which tilts its tangent out of the
// tangent plane, so that projection must bring it back.
TEST(PosedTangents, FollowTheJointsRotationAndStayInTheTangentPlane) {
    TwoClusters scene;
    const float c = std::cos(0.1f), s = std::sin(0.1f);
    scene.frame.bones[0].m = {c, 0, s, 0, 0, 1, 0, 0, -s, 0, c, 0};
    scene.frame.bones[1].m = {0, -3, 0, 5, 2, 0, 0, 0, 0, 0, 1, 0};
    const PosedTangents posed = scene.tangents();
    for (const std::size_t v : {0u, 3u}) EXPECT_NEAR(length(posed.tangents[v] - Vec3{1, 0, 0}), 0, 1e-6);
    for (const std::size_t v : {1u, 2u}) EXPECT_NEAR(length(posed.tangents[v] - Vec3{-1, 0, 0}), 0, 1e-6);
    EXPECT_EQ(posed.cluster_of_vertex, scene.model.cluster_of_vertex);
}

TEST(PosedTangents, TangentAlongTheNormalBecomesTheAxisLeastAlongIt) {
    TwoClusters scene;
    scene.frame.normals.assign(4, {1, 0, 0});
    EXPECT_EQ(scene.tangents().tangents[0], (Vec3{0, 1, 0}));
}

TEST(PosedTangents, ModelOfAnotherMeshOrSkinIsRefused) {
    TwoClusters scene;
    Mesh other = scene.model.mesh;
    other.rest_positions[2].x = 2;
    EXPECT_THROW(posedTangents(scene.model, other, scene.frame, "x"), InvalidInput);
    scene.frame.bones.resize(1);
    EXPECT_THROW(scene.tangents(), InvalidInput);
}

// A sheet without a skeleton turns as a whole, and the tangents of both its sides turn with it.
TEST(PosedTangents, SheetsCarryTheirTangents) {
    const Model model = synthetic::clothModel();
    const Mat3 turn = nearestRotation({{0.3f, -0.8f, 0.5f, 0.9f, 0.4f, 0.1f, -0.2f, 0.5f, 0.8f}});
    VisibilityFrame frame;
    for (std::size_t v = 0; v < model.mesh.vertexCount(); ++v) {
        frame.positions.push_back(turn * model.mesh.rest_positions[v] + Vec3{3, -1, 2});
        frame.normals.push_back(turn * model.rest_normals[v]);
    }
    const PosedTangents posed = posedTangents(model, model.mesh, frame, "x");
    ASSERT_EQ(posed.tangents.size(), model.mesh.vertexCount());
    for (std::size_t v = 0; v < posed.tangents.size(); ++v)  // measured 4e-6: the fit leaves a prior's turn
        EXPECT_LT(length(posed.tangents[v] - turn * model.rest_tangents[v]), 3e-5f) << v;
}

// A bake of a rig knows the bones of its joints, but not those that stand for inputs.
TEST(PosedTangents, InputsOfARigAreNoJointsOfItsFrames) {
    TwoClusters scene;
    scene.model.skin.joint_names.push_back("ball");
    scene.model.input_joints = {{2, 0, 3, 0, 1}};
    EXPECT_EQ(scene.tangents().tangents, scene.model.rest_tangents);
}

// The square is seen from above, with a light from the side. Brushed along x it looks different from brushed along y,
// and each half of the picture, which is nearest to the corners of one cluster, shows its own.
TEST(PosedTangents, PictureShowsTheTangentsOfTheNearestCornersCluster) {
    const TwoClusters scene;
    const PosedTangents posed = scene.tangents();
    Image sky{8, 4, std::vector<Vec3>(32), {}};
    for (std::size_t x = 3; x < 5; ++x) sky.pixels[8 + x] = sky.pixels[16 + x] = {1, 1, 1};
    const EnvironmentLight light = EnvironmentLight::fromMap({MapLayout::kLatLong, sky, 0, 0, {}});
    const Camera camera = makeCamera("", scene.frame.positions, 1);
    const auto render = [&](const char* spec, const PosedTangents* tangents) {
        ReferenceOptions options{.brdfs = {rgbBrdf(parseBrdf(spec))}, .width = 16, .height = 16, .samples = 1024};
        options.camera_rays = 1;
        return renderReference({scene.model.mesh, scene.frame, false, {}, tangents}, camera, light, options, 2,
                               ProgressStyle::kNone);
    };
    // The stand-in tangent of this normal is x, so exchanging ax and ay turns by 90 degrees.
    const Image both = render("ward-gmd:ax=0.1,ay=0.6", &posed), along_x = render("ward-gmd:ax=0.1,ay=0.6", nullptr),
                along_y = render("ward-gmd:ax=0.6,ay=0.1", nullptr);
    const std::size_t left = 16 * 8 + 5, right = 16 * 8 + 10;
    ASSERT_EQ(both.alpha[left] + both.alpha[right], 2);
    EXPECT_NEAR(both.pixels[left].x / along_x.pixels[left].x, 1, 0.03);
    EXPECT_NEAR(both.pixels[right].x / along_y.pixels[right].x, 1, 0.03);
    EXPECT_GT(std::abs(along_y.pixels[right].x / along_x.pixels[right].x - 1), 0.2);
}

// Each vertex has a material, so the picture's halves have their own colours.
TEST(Reference, EachVertexHasItsMaterial) {
    const TwoClusters scene;
    const Camera camera = makeCamera("", scene.frame.positions, 1);
    const std::vector<std::uint16_t> brdf_of_vertex = {0, 1, 1, 0};
    ReferenceOptions options{
        .brdfs = {rgbBrdf(parseBrdf("lambert:color=1/0/0")), rgbBrdf(parseBrdf("lambert:color=0/1/0"))},
        .width = 16,
        .height = 16};
    const Image image = renderReference({scene.model.mesh, scene.frame, false, brdf_of_vertex}, camera,
                                        EnvironmentLight::white(), options, 2, ProgressStyle::kNone);
    const Vec3 left = image.pixels[16 * 8 + 5], right = image.pixels[16 * 8 + 10];
    EXPECT_GT(left.x, 0.9);
    EXPECT_EQ(left.y, 0);
    EXPECT_GT(right.y, 0.9);
    EXPECT_EQ(right.x, 0);
}

}  // namespace
}  // namespace penumbra::test_posed_tangents
