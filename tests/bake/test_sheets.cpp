// Thin sheets: either side has moments of its own, and no light leaks through what lies on them. Closed forms.
#include <gtest/gtest.h>

#include "tests/bake/sheets.h"

namespace penumbra::test_sheets {
namespace {

using namespace sheets;
using shapes::Shape;

// A fan around the y axis, fronts up.
Shape disc(double radius, double height) {
    constexpr std::uint32_t kSides = 512;
    Shape s;
    s.positions.push_back(toFloat({0, height, 0}));
    for (std::uint32_t k = 0; k < kSides; ++k) {
        const double a = 2 * std::numbers::pi * k / kSides;
        s.positions.push_back(toFloat({radius * std::cos(a), height, radius * std::sin(a)}));
        s.triangles.push_back({0, 1 + (k + 1) % kSides, 1 + k});
    }
    return s;
}

// Makes a closed box, with fronts outside.
Shape box(Vec3d low, Vec3d high) {
    Shape s;
    for (int i = 0; i < 8; ++i)
        s.positions.push_back(toFloat({i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z}));
    s.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return s;
}

// --- A sheet on a body ----------------------------------------------------------------------------------------------

// 1024 directions integrate an open hemisphere to 0.29% here. Edges of the sheet are 0.25 long and the bias is
// 2.8e-4: heights are far above both, far below both, and contact. The front sees the open sky. Of the back's rays
// only those within h / 2000 of the horizon pass the body's edge, which no ray of the set does.
TEST(Sheets, SheetOverAPlaneIsOpenAboveAndBlackBelow) {
    for (const double h : {0.5, 0.02, 1e-3, 2.8e-4, 1e-4, 1e-5, 4e-6, 1e-7, 0.0}) {
        const Shape sheet = grid(9, h);
        const std::vector<float> b = momentsOf(sheet, shapes::square({0, 0, 0}, {0, 1, 0}, 2000));
        const std::size_t fronts = sheet.positions.size();
        for (std::size_t v = 0; v < fronts; ++v) {
            EXPECT_LT(errorOf(at(b, v), capMoments({0, 1, 0}, 0)), 5e-3) << "front " << v << " at " << h;
            EXPECT_EQ(size(at(b, fronts + v)), 0) << "back " << v << " at " << h;
        }
    }
}

// The body below sees a disc of radius 1 at distance h, a cap of half-angle atan(1 / h). The body is the mesh of the
// bake, and the sheet is its occluder. Measured 0.2% to 0.9% of the open hemisphere with 1024 rays; the bound is
// 1.5%.
TEST(Sheets, PlaneUnderASheetSeesTheDisc) {
    const Shape body = grid(3, 0);  // vertex 4 is in the middle
    for (const double h : {3.0, 1.0, 0.5, 0.1, 0.01, 1e-3, 1e-4, 1e-5}) {
        const std::vector<float> b = momentsOf(body, disc(1, h));
        EXPECT_LT(errorOf(at(b, 4), capMoments({0, 1, 0}, std::atan(1 / h))), 0.015) << h;
        EXPECT_LT(errorOf(at(b, 9 + 4), capMoments({0, -1, 0}, 0)), 5e-3) << h;
    }
}

// Two sheets of one mesh lie on each other. Between them it is dark, and outside it is open.
TEST(Sheets, LayersShadeEachOther) {
    for (const double h : {0.01, 1e-4, 1e-5}) {
        Shape both = grid(9, 0);
        shapes::append(both, grid(9, h));
        const std::vector<float> b = momentsOf(both, {});
        const std::size_t fronts = both.positions.size(), lower = 4 * 9 + 4, upper = 81 + lower;
        EXPECT_LT(errorOf(at(b, upper), capMoments({0, 1, 0}, 0)), 5e-3) << h;
        EXPECT_LT(errorOf(at(b, fronts + lower), capMoments({0, -1, 0}, 0)), 5e-3) << h;
        // The gap of height h is open at its rim, 1 away. A ray (0.0087 each) may slip between two triangles along
        // their edge: at h = 1e-5 up to two of 1024 do.
        EXPECT_LT(size(at(b, lower)), 3 * h + 0.02) << h;
        EXPECT_LT(size(at(b, fronts + upper)), 3 * h + 0.02) << h;
    }
}

// --- Sunk in --------------------------------------------------------------------------------------------------------

// The sheet lies below the surface of a closed body by up to kSunkIn (0.01 of the sheet's diagonal of 2.83). Its
// front is lit as if it lay on the body, and its back is black. Deeper it is inside, and both are black.
TEST(Sheets, SheetSunkIntoABodyIsLitAsOnIt) {
    const Shape body = box({-50, -100, -50}, {50, 0, 50});
    for (const double depth : {1e-7, 1e-5, 1e-3, 0.02, 0.04}) {
        const Shape sheet = grid(5, -depth);
        const std::vector<float> b = momentsOf(sheet, body);
        const std::size_t fronts = sheet.positions.size();
        for (std::size_t v = 0; v < fronts; ++v) {
            if (depth < 0.028)
                EXPECT_LT(errorOf(at(b, v), capMoments({0, 1, 0}, 0)), 5e-3) << depth;
            else
                EXPECT_EQ(size(at(b, v)), 0) << depth;
            EXPECT_EQ(size(at(b, fronts + v)), 0) << depth;
        }
    }
    // A body whose triangles face inwards is the same body.
    Shape inside_out = body;
    for (Triangle& t : inside_out.triangles) std::swap(t[1], t[2]);
    EXPECT_EQ(momentsOf(grid(5, -1e-3), inside_out), momentsOf(grid(5, -1e-3), body));
}

// From a plate thinner than kSunkIn the sheet comes out at the side that is nearer, not at both.
TEST(Sheets, SheetSunkIntoAThinPlateComesOutOnce) {
    for (const bool near_top : {true, false}) {
        const double y = near_top ? -1e-3 : -9e-3;
        const std::vector<float> b = momentsOf(grid(5, y), box({-50, -0.01, -50}, {50, 0, 50}));
        for (std::size_t v = 0; v < 25; ++v) {
            EXPECT_EQ(size(at(b, v)) > 1, near_top) << v;
            EXPECT_EQ(size(at(b, 25 + v)) > 1, !near_top) << v;
        }
    }
}

// A character of two boxes and a banner of two triangles back to back. One box and the banner have sunk into the other
// box.
TEST(Sheets, PartsOfACharacterThatSinkInAreDarkBesideABanner) {
    constexpr double kDepth = 5e-3;  // less than kSunkIn, at a diagonal near 2
    Shape s = box({-0.5, -1, -0.5}, {0.5, 0, 0.5});
    shapes::append(s, box({-0.1, -kDepth, -0.1}, {0.1, 1, 0.1}));
    const std::vector<Vec3> banner{toFloat({0.3, -kDepth, 0.3}), toFloat({0.3, -kDepth, 0.4}),
                                   toFloat({0.4, -kDepth, 0.3})};
    shapes::append(s, {banner, {{0, 1, 2}}});
    shapes::append(s, {banner, {{0, 2, 1}}});
    Mesh mesh;
    mesh.triangles = s.triangles;
    mesh.rest_positions = s.positions;
    Skin skin;
    skin.influences = 1;
    skin.joints.assign(22, 0);
    skin.weights.assign(22, 1.0f);
    Blockers blockers;
    blockers.addSurface(mesh, &skin);
    blockers.add(s.triangles, s.positions);
    blockers.keepToTwins(mesh);
    const SceneScale scale = sceneScale(s.positions, boxDiagonal(s.positions));
    std::vector<Vec3> scaled = s.positions;
    for (Vec3& p : scaled) p = scale.apply(p);
    const OcclusionScene scene(scaled, blockers.triangles, Queries::kFiltered, blockers.through());
    const RayDirections directions = makeRayDirections(1024, 1, kOrder);
    MomentTracer tracer{scene, directions, scale};
    tracer.blockers = &blockers;
    tracer.mesh = &mesh;
    tracer.vertices = s.positions;
    std::vector<float> b(22 * kSize);
    traceMoments(tracer, s.positions, vertexNormals(s.triangles, s.positions), {b});
    // The bottom of the small box is inside the large one, its top is outside.
    for (const std::size_t v : {8, 9, 12, 13}) EXPECT_EQ(size(at(b, v)), 0) << v;
    for (const std::size_t v : {10, 11, 14, 15}) EXPECT_GT(size(at(b, v)), 1) << v;
    // The upper side of the banner comes out of the box, as that of a sheet does.
    for (const std::size_t v : {16, 17, 18}) EXPECT_GT(size(at(b, v)), 1) << v;
}

// An open surface has no inside, so that what is behind it stays dark, however near it is.
TEST(Sheets, OpenSurfaceIsNotLeft) {
    const std::vector<float> b = momentsOf(grid(5, -1e-3), shapes::square({0, 0, 0}, {0, 1, 0}, 2000));
    for (std::size_t v = 0; v < 25; ++v) EXPECT_EQ(size(at(b, v)), 0) << v;
}

// --- Occluders and ground -------------------------------------------------------------------------------------------

// A ball of radius r at height d over the middle hides a cap of half-angle asin(r / d). Facets lose 1 - cos(pi / 256)
// of the radius. Measured 0.3% to 0.8% of the open hemisphere; the bound is 1.5%.
TEST(Sheets, BallOverASheetIsACap) {
    for (const auto& [r, d] : {std::pair(0.5, 1.0), {0.2, 2.0}, {0.9, 1.0}, {0.999, 1.0}}) {
        const std::vector<float> b = momentsOf(grid(3, 0), shapes::sphere({0, d, 0}, r, 128));
        EXPECT_LT(errorOf(at(b, 4), capMoments({0, 1, 0}, std::asin(r / d))), 0.015) << r;
        EXPECT_LT(errorOf(at(b, 9 + 4), capMoments({0, -1, 0}, 0)), 5e-3) << r;
    }
}

// The floor blocks what points down, wherever the sheet is. One that has sunk below it is shaded as if it lay on it.
TEST(Sheets, GroundBlocksWhatPointsDown) {
    const std::vector<float> b = momentsOf(grid(3, 0), {}, 1024, Floor::kSolid);
    EXPECT_LT(errorOf(at(b, 4), capMoments({0, 1, 0}, 0)), 5e-3);
    EXPECT_EQ(size(at(b, 9 + 4)), 0);
    Shape wall = grid(3, 0);
    for (Vec3& p : wall.positions) p = {p.y, p.x, p.z};  // the front faces -x, because the turn changes hands
    const std::vector<float> upright = momentsOf(wall, {}, 4096, Floor::kSolid);
    for (const std::size_t v : {std::size_t(4), std::size_t(13)})  // half of the hemisphere is left
        EXPECT_NEAR(upright[v * kSize], std::sqrt(std::numbers::pi) / 2, 2e-3);
}

// --- Creases --------------------------------------------------------------------------------------------------------

// The valley of 60 degrees runs along z. The left slope has most of the area at the crease, so that the normal there
// is nearly the left slope's and points behind the right slope. The back sees the 60 degrees between the slopes, and
// the front sees its whole hemisphere. Neither sees what is behind the sheet.
TEST(Sheets, NormalBehindATriangleDoesNotLeak) {
    const double r = 1000, c = std::cos(std::numbers::pi / 3), s = std::sin(std::numbers::pi / 3);
    Shape valley;
    valley.positions = {
        {0, 0, 0}, toFloat({0, 0, -r}), toFloat({0, 0, r}), toFloat({-40 * r, 0, 0}), toFloat({-r * c, r * s, 0})};
    valley.triangles = {{0, 2, 3}, {0, 3, 1}, {0, 4, 2}, {0, 1, 4}};  // fronts outside
    EXPECT_LT(vertexNormals(valley.triangles, valley.positions)[0].y, -0.99);
    const std::vector<float> b = momentsOf(valley, {}, 4096);
    const double y0 = std::sqrt(0.25 / std::numbers::pi);
    const double inside = b[5 * kSize] / y0, outside = b[0] / y0;
    EXPECT_NEAR(inside, 2 * std::numbers::pi / 3, 0.05);  // a lune of angle a has 2 a steradians
    EXPECT_NEAR(outside, 2 * std::numbers::pi, 0.05);
}

}  // namespace
}  // namespace penumbra::test_sheets
