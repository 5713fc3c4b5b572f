#pragma once
// How the pictures of materials lie on a mesh: what each part takes of which picture, and where.
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

enum class TextureWrap : std::uint8_t { kRepeat, kMirror, kClamp };

// The role of a picture in a material, as in glTF 2.0 (sections 3.9.2 and 3.9.3).
enum class TextureRole : std::uint8_t {
    kBaseColor,          // sRGB, times the base colour
    kMetallicRoughness,  // green times the roughness, blue times the metalness
    kNormal,             // 2 c - 1 along tangent, bitangent and normal
    kEmissive,           // sRGB, times the emitted radiance
    kOcclusion,          // red: the share of the light around that reaches the point
};
constexpr std::size_t kTextureRoles = 5;
constexpr std::uint16_t kNoTexture = 0xffff;
constexpr std::size_t kMaxUvSets = 2;
constexpr std::size_t kMaxRoughnessSteps = 3;

// Which picture has a role, and how it repeats. The layout is that of asset.fbs.
struct TextureUse {
    std::uint16_t texture = kNoTexture;
    std::uint8_t uv_set = 0;
    std::uint8_t wrap = 0;  // u + 3 * v, see TextureWrap

    bool any() const { return texture != kNoTexture; }
    TextureWrap wrapU() const { return TextureWrap(wrap % 3); }
    TextureWrap wrapV() const { return TextureWrap(wrap / 3); }
    bool operator==(const TextureUse&) const = default;
};
constexpr std::uint8_t wrapByte(TextureWrap u, TextureWrap v) { return std::uint8_t(int(u) + 3 * int(v)); }

// The cut-off of a slot that lets through what alpha leaves (alphaMode BLEND).
constexpr float kBlendAlpha = -1;

// The materials of the asset with which the vertices of a part are shaded before its pictures are applied. D is the
// radiance of the diffuse material. A and B are those of the materials that multiply f0 and f90 of Schlick's Fresnel
// term, at up to three roughnesses.
struct SurfaceMaterials {
    std::array<float, kMaxRoughnessSteps> roughness{};  // ascending
    std::uint16_t diffuse = 0, steps = 0;               // steps: of the roughness; 0: A and B are nothing
    std::array<std::uint16_t, kMaxRoughnessSteps> f0{}, f90{};
};

// The look of a part of a mesh. A pixel shows base (1 - metallic) D + f0 A + f90 B + emissive, with
// f0 = mix(dielectric f0, base, metallic) and f90 = mix(dielectric f90, 1, metallic). Each number is multiplied by its
// picture. The layout is that of asset.fbs.
struct SlotSurface {
    Vec3 base{1, 1, 1}, emissive{0, 0, 0}, f0{0, 0, 0};  // linear Rec.709; f0 and f90 of the dielectric
    float f90 = 0;
    float metallic = 0, roughness = 1;
    float normal_scale = 1, occlusion_strength = 1;
    float alpha = 1, alpha_cutoff = 0;  // a pixel below the cut-off is not there; 0: all are; kBlendAlpha
    SurfaceMaterials materials;
    std::array<TextureUse, kTextureRoles> uses;

    const TextureUse& use(TextureRole role) const { return uses[std::size_t(role)]; }
    TextureUse& use(TextureRole role) { return uses[std::size_t(role)]; }
    bool blends() const { return alpha_cutoff < 0; }
};
static_assert(sizeof(SlotSurface) == 4 * 16 + 4 * 3 + 2 * 8 + 4 * kTextureRoles);

// A picture: a file, or its bytes.
struct SurfaceTexture {
    std::string name;  // for messages
    std::filesystem::path file;
    std::vector<std::byte> bytes;  // where `file` is empty
};

using Uv = std::array<float, 2>;                   // v points down
using VertexColor = std::array<std::uint16_t, 4>;  // linear Rec.709 and alpha; 65535 is 1
constexpr VertexColor kWhiteVertex = {65535, 65535, 65535, 65535};

// How the tangents of normal maps that a file has (TANGENT of glTF) lie in the frame of a corner's texture coordinates.
// That frame has x in the direction in which u grows, across the normal, and y at right angles to both, on the side to
// which v falls. The cosine and the sine of the turn from x to the tangent, towards y; then 1, or -1 where the
// bitangent lies on the other side; all times 127.
using TangentTurn = std::array<std::int8_t, 4>;  // the last is 0
constexpr TangentTurn kSameTangent = {127, 0, 127, 0};

// How notes about pictures that cannot be had end.
constexpr const char* kNumbersAlone = ": the numbers of the material stand alone";

struct MeshSurface {
    std::vector<std::vector<Uv>> uv;  // [sets][3T] of the corners of Mesh::triangles
    std::vector<VertexColor> colors;  // [3T] of the corners, times the base colour; empty: white
    std::vector<TangentTurn> turns;   // [3T] of the corners; empty: none
    std::vector<SlotSurface> slots;   // [slots], or one where the mesh has no slots
    std::vector<SurfaceTexture> textures;
};

}  // namespace penumbra
