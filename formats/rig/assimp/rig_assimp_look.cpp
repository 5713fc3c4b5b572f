#include "formats/rig/assimp/rig_assimp_look.h"

#include <assimp/material.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {

constexpr double kMaxEmission = 1e6;

std::optional<double> numberOf(const aiMaterial& material, const char* key) {
    ai_real value = 0;
    if (material.Get(key, 0, 0, value) != AI_SUCCESS || !std::isfinite(value)) return std::nullopt;
    return shortestOf(float(value));
}

std::optional<Vec3d> colorOf(const aiMaterial& material, const char* key, double most) {
    aiColor3D value;
    if (material.Get(key, 0, 0, value) != AI_SUCCESS) return std::nullopt;
    const auto inRange = [most](float x) { return std::isfinite(x) ? std::clamp(shortestOf(x), 0.0, most) : 0.0; };
    return Vec3d{inRange(value.r), inRange(value.g), inRange(value.b)};
}

// A Beckmann or GGX lobe is as wide as cos^s of the half vector where alpha^2 = 2 / (s + 2) (Walter 2007, section 5.2).
double roughnessOf(double exponent) { return shortestOf(float(std::pow(2 / (std::max(exponent, 0.0) + 2), 0.25))); }

// Lambert's model has no highlight. Of Phong's only the width is taken, as its strength is no reflectance.
void readClassic(const aiMaterial& material, SourceLook& look) {
    int model = aiShadingMode_Gouraud;
    material.Get(AI_MATKEY_SHADING_MODEL, model);
    const std::optional<double> exponent = numberOf(material, "$mat.shininess");
    const bool shiny = (model == aiShadingMode_Phong || model == aiShadingMode_Blinn) && exponent.value_or(0) > 0;
    look.principled.roughness = shiny ? roughnessOf(*exponent) : 1;
    look.principled.specular = shiny ? 1 : 0;
    if (shiny && colorOf(material, "$clr.specular", 1))
        look.notes.push_back("the specular color is not read: a dielectric's reflectance stands in");
}

void nameTextures(const aiMaterial& material, SourceLook& look) {
    constexpr std::pair<aiTextureType, const char*> kTypes[] = {{aiTextureType_DIFFUSE, "base color"},
                                                                {aiTextureType_BASE_COLOR, "base color"},
                                                                {aiTextureType_METALNESS, "metallic"},
                                                                {aiTextureType_DIFFUSE_ROUGHNESS, "roughness"},
                                                                {aiTextureType_NORMALS, "normal"},
                                                                {aiTextureType_NORMAL_CAMERA, "normal"},
                                                                {aiTextureType_HEIGHT, "bump"},
                                                                {aiTextureType_EMISSIVE, "emissive"},
                                                                {aiTextureType_EMISSION_COLOR, "emissive"},
                                                                {aiTextureType_SPECULAR, "specular"},
                                                                {aiTextureType_SHININESS, "shininess"},
                                                                {aiTextureType_OPACITY, "opacity"},
                                                                {aiTextureType_REFLECTION, "reflection"},
                                                                {aiTextureType_AMBIENT_OCCLUSION, "occlusion"},
                                                                {aiTextureType_LIGHTMAP, "occlusion"},
                                                                {aiTextureType_DISPLACEMENT, "displacement"},
                                                                {aiTextureType_AMBIENT, "ambient"}};
    for (const auto& [type, words] : kTypes)
        if (material.GetTextureCount(type) > 0 && std::ranges::find(look.textures, words) == look.textures.end())
            look.textures.emplace_back(words);
}

}  // namespace

SourceLook readAssimpLook(const aiMaterial& material) {
    SourceLook look;
    const aiString name = material.GetName();
    look.material = cleanText({name.data, name.length});
    Principled& out = look.principled;
    const std::optional<Vec3d> base = colorOf(material, "$clr.base", 1), diffuse = colorOf(material, "$clr.diffuse", 1);
    out.color = base ? *base : diffuse.value_or(Vec3d{1, 1, 1});
    out.emission = colorOf(material, "$clr.emissive", kMaxEmission).value_or(Vec3d{});
    const std::optional<double> metallic = numberOf(material, "$mat.metallicFactor"),
                                roughness = numberOf(material, "$mat.roughnessFactor");
    if (metallic || roughness) {
        out.metallic = std::clamp(metallic.value_or(0), 0.0, 1.0);
        out.roughness = std::clamp(roughness.value_or(0.5), 0.0, 1.0);
    } else {
        readClassic(material, look);
    }
    if (const std::optional<double> ior = numberOf(material, "$mat.refracti"); ior && *ior > 1)
        out.ior = std::min(*ior, 100.0);
    if (numberOf(material, "$mat.reflectivity").value_or(0) > 0) look.notes.push_back("its reflectivity is not read");
    nameTextures(material, look);
    return look;
}

}  // namespace penumbra
