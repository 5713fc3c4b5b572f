// Turns glTF bytes into a tinygltf model with one buffer and without images, materials or compression. So tinygltf
// reads no other file, and has little to do with a hostile one.
#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "formats/common/check_readable.h"
#include "formats/common/errors.h"
#include "formats/rig/gltf/rig_gltf.h"
#include "formats/rig/gltf/rig_meshopt.h"
#include "formats/rig/own_color.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

using Json = nlohmann::json;
using Bytes = std::vector<unsigned char>;

constexpr int kMaxJsonDepth = 64;

namespace {
struct Container {
    Json document;
    Bytes binary;
    bool has_binary = false;
};
struct Loader {
    std::filesystem::path path;
    std::vector<std::filesystem::path> files_read;

    [[noreturn]] void fail(const std::string& problem) const { failAtFile(path, problem); }
};

// Reads plain files only, since a buffer's URI may name a device that never ends.
Bytes readBytes(const std::filesystem::path& path) {
    checkReadable(path);
    std::ifstream in(path, std::ios::binary);
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    Bytes bytes(error ? 0 : std::size_t(size));  // at once: bytes that are appended take up to three times their size
    in.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(bytes.size()));
    bytes.resize(std::size_t(in.gcount()));
    if (in.bad() || !in.is_open()) throw IoError("cannot read " + path.string());
    return bytes;
}

Json parseJson(const Loader& loader, const char* first, std::size_t size) {
    const auto check_depth = [&](int depth, Json::parse_event_t, Json&) {
        if (depth > kMaxJsonDepth) loader.fail("its JSON is nested too deeply");
        return true;
    };
    Json document = Json::parse(first, first + size, check_depth);
    if (!document.is_object()) loader.fail("its JSON is not an object");
    return document;
}

std::uint32_t loadU32(const Bytes& bytes, std::size_t offset) {  // little-endian
    return std::uint32_t(bytes[offset]) | std::uint32_t(bytes[offset + 1]) << 8 |
           std::uint32_t(bytes[offset + 2]) << 16 | std::uint32_t(bytes[offset + 3]) << 24;
}

constexpr std::uint32_t kMagicGlb = 0x46546C67, kChunkJson = 0x4E4F534A, kChunkBinary = 0x004E4942;

// Splits 12 bytes of header (magic, version, length), then chunks of (length, type, bytes): JSON first, BIN second or
// absent.
Container splitGlb(const Loader& loader, Bytes&& bytes) {
    if (bytes.size() < 20) loader.fail("is cut short: no room for the header of a GLB");
    if (loadU32(bytes, 4) != 2) loader.fail("is GLB version " + std::to_string(loadU32(bytes, 4)) + ", not 2");
    const std::size_t length = loadU32(bytes, 8);
    if (length > bytes.size())
        loader.fail("is cut short: " + std::to_string(bytes.size()) + " of " + std::to_string(length) + " bytes");
    if (length < 20) loader.fail("has a wrong length in its GLB header");
    const std::size_t json_size = loadU32(bytes, 12);
    if (loadU32(bytes, 16) != kChunkJson || json_size > length - 20) loader.fail("has no JSON chunk");
    Container out{parseJson(loader, reinterpret_cast<const char*>(&bytes[0]) + 20, json_size), {}, false};
    const std::size_t next = 20 + json_size;
    if (length - next < 8) return out;
    const std::size_t binary_size = loadU32(bytes, next);
    if (loadU32(bytes, next + 4) != kChunkBinary) return out;
    if (binary_size > length - next - 8) loader.fail("its BIN chunk is cut short");
    bytes.resize(next + 8 + binary_size);
    bytes.erase(bytes.begin(), bytes.begin() + std::ptrdiff_t(next + 8));  // in place: a scan has hundreds of megabytes
    out.binary = std::move(bytes);
    out.has_binary = true;
    return out;
}

Container readContainer(const Loader& loader) {
    Bytes bytes = readBytes(loader.path);
    if (bytes.empty()) loader.fail("is empty");
    if (bytes.size() >= 4 && loadU32(bytes, 0) == kMagicGlb) return splitGlb(loader, std::move(bytes));
    if (loader.path.extension() == ".glb") loader.fail("is not a GLB file");
    return {parseJson(loader, reinterpret_cast<const char*>(bytes.data()), bytes.size()), {}, false};
}

bool startsWith(const std::string& text, const char* prefix) { return text.rfind(prefix, 0) == 0; }

// Accepts extensions that only tell how things look, the two that tell how numbers are stored, and those of
// rig_gltf_extensions.h.
bool isSupported(const std::string& extension) {
    for (const char* prefix : {"KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "EXT_lights_"})
        if (startsWith(extension, prefix)) return true;
    for (const char* known : {"KHR_mesh_quantization", "EXT_meshopt_compression", "KHR_node_visibility", "MSFT_lod",
                              "EXT_mesh_gpu_instancing", "KHR_animation_pointer"})
        if (extension == known) return true;
    return false;
}

void checkVersionAndExtensions(const Loader& loader, const Json& document) {
    const std::string version = document.at("asset").at("version");
    if (!startsWith(version, "2."))
        throw Unsupported(loader.path.string() + ": is glTF " + cleanText(version) + ", not 2.0");
    if (const std::string least = document.at("asset").value("minVersion", "2.0"); least != "2.0")
        throw Unsupported(loader.path.string() + ": asks for a reader of glTF " + cleanText(least) + ", not 2.0");
    for (const std::string extension : document.value("extensionsRequired", Json::array())) {
        if (isSupported(extension)) continue;
        const char* advice = extension == "KHR_draco_mesh_compression" ? " (decode it first: gltf-transform copy)" : "";
        throw Unsupported(loader.path.string() + ": requires the extension " + cleanText(extension) +
                          ", which Penumbra does not have" + advice);
    }
}

// Refuses indices that are no whole numbers. tinygltf passes over them, and the mesh, skin or material would be
// missing.
void checkIndices(const Loader& loader, const Json& document) {
    const auto check = [&](const Json& object, const char* name, const std::string& where) {
        const auto found = object.find(name);
        if (found != object.end() && !found->is_number_integer())
            loader.fail(where + ": " + name + " is " + cleanText(found->dump().substr(0, 40)) + ", no whole number");
    };
    const Json nodes = document.value("nodes", Json::array()), meshes = document.value("meshes", Json::array());
    for (std::size_t n = 0; n < nodes.size(); ++n)
        for (const char* name : {"mesh", "skin"}) check(nodes[n], name, "nodes[" + std::to_string(n) + "]");
    for (std::size_t m = 0; m < meshes.size(); ++m)
        for (const Json& primitive : meshes[m].value("primitives", Json::array()))
            for (const char* name : {"indices", "material", "mode"})
                check(primitive, name, "meshes[" + std::to_string(m) + "]: a primitive");
}

Bytes readUri(Loader& loader, const std::string& uri, const std::string& where) {
    if (startsWith(uri, "data:")) {
        std::optional<Bytes> bytes = decodeDataUri(uri);
        if (!bytes) loader.fail(where + " has a data URI that cannot be decoded");
        return std::move(*bytes);
    }
    if (uri.find("://") != std::string::npos)
        throw Unsupported(loader.path.string() + ": " + where + " is at " + cleanText(uri));
    const std::string name = percentDecoded(uri);
    if (name.find('\0') != std::string::npos) loader.fail(where + " has a wrong URI");
    const std::filesystem::path file = loader.path.parent_path() / name;
    Bytes bytes = readBytes(file);
    loader.files_read.push_back(file);
    return bytes;
}

std::size_t sizeField(const Loader& loader, const Json& object, const char* key, const std::string& where) {
    const auto it = object.find(key);
    if (it == object.end()) return 0;
    // Sizes must be below half the range of size_t, so that two of them can be added.
    if (!it->is_number_unsigned() || it->get<std::uint64_t>() > std::numeric_limits<std::size_t>::max() / 2)
        loader.fail(where + " has a wrong " + key);
    return it->get<std::size_t>();
}

const Json* meshoptExtension(const Json& object) {
    const auto extensions = object.find("extensions");
    if (extensions == object.end() || !extensions->is_object()) return nullptr;
    const auto meshopt = extensions->find("EXT_meshopt_compression");
    return meshopt == extensions->end() ? nullptr : &*meshopt;
}

bool hasCompressedViews(const Json& document) {
    const Json views = document.value("bufferViews", Json::array());
    return std::any_of(views.begin(), views.end(), [](const Json& view) { return meshoptExtension(view) != nullptr; });
}

Bytes readBuffer(Loader& loader, Container& container, std::size_t index) {
    const Json& buffer = container.document["buffers"][index];
    const std::string where = "buffer " + std::to_string(index);
    const std::size_t size = sizeField(loader, buffer, "byteLength", where);
    Bytes bytes;
    if (buffer.contains("uri"))
        bytes = readUri(loader, buffer.at("uri").get<std::string>(), where);
    else if (index == 0 && container.has_binary)
        bytes = std::move(container.binary);
    else if (meshoptExtension(buffer) != nullptr)
        return {};  // a fallback for readers without the extension, which has a size and no bytes
    else
        loader.fail(where + " has neither a URI nor a BIN chunk");
    if (bytes.size() < size)
        loader.fail(where + " is cut short: " + std::to_string(bytes.size()) + " of " + std::to_string(size) +
                    " bytes");
    bytes.resize(size);
    return bytes;
}

using Buffers = std::vector<std::span<const unsigned char>>;

std::span<const unsigned char> viewBytes(const Loader& loader, const Buffers& buffers, const Json& view,
                                         const std::string& where) {
    const std::size_t buffer = sizeField(loader, view, "buffer", where);
    if (buffer >= buffers.size())
        loader.fail(where + " names buffer " + std::to_string(buffer) + ", which does not exist");
    const std::size_t offset = sizeField(loader, view, "byteOffset", where);
    const std::size_t size = sizeField(loader, view, "byteLength", where);
    if (offset > buffers[buffer].size() || size > buffers[buffer].size() - offset)
        loader.fail(where + " reaches beyond its buffer");
    return buffers[buffer].subspan(offset, size);
}

Bytes decodeView(const Loader& loader, const Buffers& buffers, const Json& extension, const std::string& where) {
    const MeshoptView view{.count = sizeField(loader, extension, "count", where),
                           .stride = sizeField(loader, extension, "byteStride", where),
                           .mode = extension.value("mode", ""),
                           .filter = extension.value("filter", "NONE")};
    Bytes out;
    const std::string problem = decodeMeshopt(view, viewBytes(loader, buffers, extension, where), out);
    if (!problem.empty()) loader.fail(where + ": EXT_meshopt_compression: " + problem);
    return out;
}

// Puts all buffers behind one another into one. Buffer views move along, and compressed ones are decoded to the end.
Bytes mergeBuffers(Loader& loader, Container& container) {
    Json& document = container.document;
    std::vector<Bytes> owned;
    for (std::size_t i = 0; i < document.value("buffers", Json::array()).size(); ++i)
        owned.push_back(readBuffer(loader, container, i));
    Bytes merged;
    std::vector<std::size_t> start_of_buffer;
    Buffers buffers(owned.begin(), owned.end());
    if (owned.size() == 1 && !hasCompressedViews(document)) {
        // Nothing will be appended: the buffer is moved, not copied.
        merged = std::move(owned.front());
        owned.clear();
        buffers = {merged};
        start_of_buffer = {0};
    }
    for (const Bytes& buffer : owned) {
        start_of_buffer.push_back(merged.size());
        merged.insert(merged.end(), buffer.begin(), buffer.end());
    }
    Json views = Json::array();
    for (const Json& view : document.value("bufferViews", Json::array())) {
        const std::string where = "buffer view " + std::to_string(views.size());
        Json moved{{"buffer", 0}};
        if (const Json* extension = meshoptExtension(view)) {
            const Bytes decoded = decodeView(loader, buffers, *extension, where);
            moved.update({{"byteOffset", merged.size()}, {"byteLength", decoded.size()}});
            if (extension->value("mode", "") == "ATTRIBUTES") moved["byteStride"] = extension->at("byteStride");
            merged.insert(merged.end(), decoded.begin(), decoded.end());
        } else {
            const std::size_t size = viewBytes(loader, buffers, view, where).size();
            const std::size_t start = start_of_buffer[view.at("buffer").get<std::size_t>()];
            moved.update({{"byteOffset", start + sizeField(loader, view, "byteOffset", where)}, {"byteLength", size}});
            if (view.contains("byteStride")) moved["byteStride"] = view["byteStride"];
        }
        views.push_back(std::move(moved));
    }
    document["bufferViews"] = std::move(views);
    return merged;
}

// Takes the names of morph targets, which exporters put into extras, where they are texts.
Json targetNames(Json& object) {
    if (!object.contains("extras") || !object["extras"].is_object()) return {};
    Json names = object["extras"].value("targetNames", Json());
    const bool texts =
        names.is_array() && std::all_of(names.begin(), names.end(), [](const Json& name) { return name.is_string(); });
    return texts ? names : Json();
}

// Takes the colours that a primitive had before an export darkened them (own_color.h).
void takeOwnColor(Json& primitive) {
    const auto extras = primitive.find("extras"), attributes = primitive.find("attributes");
    if (extras == primitive.end() || !extras->is_object() || !extras->contains(kColorMark)) return;
    if ((*extras)[kColorMark] != kMarkOfOcclusion || attributes == primitive.end() || !attributes->is_object()) return;
    attributes->erase("COLOR_0");
    if (const auto own = attributes->find(kOwnColor); own != attributes->end()) (*attributes)["COLOR_0"] = Json(*own);
}

void dropExtensions(Json& objects) {
    for (Json& object : objects) {
        if (!object.is_object()) continue;
        takeOwnColor(object);
        Json names = targetNames(object);
        for (const char* key : {"extensions", "extras", "camera"}) object.erase(key);
        if (!names.empty()) object["extras"]["targetNames"] = std::move(names);
        if (object.contains("primitives")) dropExtensions(object["primitives"]);
    }
}

std::string geometryOnly(Json& document) {
    Json kept = Json::object();
    for (const char* key : {"asset", "extensionsUsed", "scene", "scenes", "nodes", "meshes", "skins", "animations",
                            "accessors", "bufferViews"})
        if (document.contains(key)) kept[key] = std::move(document[key]);
    for (const char* key : {"scenes", "nodes", "meshes", "skins", "animations", "accessors"})
        if (kept.contains(key)) dropExtensions(kept[key]);
    return kept.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void parseModel(const Loader& loader, const std::string& text, Bytes&& buffer, tinygltf::Model& model) {
    tinygltf::TinyGLTF parser;
    std::string errors, warnings;
    if (text.size() > std::numeric_limits<unsigned>::max()) loader.fail("its JSON is too long");
    if (!parser.LoadASCIIFromString(&model, &errors, &warnings, text.c_str(), unsigned(text.size()), "")) {
        std::replace(errors.begin(), errors.end(), '\n', ' ');
        loader.fail("is not valid glTF: " + errors);
    }
    model.buffers.resize(1);
    model.buffers[0].data = std::move(buffer);
}

// Two materials may have one name. The second "skin" becomes "skin#2".
void makeNamesUnique(std::vector<GltfMaterial>& materials) {
    std::vector<std::string> names;
    for (std::size_t m = 0; m < materials.size(); ++m)
        names.push_back(materials[m].name.empty() ? "material" + std::to_string(m) : materials[m].name);
    names = uniqueNames(std::move(names));
    for (std::size_t m = 0; m < materials.size(); ++m) materials[m].name = names[m];
}

}  // namespace

std::string percentDecoded(const std::string& uri) {
    std::string out;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        const bool escape = uri[i] == '%' && i + 2 < uri.size() &&
                            std::isxdigit(static_cast<unsigned char>(uri[i + 1])) &&
                            std::isxdigit(static_cast<unsigned char>(uri[i + 2]));
        out += escape ? char(std::stoi(uri.substr(i + 1, 2), nullptr, 16)) : uri[i];
        if (escape) i += 2;
    }
    return out;
}

bool hasOnlyMorphClips(const std::filesystem::path& path) try {
    Json document = readContainer(Loader{path, {path}}).document;
    (void)resolvePointers(path, document);
    for (const Json& node : document.value("nodes", Json::array()))
        if (node.contains("skin")) return false;
    bool any = false;
    for (const Json& clip : document.value("animations", Json::array()))
        for (const Json& channel : clip.value("channels", Json::array())) {
            any = channel.value("target", Json::object()).value("path", "") == "weights";
            if (!any) return false;
        }
    return any;
} catch (const Json::exception&) {
    return false;
} catch (const InvalidInput&) {
    return false;
} catch (const IoError&) {
    return false;
}

GltfFile openGltf(const std::filesystem::path& path) {
    Loader loader{path, {path}};
    GltfFile file;
    try {
        Container container = readContainer(loader);
        checkVersionAndExtensions(loader, container.document);
        checkIndices(loader, container.document);
        Bytes buffer = mergeBuffers(loader, container);
        file.materials = readMaterials(path, container.document, buffer);
        file.node_extensions = readNodeExtensions(path, container.document);
        file.notes = resolvePointers(path, container.document);
        makeNamesUnique(file.materials);
        parseModel(loader, geometryOnly(container.document), std::move(buffer), file.model);
    } catch (const Json::exception& error) {
        loader.fail(std::string("is not valid glTF: ") + error.what());
    }
    file.path = path;
    file.files_read = std::move(loader.files_read);
    return file;
}

}  // namespace penumbra
