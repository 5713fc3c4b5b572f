// Tests which triangles of a mesh that lets light through cast the shadow of a sun.
#include <gtest/gtest.h>

#include <numeric>

#include "pack/sections/asset_writer.h"

namespace penumbra::test_casting {
namespace {

// A strip of triangles, all of which have the opacity `value`.
Mesh stripOf(std::uint32_t triangles, std::uint8_t value) {
    Mesh mesh;
    for (std::uint32_t v = 0; v < triangles + 2; ++v) mesh.rest_positions.push_back({float(v), float(v % 2), 0});
    for (std::uint32_t t = 0; t < triangles; ++t) {
        mesh.triangles.push_back({t, t + 1 + t % 2, t + 2 - t % 2});
        mesh.opacity.triangles.push_back(t);
        mesh.opacity.pieces.push_back(1);
        mesh.opacity.first.push_back(0);
    }
    mesh.opacity.values = {value};
    return mesh;
}

MeshSection sectionOf(const Mesh& mesh) {
    std::vector<std::uint32_t> same(mesh.vertexCount());
    std::iota(same.begin(), same.end(), 0u);
    MeshSection section;
    addSurface(mesh, nullptr, same, section);
    return section;
}

// Any ten neighbours cast as their share says, to one triangle.
TEST(Casting, NeighboursCastAsTheirOpacitySays) {
    for (const int value : {26, 77, 128, 230}) {
        const MeshSection section = sectionOf(stripOf(1000, std::uint8_t(value)));
        std::vector<int> casts(1000);
        for (const Triangle& t : section.casting) casts[t[0]] = 1;
        EXPECT_NEAR(double(section.casting.size()), 1000 * value / 255.0, 1);
        for (std::size_t t = 0; t + 10 <= casts.size(); ++t)
            EXPECT_NEAR(std::accumulate(casts.begin() + std::ptrdiff_t(t), casts.begin() + std::ptrdiff_t(t + 10), 0),
                        10 * value / 255.0, 1.001);
    }
}

TEST(Casting, OpaqueMeshesHaveNoListAndClearOnesCastNothing) {
    Mesh opaque = stripOf(10, 0);
    opaque.opacity = {};
    EXPECT_TRUE(sectionOf(opaque).casting.empty());
    const std::vector<Triangle> casting = sectionOf(stripOf(10, 0)).casting;
    ASSERT_EQ(casting.size(), 1u);
    EXPECT_EQ(casting[0], (Triangle{0, 0, 0}));
}

}  // namespace
}  // namespace penumbra::test_casting
