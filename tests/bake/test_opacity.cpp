// Tests what passes through triangles: their pieces, the alpha of materials, and rays that meet both.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bake/source/surface_opacity.h"
#include "bake/source/textured_surface.h"
#include "bake/trace/moments.h"
#include "formats/common/twin_triangles.h"
#include "formats/source/source_readers.h"
#include "tests/bake/shapes.h"
#include "tests/formats/textured_rig.h"

namespace penumbra::test_opacity {
namespace {

using samples::EditableGlb;
using samples::triangleAt;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// --- Pieces ---------------------------------------------------------------------------------------------------------

TEST(Opacity, PiecesAreNumberedAsTheyAreVisited) {
    for (const int n : {1, 2, 5, 64}) {
        std::uint32_t number = 0;
        eachPiece(n, [&](const std::array<double, 3>& at) {
            EXPECT_EQ(opacityPiece(std::uint32_t(n), float(at[1]), float(at[2])), number) << n;
            ++number;
        });
        EXPECT_EQ(number, std::uint32_t(n * n));
        for (const auto& [u, v] : {std::pair(1.f, 0.f), {0.f, 1.f}, {-1e-6f, 1 + 1e-6f}, {0.5f, 0.5f}})
            EXPECT_LT(opacityPiece(std::uint32_t(n), u, v), number);
    }
}

TEST(Opacity, PartsOfAMeshKeepTheirValues) {
    const Opacity whole{{1, 4}, {2, 1}, {0, 4}, {0, 255, 255, 10, 77}};
    EXPECT_THAT(meanOpacity(whole, 6), ElementsAre(255, 130, 255, 255, 77, 255));
    const std::vector<std::uint32_t> taken{0, 4, 5};
    const Opacity part = opacityOf(whole, taken);
    EXPECT_THAT(part.triangles, ElementsAre(1));
    EXPECT_THAT(part.valuesOf(0), ElementsAre(77));
    Opacity both = part;
    appendOpacity(whole, 3, both);
    EXPECT_THAT(both.triangles, ElementsAre(1, 4, 7));
    EXPECT_THAT(both.valuesOf(2), ElementsAre(77));
}

// --- Rays -----------------------------------------------------------------------------------------------------------

// A card above the origin, side 2, at the height h, with the opacity of its two triangles.
struct Card {
    shapes::Shape shape = shapes::square({0, 0, 0.2}, {0, 0, -1}, 1);
    Opacity opacity;

    explicit Card(std::uint8_t value) {
        for (std::uint32_t t = 0; t < shape.triangles.size(); ++t) {
            opacity.triangles.push_back(t);
            opacity.pieces.push_back(1);
            opacity.first.push_back(0);
        }
        opacity.values = {value};
    }
};

// The share of the cosine-weighted sky that a square of side 2 s hides at a height h above its middle: four times the
// form factor of a rectangle over its corner (Howell, "A Catalog of Radiation Configuration Factors", B-4).
double hiddenBySquare(double s, double h) {
    const double x = s / h, root = std::sqrt(1 + x * x);
    return 4 * (1 / (2 * std::numbers::pi)) * 2 * (x / root) * std::atan(x / root);
}

// Cosine-weighted visibility over pi, from the moments of order 2 in the frame of the normal +z.
double ambientOf(const OcclusionScene& scene, Vec3 origin, int rays) {
    const RayDirections directions = makeRayDirections(rays, 1, 2);
    std::vector<LaneWeights> above(directions.packets.size());
    aboveHorizon(directions, {0, 0, 1}, Floor::kNone, above);
    scene.removeOccluded(origin, directions, above);
    std::vector<float> b(4);
    accumulateMoments(directions, above, b);
    return double(b[2]) / (std::numbers::pi * std::sqrt(3 / (4 * std::numbers::pi)));
}

// Measured: 0.002 with the 4096 rays that a hemisphere has here; a share of half has a noise of 0.5 / 64 a ray set.
TEST(Opacity, CardLetsItsShareOfTheSkyThrough) {
    const double hidden = hiddenBySquare(1, 0.2);
    for (const int value : {0, 64, 128, 200, 255}) {
        const Card card{std::uint8_t(value)};
        const OcclusionScene scene(card.shape.positions, card.shape.triangles, Queries::kPlain, {&card.opacity, {}});
        EXPECT_NEAR(ambientOf(scene, {0, 0, 0}, 4096), 1 - value / 255.0 * hidden, 0.02) << value;
    }
}

// A ray has one answer, whichever query asks. Two layers of opposite faces are one surface: half passes, not a quarter.
TEST(Opacity, EveryQueryGivesARayTheSameAnswer) {
    Card card{128};
    std::vector<std::uint32_t> twins;
    const std::size_t fronts = card.shape.triangles.size();
    for (std::uint32_t t = 0; t < fronts; ++t) {
        const auto [a, b, c] = card.shape.triangles[t];
        card.shape.triangles.push_back({a, c, b});
    }
    for (std::uint32_t t = 0; t < 2 * fronts; ++t) twins.push_back(std::uint32_t((t + fronts) % (2 * fronts)));
    const OcclusionScene scene(card.shape.positions, card.shape.triangles, Queries::kFiltered, {&card.opacity, twins});
    const RayDirections directions = makeRayDirections(512, 1, 2);
    std::vector<LaneWeights> above(directions.packets.size());
    aboveHorizon(directions, {0, 0, 1}, Floor::kNone, above);
    std::vector<LaneWeights> packets = above, hit_packets = above, near = above, far = above;
    std::vector<FirstHit> hits;
    scene.removeOccluded({0, 0, 0}, directions, packets);
    scene.removeOccluded({0, 0, 0}, directions, hit_packets, hits);
    const std::vector<std::uint16_t> part_of_triangle(card.shape.triangles.size(), 0);
    const std::vector<std::uint8_t> is_local{1};
    const BoundingBox box{{-1, -1, 0.2f}, {1, 1, 0.2f}};
    scene.removeOccludedLocally({0, 0, 0}, directions, {part_of_triangle, is_local, std::span(&box, 1)}, far, near);
    std::size_t stopped = 0, met = 0;
    for (std::size_t p = 0; p < packets.size(); ++p)
        for (std::size_t k = 0; k < kLanes; ++k) {
            if (above[p].lane[k] == 0) continue;
            const Vec3 d{directions.packets[p].x[k], directions.packets[p].y[k], directions.packets[p].z[k]};
            const float open = packets[p].lane[k];
            EXPECT_EQ(open, hit_packets[p].lane[k]);
            EXPECT_EQ(open, near[p].lane[k]);
            EXPECT_EQ(open, far[p].lane[k]);
            EXPECT_EQ(open == 0, scene.occluded({0, 0, 0}, d, 0));
            EXPECT_EQ(open == 0, scene.closestHit({0, 0, 0}, d).has_value());
            stopped += open == 0;
            met += std::max(std::abs(d.x), std::abs(d.y)) * 0.2f < d.z;
        }
    EXPECT_NEAR(double(stopped) / double(met), 0.5, 0.07);  // 426 rays meet the card: sigma .024
    for (const FirstHit& hit : hits) EXPECT_LT(hit.triangle, fronts);
}

// --- Materials ------------------------------------------------------------------------------------------------------

std::string alphaPng(int width, const std::vector<int>& alphas) {
    Image image{width, int(alphas.size()) / width, {}, {}};
    for (const int alpha : alphas) {
        const float a = float(alpha) / 255;
        image.pixels.push_back({a, a, a});
        image.alpha.push_back(a);
    }
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "alpha.png";
    writePng(path, image, 1);
    return samples::readText(path);
}

// One triangle, all of whose corners look at the same place of a picture of two texels: left clear, right opaque.
EditableGlb cardAt(float u, const char* mode) {
    EditableGlb glb = samples::texturedRig({{triangleAt(0), {samples::Uv{u, 0.5f}, {u, 0.5f}, {u, 0.5f}}}},
                                           alphaPng(4, {0, 0, 255, 255}));
    glb.json["materials"][0]["alphaMode"] = mode;
    return glb;
}

Rig rigOf(const EditableGlb& glb) {
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "card.glb";
    samples::writeText(path, glb.bytes());
    Rig rig = readRig({path});
    readOpacity(rig);
    return rig;
}

TEST(SurfaceOpacity, OpaqueTrianglesAreNotListed) {
    EXPECT_TRUE(rigOf(cardAt(0.25f, "OPAQUE")).mesh.opacity.empty());
    EXPECT_TRUE(rigOf(cardAt(0.75f, "MASK")).mesh.opacity.empty());
    EXPECT_TRUE(rigOf(cardAt(0.75f, "BLEND")).mesh.opacity.empty());
    EXPECT_THAT(rigOf(cardAt(0.25f, "MASK")).mesh.opacity.values, ElementsAre(0));
    EXPECT_THAT(rigOf(cardAt(0.25f, "BLEND")).mesh.opacity.values, ElementsAre(0));
}

TEST(SurfaceOpacity, CutOffAndAllFactorsOfAlphaCount) {
    EditableGlb glb = cardAt(0.75f, "BLEND");
    glb.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1, 1, 0.8};
    samples::addAttribute(glb, "COLOR_0", "VEC4", 4, {1, 1, 1, 0.5, 1, 1, 1, 0.5, 1, 1, 1, 0.5});
    EXPECT_THAT(rigOf(glb).mesh.opacity.values, ElementsAre(102));  // .8 x .5 of 255
    glb.json["materials"][0]["alphaMode"] = "MASK";
    glb.json["materials"][0]["alphaCutoff"] = 0.3;
    EXPECT_TRUE(rigOf(glb).mesh.opacity.empty());
    glb.json["materials"][0].erase("alphaCutoff");
    EXPECT_THAT(rigOf(glb).mesh.opacity.values, ElementsAre(0));
}

// A word that glTF does not know, and a field of another type: nobody knows whether the material has holes.
TEST(SurfaceOpacity, DamagedMaterialsAreSaid) {
    for (const auto& [field, value] : {std::pair<std::string, nlohmann::json>("alphaMode", "DITHER"),
                                       {"alphaMode", 1},
                                       {"alphaCutoff", "half"},
                                       {"doubleSided", 1}}) {
        EditableGlb glb = cardAt(0.25f, "MASK");
        glb.json["materials"][0][field] = value;
        const Rig rig = rigOf(glb);
        EXPECT_TRUE(rig.mesh.opacity.empty());
        ASSERT_EQ(rig.notes.size(), 1u) << field;
        EXPECT_EQ(rig.notes[0].feature, "alpha");
        EXPECT_THAT(rig.notes[0].effect, HasSubstr("is not known, so it stops all light: "));
    }
}

TEST(SurfaceOpacity, FollowsTheTextureTransformAndItsCoordinates) {
    EditableGlb glb = cardAt(0.75f, "MASK");
    auto& texture = glb.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    texture["extensions"]["KHR_texture_transform"] = {{"offset", {-0.5, 0.0}}};
    EXPECT_THAT(rigOf(glb).mesh.opacity.values, ElementsAre(0));
    texture.erase("extensions");
    texture["texCoord"] = 1;
    samples::addAttribute(glb, "TEXCOORD_1", "VEC2", 2, {0.25f, 0.5f, 0.25f, 0.5f, 0.25f, 0.5f});
    EXPECT_THAT(rigOf(glb).mesh.opacity.values, ElementsAre(0));
}

TEST(SurfaceOpacity, AlphaThatCannotBeKnownIsNoted) {
    EditableGlb glb = cardAt(0.25f, "MASK");
    glb.attributes().erase("TEXCOORD_0");
    const Rig rig = rigOf(glb);
    EXPECT_TRUE(rig.mesh.opacity.empty());
    ASSERT_EQ(rig.notes.size(), 1u);
    EXPECT_THAT(textOf(rig.notes[0]), HasSubstr("TEXCOORD_0"));
}

TEST(SurfaceOpacity, WhatGlassDoesBesidesIsNoted) {
    EditableGlb glb = cardAt(0.75f, "OPAQUE");
    glb.json["materials"][0]["extensions"]["KHR_materials_transmission"]["transmissionFactor"] = 0.9;
    const Rig rig = rigOf(glb);
    ASSERT_EQ(rig.notes.size(), 1u);
    EXPECT_EQ(rig.notes[0].feature, "KHR_materials_transmission");
    EXPECT_THAT(rig.notes[0].effect, HasSubstr("paint"));
}

// Piece by piece, a triangle that is turned round stops what it stopped, with u and v changed over.
TEST(Opacity, TurnedTrianglesKeepTheirPieces) {
    Opacity opacity{{0, 1}, {3, 3}, {0, 0}, {1, 2, 3, 4, 5, 6, 7, 8, 9}};
    const Opacity turned = turnedOpacity(opacity, {false, true});
    for (const auto& [u, v] : {std::pair(0.1f, 0.2f), {0.05f, 0.9f}, {0.3f, 0.25f}, {0.6f, 0.3f}, {0.3f, 0.6f}}) {
        EXPECT_EQ(turned.valuesOf(0)[opacityPiece(3, u, v)], opacity.valuesOf(0)[opacityPiece(3, u, v)]);
        EXPECT_EQ(turned.valuesOf(1)[opacityPiece(3, u, v)], opacity.valuesOf(1)[opacityPiece(3, v, u)]);
    }
}

}  // namespace
}  // namespace penumbra::test_opacity
