#include <gtest/gtest.h>

#include <algorithm>

#include "player/draw/closed_surfaces.h"
#include "player/draw/draw_frame.h"
#include "player/draw/picture_view.h"
#include "player/frame/frame_values.h"
#include "player/gl/gl_context.h"
#include "player/gl/offscreen_target.h"
#include "tests/runtime/synthetic_asset.h"

namespace penumbra::test_closed_surfaces {
namespace {

using Indices = std::vector<std::uint32_t>;

// Makes a tetrahedron, its outside outside, on four vertices from `first` on.
Indices tetrahedron(std::uint32_t first) {
    Indices t = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    for (std::uint32_t& v : t) v += first;
    return t;
}
const std::vector<Vec3> kCorners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

TEST(ClosedSurfaces, TetrahedronIsClosedAndASquareIsNot) {
    Indices triangles = {0, 1, 2, 2, 1, 3};  // first, so that it has to move
    const Indices closed = tetrahedron(4);
    triangles.insert(triangles.end(), closed.begin(), closed.end());
    const ClosedSurfaces surfaces = findClosedSurfaces(triangles);
    EXPECT_EQ(surfaces.ends, (std::vector<std::size_t>{12}));
    EXPECT_EQ(Indices(surfaces.triangles.begin(), surfaces.triangles.begin() + 12), closed);
    EXPECT_EQ(Indices(surfaces.triangles.begin() + 12, surfaces.triangles.end()), (Indices{0, 1, 2, 2, 1, 3}));
    EXPECT_EQ(findClosedSurfaces({}).closedIndices(), 0u);
}

TEST(ClosedSurfaces, AHoleAFlippedTriangleAndAFinAreFound) {
    Indices hole = tetrahedron(0);
    hole.resize(9);
    Indices flipped = tetrahedron(0);
    std::swap(flipped[0], flipped[1]);
    Indices fin = tetrahedron(0);
    fin.insert(fin.end(), {0, 1, 4});
    for (const Indices& triangles : {hole, flipped, fin}) EXPECT_TRUE(findClosedSurfaces(triangles).ends.empty());
}

TEST(ClosedSurfaces, OneInsideOutSpoilsThePose) {
    Indices triangles = tetrahedron(0);
    const Indices second = tetrahedron(4);
    triangles.insert(triangles.end(), second.begin(), second.end());
    const ClosedSurfaces surfaces = findClosedSurfaces(triangles);
    EXPECT_EQ(surfaces.ends, (std::vector<std::size_t>{12, 24}));
    std::vector<Vec3> positions = kCorners;
    for (const Vec3& p : kCorners) positions.push_back(p + Vec3{5, 0, 0});
    EXPECT_TRUE(allOutward(surfaces, positions));
    positions[7].z = -1;  // the second one mirrored
    EXPECT_FALSE(allOutward(surfaces, positions));
}

// Triangles that face away are left out of a sphere, because they are hidden. At the silhouette front and back meet at
// one depth, and which is drawn first stays: measured 2 pixels of 16384.
TEST(ClosedSurfaces, PictureIsTheSameWithoutWhatIsHidden) {
    const player_test::SyntheticAsset data;
    RenderOptions options;
    options.width = options.height = 128;
    Evaluator evaluator(data.asset);
    FrameVertices vertices;
    evaluateFrame(resolveShot(options, data.asset, nullptr), VisibilitySource::kModel, evaluator, 1, vertices);
    const FrameView view = makePictureView(options, data.asset, vertices.positions);
    const std::unique_ptr<GlContext> context = createGlContext(GlBackend::kAuto);
    const OffscreenTarget target(128, 128, 4);
    std::vector<Image> images;
    const Indices both(data.asset.mesh.triangles.begin(), data.asset.mesh.triangles.end());
    EXPECT_EQ(findClosedSurfaces(both).closedIndices(), both.size());
    for (const Sides sides : {Sides::kBoth, Sides::kSeen}) {
        ValuePainter painter(both, Channel::kNormals, sides);
        target.begin();
        painter.draw(view, vertices.positions, vertices.normals);
        images.push_back(target.read());
    }
    EXPECT_EQ(images[0].alpha, images[1].alpha);
    std::size_t different = 0;
    for (std::size_t i = 0; i < images[0].pixels.size(); ++i)
        different += length(images[0].pixels[i] - images[1].pixels[i]) != 0;
    EXPECT_LE(different, 6u);
    // Inside out: both sides are drawn.
    std::vector<Vec3> mirrored = vertices.positions;
    for (Vec3& p : mirrored) p.x = -p.x;
    ValuePainter painter(both, Channel::kNormals, Sides::kSeen);
    target.begin();
    painter.draw(makePictureView(options, data.asset, mirrored), mirrored, vertices.normals);
    const Image image = target.read();
    EXPECT_GT(std::count(image.alpha.begin(), image.alpha.end(), 1.0f), 3000);
}

}  // namespace
}  // namespace penumbra::test_closed_surfaces
