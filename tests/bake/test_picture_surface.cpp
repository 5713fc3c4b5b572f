// Tests how the reference reads pictures and colours of vertices at a point.
#include <gtest/gtest.h>

#include "bake/reference/picture_surface.h"
#include "formats/rig/rig_surface.h"
#include "formats/source/source_readers.h"
#include "tests/formats/textured_rig.h"

namespace penumbra::test_picture_surface {
namespace {

using samples::EditableGlb;

// A triangle whose corners are red, green and blue with alphas 1, 0.5 and 0, and have a grey base colour.
Rig coloredTriangle(const char* alpha_mode) {
    EditableGlb glb = samples::texturedRig(
        {{samples::triangleAt(0), {samples::Uv{0.5f, 0.5f}, {0.5f, 0.5f}, {0.5f, 0.5f}}}}, samples::greyPng(1, {255}));
    nlohmann::json& material = glb.json["materials"][0];
    material["pbrMetallicRoughness"]["baseColorFactor"] = {0.5, 0.5, 0.5, 0.8};
    material["pbrMetallicRoughness"]["metallicFactor"] = 0;
    material["alphaMode"] = alpha_mode;
    samples::addAttribute(glb, "COLOR_0", "VEC4", 4, {1, 0, 0, 1, 0, 1, 0, 0.5, 0, 0, 1, 0});
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "picture_surface.glb";
    samples::writeText(path, glb.bytes());
    return readRig({path});
}

PictureSurface surfaceFrom(const Rig& rig) {
    MeshSurface surface = surfaceOf(rig, "rig").surface;
    for (SlotSurface& slot : surface.slots) slot.metallic = 0;
    return {std::move(surface), std::vector<std::uint16_t>(rig.mesh.triangles.size(), 0), "", "rig"};
}

TEST(PictureSurface, InterpolatesColoursOfVertices) {
    const PictureSurface surface = surfaceFrom(coloredTriangle("OPAQUE"));
    const SurfacePlace place{0, {0.25, 0.25, 0.5}};
    const Vec3d seen = surface.materialAt(place).diffuse;
    EXPECT_NEAR(seen.x, 0.125, 1e-6);
    EXPECT_NEAR(seen.y, 0.125, 1e-6);
    EXPECT_NEAR(seen.z, 0.25, 1e-6);
    EXPECT_FALSE(surface.isHole(place, 0)) << "an opaque material has no alpha";
}

// Alpha is 0.8 (1 - b / 2 - c) for the weights (1 - b - c, b, c); the cut-off is 0.5.
TEST(PictureSurface, AlphaOfVerticesCutsHoles) {
    const PictureSurface surface = surfaceFrom(coloredTriangle("MASK"));
    EXPECT_FALSE(surface.isHole({0, {0.8, 0, 0.2}}, 0));
    EXPECT_TRUE(surface.isHole({0, {0.5, 0, 0.5}}, 0));
    EXPECT_FALSE(surface.isHole({0, {0.4, 0.6, 0}}, 0));
    EXPECT_TRUE(surface.isHole({0, {0, 1, 0}}, 0));
}

// Alpha is 0.4 at the second corner: 0.6 of the rays pass.
TEST(PictureSurface, BlendingLetsTheRestThrough) {
    const PictureSurface surface = surfaceFrom(coloredTriangle("BLEND"));
    int holes = 0;
    for (int i = 0; i < 1000; ++i) holes += surface.isHole({0, {0, 1, 0}}, (i + 0.5) / 1000);
    EXPECT_EQ(holes, 600);
    EXPECT_TRUE(surface.isHole({0, {0, 0, 1}}, 0)) << "what has no alpha is not there";
}

// A triangle in the plane z = 0, twice as wide as high, with a normal map and perhaps tangents of the file.
PictureSurface bumpyTriangle(const std::array<samples::Uv, 3>& uv, const std::vector<float>& tangent) {
    EditableGlb glb =
        samples::texturedRig({{{Vec3{0, 0, 0}, Vec3{2, 0, 0}, Vec3{0, 1, 0}}, uv}}, samples::greyPng(1, {255}));
    glb.json["materials"][0]["normalTexture"] = {{"index", 0}};
    std::vector<float> tangents;
    for (int k = 0; k < 3; ++k) tangents.insert(tangents.end(), tangent.begin(), tangent.end());
    if (!tangents.empty()) samples::addAttribute(glb, "TANGENT", "VEC4", 4, tangents);
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "bumpy_triangle.glb";
    samples::writeText(path, glb.bytes());
    return surfaceFrom(readRig({path}));
}

// Returns the normals of the pictures' vectors (0.6, 0, 0.8) and (0, 0.6, 0.8), whose third number is 0.8.
std::array<Vec3d, 2> bentBy(const PictureSurface& surface) {
    const SurfacePlace place{0, {0.25, 0.25, 0.5}};
    const std::array<Vec3d, 3> corners = {Vec3d{0, 0, 0}, {2, 0, 0}, {0, 1, 0}};
    return {surface.bentNormal(place, corners, {0, 0, 1}, {0.6, 0, 0.8}),
            surface.bentNormal(place, corners, {0, 0, 1}, {0, 0.6, 0.8})};
}

// glTF's tangents are unit, however the picture is stretched. v points down.
TEST(PictureSurface, NormalsLeanAlongUnitTangents) {
    constexpr samples::Uv kLow{0, 1}, kRight{1, 1}, kHigh{0, 0};
    const auto expect = [](const std::array<Vec3d, 2>& bent, Vec3d x, Vec3d y) {
        EXPECT_LT(length(bent[0] - (x * 0.6 + Vec3d{0, 0, 0.8})), 1e-6);
        EXPECT_LT(length(bent[1] - (y * 0.6 + Vec3d{0, 0, 0.8})), 1e-6);
    };
    expect(bentBy(bumpyTriangle({kLow, kRight, kHigh}, {})), {1, 0, 0}, {0, 1, 0});
    // Lines of equal v, not those across lines of equal u, are the tangent's.
    expect(bentBy(bumpyTriangle({kLow, kRight, {1, 0}}, {})), {1, 0, 0}, {0, 1, 0});
    expect(bentBy(bumpyTriangle({kRight, kLow, {1, 0}}, {})), {-1, 0, 0}, {0, 1, 0});
    // Tangents of the file, w of which tells the side of the bitangent.
    expect(bentBy(bumpyTriangle({kLow, kRight, kHigh}, {0, 1, 0, 1})), {0, 1, 0}, {-1, 0, 0});
    expect(bentBy(bumpyTriangle({kLow, kRight, kHigh}, {0, 1, 0, -1})), {0, 1, 0}, {1, 0, 0});
    expect(bentBy(bumpyTriangle({kLow, kRight, kHigh}, {1, 0, 0, -1})), {1, 0, 0}, {0, -1, 0});
    expect(bentBy(bumpyTriangle({kRight, kLow, {1, 0}}, {0, 1, 0, 1})), {0, 1, 0}, {-1, 0, 0});
}

}  // namespace
}  // namespace penumbra::test_picture_surface
