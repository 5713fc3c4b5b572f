#include "formats/rig/gltf/rig_gltf_look.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>

#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {

using Json = nlohmann::json;

constexpr std::string_view kRead[] = {"KHR_materials_ior", "KHR_materials_specular", "KHR_materials_emissive_strength"};
constexpr const char* kGlossiness = "KHR_materials_pbrSpecularGlossiness";

// Reads numbers of a material and notes those that are out of range.
struct LookReader {
    SourceLook& look;

    double number(const Json& from, const char* key, double fallback, double most) const {
        const auto found = from.find(key);
        if (found == from.end()) return fallback;
        if (!found->is_number()) throw InvalidInput(std::string(key) + " is not a number");
        return inRange(key, found->get<double>(), most);
    }

    // Reads the first three of `count` numbers.
    Vec3d color(const Json& from, const char* key, Vec3d fallback, double most) const {
        const auto found = from.find(key);
        if (found == from.end()) return fallback;
        const auto values = found->get<std::vector<double>>();
        if (values.size() != 3 && values.size() != 4)
            throw InvalidInput(std::string(key) + " has " + std::to_string(values.size()) + " numbers");
        Vec3d out;
        for (int c = 0; c < 3; ++c) out[c] = inRange(key, values[std::size_t(c)], most);
        return out;
    }

    void texture(const Json& from, const char* key, const char* words) const {
        if (from.contains(key)) look.textures.emplace_back(words);
    }

private:
    double inRange(const char* key, double value, double most) const {
        if (value >= 0 && value <= most) return shortestOf(float(value));
        const double clamped = value > most ? most : 0;
        look.notes.push_back(std::string(key) + " is out of range; " + std::to_string(clamped) + " stands in");
        return clamped;
    }
};

// Returns a member that is an object, or an empty one where there is none.
Json objectAt(const Json& from, const char* key) {
    const auto found = from.find(key);
    if (found == from.end()) return Json::object();
    if (!found->is_object()) throw InvalidInput(std::string(key) + " is not an object");
    return *found;
}

constexpr double kMaxFactor = 1, kMaxSpecularColor = 1e3, kMaxEmission = 1e6;

// The defaults of glTF 2.0, section 5.22: white, metal and rough.
void readMetallicRoughness(const LookReader& reader, const Json& material) {
    const Json look = objectAt(material, "pbrMetallicRoughness");
    Principled& out = reader.look.principled;
    out.color = reader.color(look, "baseColorFactor", {1, 1, 1}, kMaxFactor);
    out.metallic = reader.number(look, "metallicFactor", 1, kMaxFactor);
    out.roughness = reader.number(look, "roughnessFactor", 1, kMaxFactor);
    reader.texture(look, "baseColorTexture", "base color");
    reader.texture(look, "metallicRoughnessTexture", "metallic-roughness");
}

// A dielectric of an infinite index reflects its specular colour at normal incidence, and all light at grazing
// incidence: that is what this extension asks for.
void readGlossiness(const LookReader& reader, const Json& extension) {
    Principled& out = reader.look.principled;
    out.color = reader.color(extension, "diffuseFactor", {1, 1, 1}, kMaxFactor);
    out.specular_color = reader.color(extension, "specularFactor", {1, 1, 1}, kMaxFactor);
    out.roughness = 1 - reader.number(extension, "glossinessFactor", 1, kMaxFactor);
    out.metallic = 0;
    out.ior = 0;
    reader.texture(extension, "diffuseTexture", "diffuse");
    reader.texture(extension, "specularGlossinessTexture", "specular-glossiness");
}

void readExtensions(const LookReader& reader, const Json& extensions) {
    Principled& out = reader.look.principled;
    out.ior = reader.number(objectAt(extensions, "KHR_materials_ior"), "ior", out.ior, 100);
    if (out.ior > 0 && out.ior < 1) {
        reader.look.notes.push_back("ior is out of range; 1 stands in");
        out.ior = 1;
    }
    if (const Json specular = objectAt(extensions, "KHR_materials_specular"); !specular.empty()) {
        out.specular = reader.number(specular, "specularFactor", 1, kMaxFactor);
        out.specular_color = reader.color(specular, "specularColorFactor", {1, 1, 1}, kMaxSpecularColor);
        reader.texture(specular, "specularTexture", "specular");
        reader.texture(specular, "specularColorTexture", "specular color");
    }
    out.emission *=
        reader.number(objectAt(extensions, "KHR_materials_emissive_strength"), "emissiveStrength", 1, kMaxEmission);
    for (int c = 0; c < 3; ++c) out.emission[c] = shortestOf(float(out.emission[c]));
}

// A colour that a picture makes dark in most places must not light the whole surface.
void readEmission(const LookReader& reader, const Json& material) {
    reader.look.principled.emission = reader.color(material, "emissiveFactor", {}, kMaxFactor);
    reader.texture(material, "emissiveTexture", "emissive");
}

void readAll(const LookReader& reader, const Json& material) {
    reader.look.material = cleanText(material.value("name", ""));
    const Json extensions = objectAt(material, "extensions");
    readEmission(reader, material);
    const bool glossy = extensions.contains(kGlossiness) && !material.contains("pbrMetallicRoughness");
    if (glossy) {
        readGlossiness(reader, objectAt(extensions, kGlossiness));
        reader.look.notes.push_back(std::string(kGlossiness) + " is read as diffuse, specular color and roughness");
    } else {
        readMetallicRoughness(reader, material);
    }
    readExtensions(reader, extensions);
    reader.texture(material, "normalTexture", "normal");
    reader.texture(material, "occlusionTexture", "occlusion");
    for (const GltfEffect& effect : unreadEffects(material))
        if (!(glossy && effect.feature == kGlossiness))
            reader.look.notes.push_back(effect.feature + " is not read: " + effect.effect);
}

// Describes what a picture loses without an extension that is known but not drawn. The extension changes nothing where
// `factor` is 0, which is its default.
struct KnownExtension {
    const char *name, *factor, *effect;
    bool in_bakes;
};
constexpr KnownExtension kKnown[] = {
    {"KHR_materials_transmission", "transmissionFactor", "it stops light as if it was opaque", true},
    {"KHR_materials_diffuse_transmission", "diffuseTransmissionFactor", "no light comes through it", true},
    {"KHR_materials_volume", "thicknessFactor", "light is neither bent nor absorbed inside of it", true},
    {"KHR_materials_unlit", nullptr, "it is shaded as any other surface", true},
    {"KHR_materials_clearcoat", "clearcoatFactor", "its clear coat does not shine", false},
    {"KHR_materials_sheen", "sheenColorFactor", "it does not shine as cloth does", false},
    {"KHR_materials_anisotropy", "anisotropyStrength", "its highlights are as long as wide", false},
    {"KHR_materials_iridescence", "iridescenceFactor", "its colours do not change with the angle", false},
    {"KHR_materials_dispersion", "dispersion", "it does not part light into colours", false},
    {kGlossiness, nullptr, "the metallic-roughness model of the same material is", false}};

bool isOff(const KnownExtension& known, const Json& extension) {
    if (!known.factor || !extension.is_object()) return false;
    const auto found = extension.find(known.factor);
    if (found == extension.end()) return true;
    const Json numbers = found->is_array() ? *found : Json::array({*found});
    return std::ranges::all_of(numbers, [](const Json& x) { return x.is_number() && !(x.get<double>() > 0); });
}

}  // namespace

std::vector<GltfEffect> unreadEffects(const Json& material) {
    std::vector<GltfEffect> out;
    const auto extensions = material.find("extensions");
    if (extensions == material.end() || !extensions->is_object()) return out;
    for (const auto& [name, value] : extensions->items()) {
        if (std::ranges::find(kRead, name) != std::end(kRead)) continue;
        const auto known = std::ranges::find(kKnown, name, &KnownExtension::name);
        if (known == std::end(kKnown))
            out.push_back({cleanText(name), "what it changes is not seen"});
        else if (!isOff(*known, value))
            out.push_back({name, known->effect, known->in_bakes});
    }
    return out;
}

SourceLook readGltfLook(const Json& material) {
    SourceLook look;
    try {
        readAll({look}, material);
    } catch (const Json::exception& error) {
        look.problem = error.what();
    } catch (const InvalidInput& error) {
        look.problem = error.what();
    }
    return look;
}

}  // namespace penumbra
