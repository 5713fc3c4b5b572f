// Tests the local moments: what a vertex sees when only nearby parts of its skeleton block rays.
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "bake/visibility/bake_visibility.h"
#include "bake/visibility/frame_scene.h"
#include "formats/common/errors.h"
#include "tests/bake/shapes.h"
#include "tests/bake/sheets.h"

namespace penumbra::test_local_moments {
namespace {

std::filesystem::path sample(const std::string& name) {
    return std::filesystem::path(PENUMBRA_BINARY_DIR) / ".." / "samples" / name;
}

// One frame of a bake in memory, with all that traced it.
struct Baked {
    BakePlan plan;
    BakeDirections directions;
    FrameScene posed;
    MomentTracer tracer;
    std::vector<float> whole, local;

    Baked(const std::string& rig, const BakeOptions& options, std::size_t frame)
        : plan(planBake({sample(rig)}, options)),
          directions(makeBakeDirections(options)),
          posed(frameScene(plan, frame)),
          tracer(tracerOf(plan, posed, directions)) {
        traceMoments(tracer, posed.frame.positions, posed.frame.normals, outputOf(posed.frame));
        whole = posed.frame.coefficients;
        local = posed.frame.local_coefficients;
    }
};

// The man squats at half a second: his arms and legs shade one another.
BakeOptions squat(int steps, int order = 5) {
    BakeOptions options;
    options.rays = 128;
    options.fps = 2;
    options.clips = {"squat"};
    options.local = LocalMoments{order, steps};
    return options;
}

// Counts the vertices whose local visibility is larger than the whole one.
std::size_t countLarger(const Baked& baked) {
    std::size_t larger = 0;
    const std::size_t n2 = baked.plan.header.coefficientCount(), m2 = baked.plan.header.local->coefficientCount();
    for (std::size_t v = 0; v < baked.posed.frame.positions.size(); ++v)
        larger += baked.local[v * m2] > baked.whole[v * n2];
    return larger;
}

TEST(LocalMoments, AreTheWholeWhereAllPartsAreLocal) {
    for (const bool two_sided : {false, true}) {
        BakeOptions options = squat(8);
        options.two_sided = two_sided;
        const Baked baked("capsule_man.glb", options, 3);
        const std::vector<std::uint8_t>& is_local = baked.plan.local->is_local;
        // Everything but the column of the occluders, of which there are none.
        ASSERT_EQ(std::size_t(std::count(is_local.begin(), is_local.end(), 1)),
                  is_local.size() / baked.plan.local->row * (baked.plan.local->row - 1));
        EXPECT_EQ(baked.local, baked.whole);
    }
}

TEST(LocalMoments, LeaveTheWholeAsItIs) {
    for (const bool two_sided : {false, true}) {
        BakeOptions options = squat(1, 6);
        options.two_sided = two_sided;
        const Baked with("capsule_man.glb", options, 3);
        options.local.reset();
        const Baked without("capsule_man.glb", options, 3);
        EXPECT_EQ(with.whole, without.whole);
        EXPECT_TRUE(without.local.empty());
    }
}

TEST(LocalMoments, AreNeverBelowTheWhole) {
    for (const int steps : {1, 2}) {
        const Baked baked("capsule_man.glb", squat(steps), 3);
        const LocalTracer& local = *baked.tracer.local;
        const RayDirections& directions = baked.directions.whole;
        std::vector<LaneWeights> rays(directions.packets.size()), near(rays), plain(rays);
        std::size_t more = 0;
        for (std::size_t v = 0; v < baked.posed.frame.positions.size(); v += 7) {
            const Vec3 normal = baked.posed.frame.normals[v];
            const Vec3 origin = baked.posed.scale.apply(baked.posed.frame.positions[v]) + normal * 1e-4f;
            aboveHorizon(directions, normal, Floor::kNone, rays);
            near = plain = rays;
            baked.posed.scene.removeOccluded(origin, directions, plain);
            baked.posed.scene.removeOccludedLocally(origin, directions, local.parts.ofVertex(v, local.part_boxes), rays,
                                                    near);
            for (std::size_t p = 0; p < rays.size(); ++p) {
                EXPECT_EQ(rays[p].lane, plain[p].lane);
                for (std::size_t k = 0; k < kLanes; ++k) {
                    EXPECT_GE(near[p].lane[k], rays[p].lane[k]);
                    more += near[p].lane[k] > rays[p].lane[k];
                }
            }
        }
        EXPECT_GT(more, 500u) << steps;
        EXPECT_GT(countLarger(baked), 300u);
    }
}

// The local triangles of a vertex are a mesh of their own here, with a tree of its own.
std::vector<float> momentsOfLocalMesh(const Baked& baked, std::size_t vertex) {
    const LocalTracer& local = *baked.tracer.local;
    const LocalTriangles triangles = local.parts.ofVertex(vertex, local.part_boxes);
    std::vector<Triangle> kept;
    for (std::uint32_t t = 0; t < baked.plan.blockers.triangles.size(); ++t)
        if (triangles.contains(t)) kept.push_back(baked.plan.blockers.triangles[t]);
    std::vector<Vec3> scaled = baked.posed.frame.positions;
    for (Vec3& p : scaled) p = baked.posed.scale.apply(p);
    const OcclusionScene scene(scaled, kept);
    std::vector<float> b(local.directions.basis.size() / local.directions.packets.size() / kLanes);
    traceMoments({scene, local.directions, baked.posed.scale, 1e-4f}, {&baked.posed.frame.positions[vertex], 1},
                 {&baked.posed.frame.normals[vertex], 1}, {b});
    return b;
}

TEST(LocalMoments, AreThoseOfTheLocalTrianglesAlone) {
    for (const int steps : {1, 2}) {
        const Baked baked("capsule_man.glb", squat(steps, 6), 3);
        std::size_t different = 0;
        for (std::size_t v = 0; v < baked.posed.frame.positions.size(); v += 13) {
            const std::vector<float> expected = momentsOfLocalMesh(baked, v);
            ASSERT_EQ(expected.size(), 36u);
            different += !std::equal(expected.begin(), expected.end(), &baked.local[v * 36]);
        }
        // Measured: none of 110. Another tree tests other boxes, so that a ray along an edge may fall to either side.
        EXPECT_LE(different, 1u) << steps;
    }
}

// --- A chain of balls -----------------------------------------------------------------------------------------------
// Ball 2 hangs over ball 0, and ball 1 between them in the skeleton lies far away. So the second bone blocks a vertex
// of the first, and nothing else does.

struct Balls {
    Mesh mesh;
    Skin skin;

    Balls() {
        shapes::Shape shape;
        for (const Vec3d center : {Vec3d{0, 0, 0}, {10, 0, 0}, {0, 2.4, 0}}) {
            const shapes::Shape ball = shapes::sphere(center, 1, 12);
            const auto joint = std::uint16_t(skin.joint_names.size());
            skin.joint_names.push_back("ball" + std::to_string(joint));
            skin.parents.push_back(joint - 1);
            skin.joints.insert(skin.joints.end(), ball.positions.size(), joint);
            shapes::append(shape, ball);
        }
        skin.influences = 1;
        skin.weights.assign(skin.joints.size(), 1);
        mesh.triangles = shape.triangles;
        mesh.rest_positions = shape.positions;
    }
    // Moments of one point of the mesh, whole and local.
    std::pair<std::vector<float>, std::vector<float>> trace(std::size_t vertex, Vec3 normal, int steps,
                                                            Floor floor = Floor::kNone) const {
        const SceneScale scale = sceneScale(mesh.rest_positions, boxDiagonal(mesh.rest_positions));
        std::vector<Vec3> scaled = mesh.rest_positions;
        for (Vec3& p : scaled) p = scale.apply(p);
        const OcclusionScene scene(scaled, mesh.triangles, Queries::kFiltered);
        const RayDirections directions = makeRayDirections(1024, 1, 5);
        const LocalParts parts = makeLocalParts(mesh, skin, steps, mesh.triangles.size());
        const std::vector<BoundingBox> boxes = parts.boxesOf(mesh.triangles, scaled);
        MomentTracer tracer{scene, directions, scale, 1e-4f, floor};
        tracer.local.emplace(LocalTracer{parts, directions, boxes});
        std::vector<float> whole(25), local(25);
        traceMoments(tracer, {&mesh.rest_positions[vertex], 1}, {&normal, 1}, {whole, local}, vertex);
        return {whole, local};
    }
};

std::vector<float> openHemisphere(Vec3 normal) {
    const RayDirections directions = makeRayDirections(1024, 1, 5);
    std::vector<LaneWeights> rays(directions.packets.size());
    aboveHorizon(directions, normal, Floor::kNone, rays);
    std::vector<float> b(25);
    accumulateMoments(directions, rays, b);
    return b;
}

TEST(LocalMoments, AFarPartBlocksNothing) {
    const Balls balls;
    const auto [whole, local] = balls.trace(0, {0, 1, 0}, 1);
    EXPECT_EQ(local, openHemisphere({0, 1, 0}));
    // Ball 2 fills half of the hemisphere and more: a cone of half-angle asin(1 / 1.4) = 46 degrees, 30% of it.
    EXPECT_NEAR(whole[0] / local[0], std::sqrt(1 - 1 / (1.4 * 1.4)), 0.01);
    const auto [same, near] = balls.trace(0, {0, 1, 0}, 2);
    EXPECT_EQ(same, whole);
    EXPECT_EQ(near, whole);
}

// The vertex at the side of ball 0 would see the sky below the horizon of the floor.
TEST(LocalMoments, TheGroundIsNotLocal) {
    const Balls balls;
    const std::size_t side = 1 + 5 * 24;  // at the equator of ball 0
    const Vec3 normal = balls.mesh.rest_positions[side];
    ASSERT_NEAR(normal.y, 0, 1e-6);
    const auto [whole, local] = balls.trace(side, normal, 1, Floor::kSolid);
    EXPECT_LT(whole[0], 0.51 * local[0]);
    EXPECT_EQ(local, balls.trace(side, normal, 1).second);
}

// --- Sheets ---------------------------------------------------------------------------------------------------------

struct SheetMoments {
    std::vector<float> whole, local;
};

// Moments of both sides of a sheet without a skin over an occluder.
SheetMoments sheetMoments(const shapes::Shape& shape, const shapes::Shape& occluder, Floor floor) {
    const sheets::Sheet sheet = sheets::sheetOf(shape);
    Blockers blockers;
    blockers.add(shape.triangles, shape.positions);
    blockers.add(occluder.triangles, occluder.positions);
    const SceneScale scale = sceneScale(shape.positions, boxDiagonal(shape.positions));
    std::vector<Vec3> scaled(shape.positions);
    scaled.insert(scaled.end(), occluder.positions.begin(), occluder.positions.end());
    for (Vec3& p : scaled) p = scale.apply(p);
    const OcclusionScene scene(scaled, blockers.triangles, Queries::kFiltered);
    const RayDirections directions = makeRayDirections(1024, 1, 5);
    const LocalParts parts = makeLocalParts(sheet.mesh, {}, 1, blockers.triangles.size());
    const std::vector<BoundingBox> boxes = parts.boxesOf(sheet.mesh.frontTriangles(), scaled);
    MomentTracer tracer{scene, directions, scale, 1e-4f, floor, &blockers, &sheet.mesh, sheet.positions};
    tracer.local.emplace(LocalTracer{parts, directions, boxes});
    SheetMoments out{std::vector<float>(25 * sheet.positions.size()), std::vector<float>(25 * sheet.positions.size())};
    traceMoments(tracer, sheet.positions, sheet.normals, {out.whole, out.local});
    return out;
}

// An open box: its walls shade its floor.
shapes::Shape openBox() {
    shapes::Shape box = shapes::square({0, 0, 0}, {0, 1, 0}, 1);
    shapes::append(box, shapes::square({1.01, 1, 0}, {-1, 0, 0}, 1));
    shapes::append(box, shapes::square({-1.01, 1, 0}, {1, 0, 0}, 1));
    return box;
}

TEST(LocalMoments, WithoutASkinOnlyOccludersAndTheGroundAreNotLocal) {
    const shapes::Shape box = openBox();
    const SheetMoments alone = sheetMoments(box, {}, Floor::kNone);
    EXPECT_EQ(alone.local, alone.whole);
    EXPECT_EQ(alone.whole, sheets::momentsOf(box, {}));
    const shapes::Shape ball = shapes::sphere({0, 1.5, 0}, 0.5, 8);
    const SheetMoments both = sheetMoments(box, ball, Floor::kSolid);
    EXPECT_EQ(both.whole, sheets::momentsOf(box, ball, 1024, Floor::kSolid));
    EXPECT_EQ(both.local, alone.local);
    EXPECT_NE(both.whole, both.local);
}

// The floor of the occluder touches the lower side, so that no ray of the whole escapes there.
TEST(LocalMoments, ATouchingOccluderDoesNotCloseAPoint) {
    const shapes::Shape sheet = shapes::square({0, 0, 0}, {0, 1, 0}, 1);
    const SheetMoments lying = sheetMoments(sheet, shapes::square({0, 0, 0}, {0, 1, 0}, 3), Floor::kNone);
    const SheetMoments alone = sheetMoments(sheet, {}, Floor::kNone);
    EXPECT_EQ(lying.whole[4 * 25], 0);  // the back of the first vertex
    EXPECT_EQ(lying.local, alone.local);
}

// --- The whole bake -------------------------------------------------------------------------------------------------

class LocalBake : public testing::Test {
protected:
    LocalBake() { std::filesystem::create_directories(folder_); }
    ~LocalBake() override { std::filesystem::remove_all(folder_); }
    std::string bake(const BakeOptions& options, int threads) const {
        const std::filesystem::path out = folder_ / "x.vis.h5";
        bakeVisibility(planBake({sample("capsule_man.glb")}, options), options, {out}, threads, ProgressStyle::kNone);
        std::ifstream in(out, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    std::filesystem::path folder_ =
        std::filesystem::temp_directory_path() / ("penumbra_local_test" + std::to_string(::getpid()));
};

TEST_F(LocalBake, SameBytesForAnyThreadCount) {
    BakeOptions options = squat(2, 6);
    options.rays = 64;
    const std::string expected = bake(options, 1);
    for (const int threads : {2, 8}) EXPECT_TRUE(bake(options, threads) == expected) << threads;
    const VisibilityReader reader(folder_ / "x.vis.h5");
    EXPECT_EQ(reader.header().local, options.local);
    const Baked baked("capsule_man.glb", options, 3);
    EXPECT_EQ(reader.readFrame(3).coefficients, baked.whole);
    EXPECT_EQ(reader.readFrame(3).local_coefficients, baked.local);
}

}  // namespace
}  // namespace penumbra::test_local_moments
