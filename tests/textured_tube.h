#pragma once
// A tube with pictures in all roles, as the bytes of an asset. Its materials D, A and B have made-up slices.
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/image/image_file.h"
#include "formats/image/texture_file.h"
#include "pack/pack_asset.h"
#include "tests/synthetic_model.h"

namespace penumbra::synthetic {

inline std::filesystem::path stripedFile() {
    return std::filesystem::temp_directory_path() / ("penumbra_striped_" + std::to_string(getpid()) + ".png");
}

inline std::vector<std::byte> takeBytes(const std::filesystem::path& file) {
    const std::vector<std::byte> bytes = readTextureBytes(file);
    std::filesystem::remove(file);
    return bytes;
}

// The bytes of a PNG of smooth stripes between `low` and `high`.
inline std::vector<std::byte> stripedPng(int seed, Vec3 low, Vec3 high) {
    TexturePicture picture{64, 32, {}, {}};
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x)
            for (int c = 0; c < 3; ++c) {
                const double t = 0.5 + 0.5 * std::sin(0.2 * (c + 1) * x + 0.3 * y + seed + c);
                picture.rgb.push_back(std::uint8_t(std::lround(255 * (low[c] + (high[c] - low[c]) * t))));
            }
    writeTexturePng(stripedFile(), picture);
    return takeBytes(stripedFile());
}

// The bytes of a PNG of stripes of colour that are not there for half of their width.
inline std::vector<std::byte> holedPng() {
    Image image;
    image.width = 64;
    image.height = 32;
    for (int i = 0; i < image.width * image.height; ++i) {
        const float x = float(i % image.width), y = float(i / image.width), alpha = 0.55f + 0.45f * std::sin(0.4f * x);
        image.alpha.push_back(alpha);
        image.pixels.push_back(Vec3{0.5f + 0.4f * std::sin(0.3f * y), 0.4f + 0.3f * std::sin(0.2f * x), 0.6f} * alpha);
    }
    writePng(stripedFile(), image, 1);
    return takeBytes(stripedFile());
}

// D, and A and B at `steps` roughnesses: slices of the cosine and what depends on the eye.
inline std::vector<BrdfFile> partsOfMaterial(std::size_t steps) {
    std::vector<BrdfFile> parts = {lambert({1, 1, 1})};
    parts[0].name = "diffuse";
    for (std::size_t i = 0; i < 2 * steps; ++i) {
        BrdfFile& part = parts.emplace_back(lambert({0.6, 0.6, 0.6}));
        part.name = (i % 2 == 0 ? "f0 of " : "f90 of ") + std::to_string(i / 2);
        for (std::size_t s = i; s < part.slices.size(); s += 7) part.slices[s] += 0.15 * std::sin(double(s + i));
        part.lobes = {{i % 2 == 0 ? BrdfModel::kGgxF0 : BrdfModel::kGgxF90, {0.3f + 0.3f * float(i / 2)}, {1, 1, 1}}};
    }
    return parts;
}

// Tangents that turn along the tube, and have the other side in some triangles.
inline std::vector<TangentTurn> turnsOf(const Mesh& mesh) {
    const auto code = [](double x) { return std::int8_t(std::lround(127 * x)); };
    std::vector<TangentTurn> out;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t])
            out.push_back({code(std::cos(0.1 * v)), code(std::sin(0.1 * v)), code(t % 11 == 0 ? -1 : 1), 0});
    return out;
}

// Which slots a tube has: one with pictures in all roles and two roughnesses; that one and another with holes and one
// roughness; the two with colours, alpha and tangents of vertices; or one without bumps and holes and with one
// roughness.
enum class TexturedSlots { kCloth, kClothAndCard, kTinted, kLevel };
inline bool hasTwoSlots(TexturedSlots slots) {
    return slots == TexturedSlots::kClothAndCard || slots == TexturedSlots::kTinted;
}

// Colours of corners that vary along the tube, and differ between triangles at some vertices.
inline std::vector<VertexColor> tintsOf(const Mesh& mesh) {
    std::vector<VertexColor> out;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t]) {
            const auto part = [&](double phase) {
                return std::uint16_t(std::lround(65535 * (0.6 + 0.4 * std::sin(5 * double(v) + phase))));
            };
            out.push_back({part(0), part(1), part(t % 7 == 0 ? 3 : 2), part(4)});
        }
    return out;
}

inline SurfaceLook texturedLook(const Model& model, TexturedSlots slots) {
    SurfaceLook look;
    look.materials = partsOfMaterial(2);
    look.surface.textures = {{"images[0]", "", holedPng()},
                             {"images[1]", "", stripedPng(2, {0, 0.3f, 0}, {1, 0.9f, 1})},
                             {"images[2]", "", stripedPng(3, {0.3f, 0.3f, 0.8f}, {0.7f, 0.7f, 1})}};
    std::vector<Uv>& uv = look.surface.uv.emplace_back();
    for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 p = model.mesh.rest_positions[std::size_t(model.mesh.triangles[t][k])];
            uv.push_back({std::atan2(p.z, p.x) / 3 + (t % 5 == 0 ? 0.4f : 0.0f), p.y});  // every fifth has seams
        }
    SlotSurface cloth;
    cloth.base = {0.9f, 0.8f, 0.7f};
    cloth.emissive = {0.1f, 0.05f, 0.2f};
    cloth.f0 = {0.04f, 0.05f, 0.06f};
    cloth.f90 = 0.8f;
    cloth.metallic = 0.7f;
    cloth.roughness = 0.9f;
    cloth.normal_scale = 0.8f;
    cloth.occlusion_strength = 0.6f;
    cloth.materials = {{0.3f, 0.6f, 0}, 0, 2, {1, 3, 0}, {2, 4, 0}};
    cloth.use(TextureRole::kBaseColor) = {0, 0, wrapByte(TextureWrap::kRepeat, TextureWrap::kMirror)};
    cloth.use(TextureRole::kMetallicRoughness) = {1, 0, 0};
    cloth.use(TextureRole::kNormal) = {2, 0, 0};
    cloth.use(TextureRole::kEmissive) = {1, 0, wrapByte(TextureWrap::kClamp, TextureWrap::kRepeat)};
    cloth.use(TextureRole::kOcclusion) = {0, 0, 0};
    SlotSurface card = cloth;
    card.materials.steps = 1;
    card.alpha_cutoff = 0.5f;
    card.use(TextureRole::kNormal) = {};
    look.surface.slots = {cloth, card};
    if (!hasTwoSlots(slots)) look.surface.slots.resize(1);
    if (slots == TexturedSlots::kTinted) look.surface.colors = tintsOf(model.mesh);
    if (slots == TexturedSlots::kTinted) look.surface.turns = turnsOf(model.mesh);
    if (slots == TexturedSlots::kLevel) look.surface.slots[0] = card, look.surface.slots[0].alpha_cutoff = 0;
    return look;
}

// Puts pictures on a tube. The second slot has the upper triangles. The only materials are those of the surface.
inline std::vector<std::byte> textured(Model model, TexturedSlots slots, const LightFile& light,
                                       AssetPrecision precision = AssetPrecision::kF32) {
    if (hasTwoSlots(slots)) {
        model.mesh.slots = {"cloth", "card"};
        const std::size_t vertices = model.mesh.vertexCount();
        for (std::size_t v = 0; v < vertices; ++v)
            model.mesh.slot_of_vertex.push_back(std::uint16_t(2 * v < vertices ? 0 : 1));
        const auto slot = [&](std::uint32_t v) { return model.mesh.slot_of_vertex[v]; };
        std::erase_if(model.mesh.triangles,
                      [&](const Triangle& t) { return slot(t[0]) != slot(t[1]) || slot(t[0]) != slot(t[2]); });
    }
    return packAsset(model, std::vector<BrdfFile>{}, std::vector<LightFile>{light},
                     {.precision = precision, .surface = texturedLook(model, slots)}, "{}", 1)
        .bytes;
}

inline std::vector<std::byte> texturedTube(TexturedSlots slots, const LightFile& light, const TubeOptions& options = {},
                                           AssetPrecision precision = AssetPrecision::kF32) {
    return textured(tubeModel(options), slots, light, precision);
}

}  // namespace penumbra::synthetic
