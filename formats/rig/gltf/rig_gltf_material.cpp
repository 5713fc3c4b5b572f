// Reads the base colours of glTF materials and where their textures are. A damaged material is no reason to refuse the
// rig, because only bakes of light that bounces need its colour: what is wrong with it is kept for then.
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "formats/common/errors.h"
#include "formats/rig/gltf/rig_gltf.h"
#include "formats/rig/gltf/rig_gltf_look.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {

using Json = nlohmann::json;

struct MaterialReader {
    const std::filesystem::path& path;
    const Json& document;
    std::span<const unsigned char> buffer;                                // the one that all buffer views are in
    std::map<std::size_t, std::shared_ptr<const Texture>> textures = {};  // images that were asked for so far

    [[noreturn]] static void fail(const std::string& problem) { throw InvalidInput(problem); }

    const Json& element(const char* list, const Json& index, const std::string& where) const {
        const auto found = document.find(list);
        const std::size_t count = found == document.end() || !found->is_array() ? 0 : found->size();
        if (!index.is_number_unsigned() || index.get<std::size_t>() >= count)
            fail(where + " " + index.dump() + " does not exist");
        return (*found)[index.get<std::size_t>()];
    }
};

std::vector<std::byte> viewBytes(const MaterialReader& reader, const Json& index, const std::string& where) {
    const Json& view = reader.element("bufferViews", index, where + ".bufferView");
    const std::size_t offset = view.value("byteOffset", std::size_t(0)), size = view.at("byteLength");
    const std::span<const std::byte> bytes = std::as_bytes(reader.buffer.subspan(offset, size));
    return {bytes.begin(), bytes.end()};
}

std::shared_ptr<const Texture> readImage(const MaterialReader& reader, const Json& index) {
    const Json& image = reader.element("images", index, "image");
    const std::string where = "images[" + index.dump() + "]";
    Texture texture;
    texture.name = where + (image.contains("name") ? " '" + cleanText(image.at("name")) + "'" : "");
    if (image.contains("bufferView")) {
        texture.bytes = viewBytes(reader, image.at("bufferView"), where);
    } else {
        const std::string uri = image.at("uri");
        if (uri.rfind("data:", 0) == 0) {
            const std::optional<std::vector<unsigned char>> bytes = decodeDataUri(uri);
            if (!bytes || bytes->empty()) reader.fail(where + ".uri cannot be decoded");
            const std::span<const std::byte> whole = std::as_bytes(std::span(*bytes));
            texture.bytes.assign(whole.begin(), whole.end());
        } else {
            if (uri.find("://") != std::string::npos) reader.fail(where + ".uri is at " + cleanText(uri));
            const std::string name = percentDecoded(uri);
            if (name.find('\0') != std::string::npos) reader.fail(where + ".uri is wrong");
            texture.file = reader.path.parent_path() / name;
        }
    }
    return std::make_shared<const Texture>(std::move(texture));
}

TextureWrap wrapOf(const MaterialReader& reader, const Json& sampler, const char* key) {
    switch (sampler.value(key, 10497)) {
        case 10497:
            return TextureWrap::kRepeat;
        case 33648:
            return TextureWrap::kMirror;
        case 33071:
            return TextureWrap::kClamp;
        default:
            reader.fail(std::string("sampler.") + key + " is " + sampler.at(key).dump());
    }
}

// Returns row-major 2x3. KHR_texture_transform scales, turns and moves. As v points down, its counter-clockwise turn is
// u cos + v sin, v cos - u sin; https://github.com/KhronosGroup/glTF/issues/1563 tells that the matrix in the
// text of the extension has the other sign, and all viewers this one.
std::array<double, 6> uvTransform(const Json& extension) {
    const auto offset = extension.value("offset", std::array<double, 2>{0, 0});
    const auto scale = extension.value("scale", std::array<double, 2>{1, 1});
    const double angle = extension.value("rotation", 0.0), c = std::cos(angle), s = std::sin(angle);
    return {c * scale[0], s * scale[1], offset[0], -s * scale[0], c * scale[1], offset[1]};
}

// Reads a textureInfo: the texture, its sampler, and which texture coordinates it takes. `what` names it.
PartTexture readTexture(MaterialReader& reader, const Json& info, const std::string& what, GltfUv& uv) {
    PartTexture out;
    const Json& texture = reader.element("textures", info.at("index"), "texture");
    if (!texture.contains("source")) reader.fail("its " + what + " texture has no PNG or JPEG picture");
    const Json& source = texture.at("source");
    std::shared_ptr<const Texture>& image =
        reader.textures[source.is_number_unsigned() ? source.get<std::size_t>() : 0];
    if (!image) image = readImage(reader, source);
    out.texture = image;
    if (texture.contains("sampler")) {
        const Json& sampler = reader.element("samplers", texture.at("sampler"), "sampler");
        out.wrap_u = wrapOf(reader, sampler, "wrapS");
        out.wrap_v = wrapOf(reader, sampler, "wrapT");
    }
    uv.set = info.value("texCoord", 0);
    const Json extensions = info.value("extensions", Json::object());
    if (const auto transform = extensions.find("KHR_texture_transform"); transform != extensions.end()) {
        uv.transform = uvTransform(*transform);
        uv.set = transform->value("texCoord", uv.set);
    }
    return out;
}

// Reads the pictures beside that of the base colour.
void readTextures(MaterialReader& reader, const Json& from, GltfMaterial& material) {
    struct Place {
        TextureRole role;
        const char *key, *what, *strength;
    };
    constexpr Place kPlaces[] = {
        {TextureRole::kMetallicRoughness, "metallicRoughnessTexture", "metalness and roughness", ""},
        {TextureRole::kNormal, "normalTexture", "normal", "scale"},
        {TextureRole::kEmissive, "emissiveTexture", "emissive", ""},
        {TextureRole::kOcclusion, "occlusionTexture", "occlusion", "strength"}};
    const Json metallic = from.value("pbrMetallicRoughness", Json::object());
    for (const Place& place : kPlaces) {
        const Json& look = place.role == TextureRole::kMetallicRoughness ? metallic : from;
        const auto info = look.find(place.key);
        if (info == look.end()) continue;
        GltfUv uv;
        PartTexture texture = readTexture(reader, *info, place.what, uv);
        texture.role = place.role;
        if (*place.strength) texture.strength = info->value(place.strength, 1.0f);
        if (!std::isfinite(texture.strength)) reader.fail(std::string(place.key) + " has a wrong " + place.strength);
        material.textures.push_back(std::move(texture));
        material.textures_uv.push_back(uv);
    }
}

// Keeps what is wrong with these pictures for those who want them: bakes need none.
void readTexturesOf(MaterialReader& reader, const Json& from, const std::string& where, GltfMaterial& material) try {
    readTextures(reader, from, material);
} catch (const Json::exception& error) {
    material.textures_problem = where + error.what();
} catch (const InvalidInput& error) {
    material.textures_problem = where + error.what();
}

// Reads the base colour, which is linear and white where the material does not tell it. The older extension of shiny
// materials has a diffuse colour in its place.
void readColor(MaterialReader& reader, const Json& from, GltfMaterial& material) {
    const Json extensions = from.value("extensions", Json::object());
    const auto shiny = extensions.find("KHR_materials_pbrSpecularGlossiness");
    const bool old = shiny != extensions.end() && !from.contains("pbrMetallicRoughness");
    const Json look = old ? *shiny : from.value("pbrMetallicRoughness", Json::object());
    const auto factor = look.value(old ? "diffuseFactor" : "baseColorFactor", std::vector<float>{1, 1, 1, 1});
    if (factor.size() != 4) reader.fail("its base colour has " + std::to_string(factor.size()) + " numbers");
    material.color.base = Vec3{factor[0], factor[1], factor[2]};
    material.color.alpha = factor[3];
    const auto texture = look.find(old ? "diffuseTexture" : "baseColorTexture");
    if (texture == look.end()) return;
    PartTexture picture = readTexture(reader, *texture, "base colour", material.uv);
    material.color.texture = std::move(picture.texture);
    material.color.wrap_u = picture.wrap_u;
    material.color.wrap_v = picture.wrap_v;
}

// Reads which sides a material is drawn on, and how it stops light. Every field is checked before any is set, but a
// damaged material may have holes: so whoever asks for its alpha meets the problem.
void readCoverage(const Json& from, MaterialColor& color) {
    color.alpha_mode = AlphaMode::kMask;
    const bool double_sided = from.value("doubleSided", false);
    const std::string mode = from.value("alphaMode", "OPAQUE");
    const float cutoff = from.value("alphaCutoff", 0.5f);
    if (mode != "OPAQUE" && mode != "MASK" && mode != "BLEND")
        MaterialReader::fail("alphaMode is '" + cleanText(mode) + "'");
    color.double_sided = double_sided;
    color.alpha_mode = mode == "MASK" ? AlphaMode::kMask : mode == "BLEND" ? AlphaMode::kBlend : AlphaMode::kOpaque;
    color.alpha_cutoff = cutoff;
}

// Returns the materials of the parts that have others to choose from. A mesh that is damaged is refused later.
std::set<std::size_t> variedMaterials(const Json& document) {
    std::set<std::size_t> out;
    try {
        for (const Json& mesh : document.value("meshes", Json::array()))
            for (const Json& primitive : mesh.value("primitives", Json::array()))
                if (primitive.contains("material") &&
                    primitive.value("extensions", Json::object()).contains("KHR_materials_variants"))
                    out.insert(primitive.at("material").get<std::size_t>());
    } catch (const Json::exception&) {
    }
    return out;
}

// Returns a colour that cannot be known, of which the coverage still is.
MaterialColor damagedColor(const MaterialColor& color, std::string problem) {
    MaterialColor out;
    out.alpha_mode = color.alpha_mode;
    out.alpha_cutoff = color.alpha_cutoff;
    out.double_sided = color.double_sided;
    out.problem = std::move(problem);
    return out;
}

// Returns the places of a primitive's vertices in a picture. `what` is the picture's name in messages.
std::vector<std::array<double, 2>> readTextureUv(const GltfFile& file, const tinygltf::Primitive& primitive,
                                                 const GltfUv& from, const std::string& where,
                                                 const std::string& what) {
    const std::size_t vertices = file.model.accessors[std::size_t(primitive.attributes.at("POSITION"))].count;
    const std::string name = "TEXCOORD_" + std::to_string(from.set);
    const auto uv = primitive.attributes.find(name);
    if (uv == primitive.attributes.end())
        failAtFile(file.path, where + ": has no " + name + ", which its " + what + " texture takes");
    const AccessorValues values = readAccessor(file, uv->second, where + " " + name);
    if (values.components != 2 || values.count() != vertices)
        failAtFile(file.path, where + ": " + name + " does not have 2 numbers for every vertex");
    std::vector<std::array<double, 2>> out;
    const std::array<double, 6>& m = from.transform;
    for (std::size_t at = 0; at < values.values.size(); at += 2) {
        const double u = values.values[at], v = values.values[at + 1];
        const std::array<double, 2> moved{m[0] * u + m[1] * v + m[2], m[3] * u + m[4] * v + m[5]};
        if (!(std::abs(moved[0]) < kFarthestUv && std::abs(moved[1]) < kFarthestUv))
            failAtFile(file.path, where + ": " + name + " of vertex " + std::to_string(at / 2) + " is out of range");
        out.push_back(moved);
    }
    return out;
}

void readPartTextures(const GltfFile& file, const tinygltf::Primitive& primitive, const std::string& where,
                      const GltfMaterial& material, SourcePart& part) try {
    PartColor& color = part.color;
    color.textures_problem = material.textures_problem;
    for (std::size_t i = 0; i < material.textures.size(); ++i) {
        PartTexture& texture = color.textures.emplace_back(material.textures[i]);
        texture.uv = readTextureUv(file, primitive, material.textures_uv[i], where, "further");
        if (texture.role == TextureRole::kNormal)
            color.turns = readTangentTurns(file, primitive, where, part, texture.uv);
    }
} catch (const InvalidInput& error) {
    part.color.textures_problem = error.what();
}

}  // namespace

std::vector<GltfMaterial> readMaterials(const std::filesystem::path& path, const nlohmann::json& document,
                                        std::span<const unsigned char> buffer) {
    MaterialReader reader{path, document, buffer};
    std::vector<GltfMaterial> materials;
    for (const Json& from : document.value("materials", Json::array())) {
        GltfMaterial& material = materials.emplace_back();
        material.look = readGltfLook(from);
        material.name = cleanText(from.value("name", ""));
        const std::string where = path.string() + ": materials[" + std::to_string(materials.size() - 1) + "]" +
                                  (material.name.empty() ? "" : " '" + material.name + "'") + ": ";
        try {
            readCoverage(from, material.color);
            readColor(reader, from, material);
            material.effects = unreadEffects(from);
            std::erase_if(material.effects, [](const GltfEffect& effect) { return !effect.in_bakes; });
            readTexturesOf(reader, from, where, material);
        } catch (const Json::exception& error) {
            material.color = damagedColor(material.color, where + error.what());
        } catch (const InvalidInput& error) {
            material.color = damagedColor(material.color, where + error.what());
        }
    }
    for (const std::size_t m : variedMaterials(document))
        if (m < materials.size())
            materials[m].look.notes.push_back(
                "KHR_materials_variants is not read: the part keeps this material, its default one");
    return materials;
}

void readPartColor(const GltfFile& file, const tinygltf::Primitive& primitive, const std::string& where,
                   SourcePart& part) try {
    GltfMaterial material;
    const bool has_material = primitive.material >= 0 && std::size_t(primitive.material) < file.materials.size();
    if (has_material) material = file.materials[std::size_t(primitive.material)];
    part.color.material = material.color;
    part.look = material.look;
    if (!has_material) {
        part.look = readGltfLook(nlohmann::json::object());
        part.look.notes.push_back("a part without a material: glTF's default stands in, a rough white metal");
    }
    if (const auto color = primitive.attributes.find("COLOR_0"); color != primitive.attributes.end()) {
        const AccessorValues values = readAccessor(file, color->second, where + " COLOR_0");
        if ((values.components != 3 && values.components != 4) || values.count() != part.positions.size())
            failAtFile(file.path, where + ": COLOR_0 does not have 3 or 4 numbers for every vertex");
        for (std::size_t at = 0; at < values.values.size(); at += std::size_t(values.components))
            part.color.tints.push_back(toFloat({values.values[at], values.values[at + 1], values.values[at + 2]}));
        for (std::size_t at = 3; values.components == 4 && at < values.values.size(); at += 4)
            part.color.alphas.push_back(float(values.values[at]));
        if (!has_material) part.color.material.base = Vec3{1, 1, 1};
    }
    if (material.color.texture) part.color.uv = readTextureUv(file, primitive, material.uv, where, "base colour");
    readPartTextures(file, primitive, where, material, part);
} catch (const InvalidInput& error) {
    part.color = {damagedColor(part.color.material, error.what()), {}, {}, {}, {}, ""};
}

}  // namespace penumbra
