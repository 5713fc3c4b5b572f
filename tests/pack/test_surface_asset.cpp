// Assets with pictures on their mesh: what they hold, what their reader refuses, and the terms that vertices show.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "pack/pack_asset.h"
#include "pack/pack_transfer.h"
#include "pack/sections/surface_materials.h"
#include "runtime/shade/shading_set.h"
#include "tests/difference.h"
#include "tests/pack/changed_asset.h"
#include "tests/posed_vertices.h"
#include "tests/runtime/count_allocations.h"
#include "tests/synthetic_indirect.h"

namespace penumbra::test_surface_asset {
namespace {

const Model& tube() {
    static const Model model = synthetic::tubeModel({.rings = 3, .segments = 3});
    return model;
}

// Every two triangles have coordinates of their own and each has its colours, so that corners that share a vertex lie
// apart.
SurfaceLook someLook() {
    SurfaceLook look;
    look.materials = {diffuseMaterial({1, 1, 1})};
    std::vector<Uv>& uv = look.surface.uv.emplace_back();
    for (std::size_t corner = 0; corner < 3 * tube().mesh.triangles.size(); ++corner)
        uv.push_back({float(corner / 6) / 8, float(corner % 3)});
    for (std::size_t corner = 0; corner < uv.size(); ++corner)
        look.surface.colors.push_back({std::uint16_t(corner / 3), 2, 3, std::uint16_t(corner)});
    for (std::size_t corner = 0; corner < uv.size(); ++corner)
        look.surface.turns.push_back({std::int8_t(corner / 2), 5, 127, 0});
    look.surface.slots.resize(std::max<std::size_t>(1, tube().mesh.slots.size()));
    for (SlotSurface& slot : look.surface.slots) {
        slot.base = {0.5f, 0.25f, 1};
        slot.use(TextureRole::kBaseColor) = {0, 0, wrapByte(TextureWrap::kMirror, TextureWrap::kClamp)};
        slot.use(TextureRole::kNormal) = {1, 0, 0};
    }
    look.surface.textures = {{"images[0]", "", {std::byte(1), std::byte(2)}}, {"images[1]", "a/b.png", {}}};
    return look;
}

std::vector<std::byte> packed(std::optional<SurfaceLook> look) {
    const std::vector<LightFile> lights = {synthetic::light(2, 0.3)};
    std::vector<BrdfFile> materials = {diffuseMaterial({0.5f, 0.5f, 0.5f})};
    materials[0].name = "clay";
    return packAsset(tube(), materials, lights, {.precision = AssetPrecision::kF32, .surface = std::move(look)}, "{}",
                     1)
        .bytes;
}

TEST(SurfaceAsset, HoldsTheCoordinatesOfEveryCorner) {
    const SurfaceLook look = someLook();
    const std::vector<std::byte> bytes = packed(look);
    const AssetView asset = openAsset(bytes);
    ASSERT_TRUE(asset.surface);
    const std::vector<std::uint32_t> drawn =
        asset.surface->drawnTriangles(asset.mesh.triangles, asset.mesh.positions.size());
    const std::span<const Uv> uv = asset.surface->uvOf(0);
    for (std::size_t corner = 0; corner < drawn.size(); ++corner) {
        EXPECT_EQ(uv[drawn[corner]], look.surface.uv[0][corner]);
        EXPECT_EQ(asset.surface->colors[drawn[corner]], look.surface.colors[corner]);
        EXPECT_EQ(asset.surface->turns[drawn[corner]], look.surface.turns[corner]);
        const std::size_t copy = drawn[corner] - asset.mesh.positions.size();
        const std::uint32_t vertex =
            drawn[corner] < asset.mesh.positions.size() ? drawn[corner] : asset.surface->seam_vertices[copy];
        EXPECT_EQ(vertex, asset.mesh.triangles[corner]);
    }
    EXPECT_EQ(asset.surface->slots[0].base, look.surface.slots[0].base);
    EXPECT_EQ(asset.surface->slots[0].uses, look.surface.slots[0].uses);
    EXPECT_EQ(asset.surface->slots[0].materials.diffuse, 1) << "the surface's materials follow the others";
    EXPECT_EQ(asset.surface->textures[0].bytes.size(), 2u);
    EXPECT_EQ(asset.surface->textures[1].file, "a/b.png");
}

TEST(SurfaceAsset, AssetsWithoutColoursAndTangentsOfVerticesHaveNone) {
    SurfaceLook look = someLook();
    look.surface.colors.clear();
    look.surface.turns.clear();
    const std::vector<std::byte> bytes = packed(std::move(look));
    EXPECT_EQ(fbs::GetAsset(bytes.data())->surface()->colors(), nullptr);
    EXPECT_TRUE(openAsset(bytes).surface->colors.empty());
    EXPECT_EQ(fbs::GetAsset(bytes.data())->surface()->turns(), nullptr);
}

TEST(SurfaceAsset, AssetsWithoutPicturesHaveNoField) {
    const std::vector<std::byte> bytes = packed({});
    EXPECT_EQ(fbs::GetAsset(bytes.data())->surface(), nullptr);
    EXPECT_FALSE(openAsset(bytes).surface);
}

TEST(SurfaceAsset, WrongNumbersAreRefused) {
    const auto refusalAfter = [](const auto& change) {
        return refusalOf(packed(someLook()), [&](fbs::Asset& a) { change(*a.mutable_surface()); });
    };
    const auto slot = [](fbs::Surface& s) -> fbs::SlotSurface& {
        return *const_cast<fbs::SlotSurface*>(s.mutable_slots()->Get(0));
    };
    EXPECT_EQ(refusalAfter([](fbs::Surface&) {}), "accepted");
    EXPECT_NE(refusalAfter([](fbs::Surface& s) { s.mutable_uv()->Mutate(3, NAN); }).find("surface.uv"),
              std::string::npos);
    const auto refuses = [&](const auto& change, const char* what) {
        EXPECT_NE(refusalAfter(change).find(what), std::string::npos) << what << ": " << refusalAfter(change);
    };
    refuses([](fbs::Surface& s) { s.mutable_seam_vertices()->Mutate(0, 1u << 20); }, "surface.seam_vertices[0]");
    refuses([](fbs::Surface& s) { s.mutable_seam_corners()->Mutate(0, 1u << 20); }, "surface.seam_corners[0]");
    refuses([](fbs::Surface& s) { s.mutable_seam_of_corner()->Mutate(0, 1u << 20); }, "surface.seam_of_corner[0]");
    refuses([](fbs::Surface& s) { s.mutate_uv_sets(3); }, "surface.uv_sets");
    refuses([&](fbs::Surface& s) { slot(s).mutate_diffuse(7); }, "surface.slots[0].diffuse");
    refuses([&](fbs::Surface& s) { slot(s).mutate_steps(4); }, "surface.slots[0].steps");
    refuses([&](fbs::Surface& s) { slot(s).mutate_metallic(1.5f); }, "surface.slots[0].metallic");
    refuses([&](fbs::Surface& s) { slot(s).mutate_roughness(NAN); }, "surface.slots[0].roughness");
    const auto use = [&](fbs::Surface& s) -> fbs::TextureUse& {
        return const_cast<fbs::TextureUse&>(*slot(s).mutable_uses()->Get(0));
    };
    refuses([&](fbs::Surface& s) { use(s).mutate_texture(2); }, "surface.slots[0].uses[0].texture");
    refuses([&](fbs::Surface& s) { use(s).mutate_uv_set(1); }, "surface.slots[0].uses[0].uv_set");
    refuses([&](fbs::Surface& s) { use(s).mutate_wrap(9); }, "surface.slots[0].uses[0].wrap");
}

TEST(SurfaceAsset, RejectsEveryTruncation) { expectTruncationsRefused(packed(someLook()), 7); }

// Under the light 1 + x + y/2 an open point of normal z has W = 1/pi times the integral of s_x (1 + s_x) = 2/3, and
// 1/3.
TEST(SurfaceTerms, OfAnOpenVertexAreTheClosedForm) {
    const std::vector<std::byte> bytes = packed(someLook());
    const AssetView asset = openAsset(bytes);
    ShadingSet set(asset);
    EXPECT_EQ(set.terms(), 1u);
    set.setMaterial(1);  // a mesh without slots begins with the first
    set.showSurface();
    ASSERT_EQ(set.terms(), 4u);
    const float y0 = std::sqrt(4 * std::numbers::pi_v<float>), y1 = std::sqrt(4 * std::numbers::pi_v<float> / 3);
    std::vector<float> light(12);
    for (std::size_t c = 0; c < 3; ++c) light[c] = y0, light[9 + c] = -y1, light[3 + c] = -y1 / 2;
    set.setLight(0, light);
    const std::size_t count = asset.mesh.positions.size(), stride = std::size_t(asset.model.stride);
    const std::vector<float> open = freeSight(asset.model.convention);
    std::vector<float> coefficients(count * stride, 0.0f);
    for (std::size_t v = 0; v < count; ++v)
        std::copy(open.begin(), open.end(), coefficients.begin() + std::ptrdiff_t(v * stride));
    const std::vector<Vec3> positions(count), normals(count, Vec3{0, 0, 1}), tangents(count, Vec3{0, 1, 0});
    std::vector<Vec3> terms(4 * count);
    set.shadeTerms({positions, normals, tangents, coefficients, 0, count}, {0, 0, 5}, terms);
    for (std::size_t c = 1; c < 4; ++c)
        for (std::size_t v = 0; v < count; ++v) {
            EXPECT_NEAR(terms[c * count + v].x, 2.0f / 3, 0.02f);
            EXPECT_NEAR(terms[c * count + v].y, 1.0f / 3, 0.01f);
            EXPECT_NEAR(terms[c * count + v].z, 0, 1e-5f);
        }
    EXPECT_NEAR(terms[0].x, 1, 0.01f);
}

// Three parts that differ in what they show: normal maps and two roughnesses, one roughness alone, and diffuse alone.
SurfaceLook partsLook() {
    SurfaceLook look;
    look.surface.uv.emplace_back(3 * tube().mesh.triangles.size(), Uv{0.5f, 0.5f});
    look.surface.slots.resize(3);
    look.surface.slots[0].roughness = 0.3f;
    look.surface.slots[0].use(TextureRole::kNormal) = {0, 0, 0};
    look.surface.slots[1].roughness = 0.8f;
    look.surface.slots[1].f0 = {0.04f, 0.04f, 0.04f};
    look.surface.textures = {{"images[0]", "", {std::byte(1), std::byte(2)}}};
    addSurfaceMaterials(look, 1);
    SurfaceMaterials &first = look.surface.slots[0].materials, &last = look.surface.slots[2].materials;
    first.steps = 2;
    first.roughness = {0.3f, 0.8f};
    first.f0[1] = look.surface.slots[1].materials.f0[0];
    first.f90[1] = look.surface.slots[1].materials.f90[0];
    last.steps = 0;
    return look;
}

// Light and visibility are joined once for all terms. They equal what is shaded term by term, on every path, with and
// without light that bounces, in every form of the light, and for pieces that begin and end within blocks and parts.
// Radiances reach 1.3. Measured: 3.0e-7.
TEST(SurfaceTerms, ShadedAtOnceAreThoseShadedOneByOne) {
    Model model = synthetic::litTube({.rings = 9, .segments = 7});
    model.mesh.slots = {"a", "b", "c"};
    for (std::size_t v = 0; v < model.mesh.vertexCount(); ++v)
        model.mesh.slot_of_vertex.push_back(std::uint16_t(v % 3));
    SurfaceLook look = partsLook();
    look.surface.uv[0].resize(3 * model.mesh.triangles.size());
    std::vector<LightFile> lights = {synthetic::light(4, 0.3), synthetic::light(2, 0.7)};
    lights[1].name = "other";
    std::vector<BrdfFile> materials = {diffuseMaterial({0.5f, 0.5f, 0.5f})};
    materials[0].name = "clay";
    const Packed packed =
        packAsset(model, materials, lights, {.precision = AssetPrecision::kF32, .surface = std::move(look)}, "{}", 1);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    evaluator.setFrame(1);
    const PosedArrays posed(evaluator);
    const std::size_t count = posed.positions.size();
    for (const LightForm form : {LightForm::kRotation, LightForm::kFixed})
        for (const Bounces bounces : {Bounces::kBoth, Bounces::kDirect, Bounces::kIndirect})
            for (std::size_t light = 0; light < 2; ++light) {
                ShadingSet set(asset, {Reflectance::kSlices, form});
                set.showSurface();
                ASSERT_EQ(set.terms(), 1u + 3 + 4);
                set.setLight(light);
                set.setBounces(bounces);
                ShadePath by_one = shadePaths().front();
                by_one.shade_terms = nullptr;
                set.usePath(by_one);
                std::vector<Vec3> expected(set.terms() * count), terms(expected.size(), Vec3{7, 7, 7});
                set.shadeTerms(posed.all(), {0.5f, 1, 3}, expected);

                for (const ShadePath& path : shadePaths()) {
                    set.usePath(path);
                    const std::size_t before = allocationCount();
                    for (std::size_t begin = 0; begin < count; begin += 13)
                        set.shadeTerms(posed.range(begin, std::min(count, begin + 13)), {0.5f, 1, 3}, terms);
                    EXPECT_EQ(allocationCount(), before);
                    EXPECT_LT(largestDifference(terms, expected), 1e-6f) << path.name << " light " << light;
                }
            }
}

}  // namespace
}  // namespace penumbra::test_surface_asset
