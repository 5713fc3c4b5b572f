// Adds to glTF files without losing extensions, extras and orders that no reader of ours knows. The JSON is kept as an
// ordered tree, to which entries are added, and the binary chunk as bytes, behind which others are put. The indices of
// everything in the file stay as they are.
#include "formats/rig/growing_glb.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>

#include "formats/common/check_readable.h"
#include "formats/common/errors.h"
#include "formats/rig/gltf/rig_gltf.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {

using GlbJson = nlohmann::ordered_json;
using GlbBytes = std::vector<unsigned char>;

constexpr std::uint32_t kGlbMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr int kDeepestJson = 64;

GlbBytes bytesOfFile(const std::filesystem::path& path) {
    checkReadable(path);
    std::ifstream in(path, std::ios::binary | std::ios::ate);
    GlbBytes bytes(in.is_open() ? std::size_t(std::max<std::streamoff>(0, in.tellg())) : 0);
    in.seekg(0);
    in.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(bytes.size()));
    if (!in) throw IoError("cannot read " + path.string());
    return bytes;
}

std::uint32_t numberAt(const GlbBytes& bytes, std::size_t at) {  // little-endian
    std::uint32_t number = 0;
    for (std::size_t i = 4; i-- > 0;) number = number << 8 | bytes[at + i];
    return number;
}

void putNumber(std::size_t number, std::vector<std::byte>& out) {
    for (int i = 0; i < 4; ++i) out.push_back(std::byte(number >> (8 * i) & 0xff));
}

void padTo4(GlbBytes& bytes) { bytes.resize((bytes.size() + 3) / 4 * 4); }

GlbJson parseDocument(const std::filesystem::path& path, const unsigned char* first, std::size_t size) {
    const auto check_depth = [&](int depth, GlbJson::parse_event_t, GlbJson&) {
        if (depth > kDeepestJson) failAtFile(path, "its JSON is nested too deeply");
        return true;
    };
    GlbJson document = GlbJson::parse(first, first + size, check_depth);
    if (!document.is_object()) failAtFile(path, "its JSON is not an object");
    return document;
}

// Reads the chunks. Returns whether there is a binary one.
bool readChunks(const GlbBytes& bytes, GrowingGlb& glb) {
    if (bytes.size() < 20 || numberAt(bytes, 0) != kGlbMagic) {
        glb.document = parseDocument(glb.path, bytes.data(), bytes.size());
        return false;
    }
    const std::size_t length = numberAt(bytes, 8), json = numberAt(bytes, 12);
    if (length > bytes.size() || length < 20 || numberAt(bytes, 16) != kJsonChunk || json > length - 20)
        failAtFile(glb.path, "is cut short, or has no JSON chunk");
    glb.document = parseDocument(glb.path, bytes.data() + 20, json);
    std::size_t at = 20 + json;
    bool has_binary = false;
    if (length - at >= 8 && numberAt(bytes, at + 4) == kBinaryChunk) {
        const std::size_t size = numberAt(bytes, at);
        if (size > length - at - 8) failAtFile(glb.path, "its BIN chunk is cut short");
        glb.binary.assign(bytes.begin() + std::ptrdiff_t(at + 8), bytes.begin() + std::ptrdiff_t(at + 8 + size));
        at += 8 + size;
        has_binary = true;
    }
    glb.chunks.assign(bytes.begin() + std::ptrdiff_t(at), bytes.begin() + std::ptrdiff_t(length));
    if (glb.chunks.size() < 8) glb.chunks.clear();  // padding
    return has_binary;
}

// Returns the bytes that a URI stands for, or nothing where it leads out of the machine.
std::optional<GlbBytes> bytesOfUri(GrowingGlb& glb, const std::string& uri) {
    if (uri.starts_with("data:")) return decodeDataUri(uri);
    if (uri.find("://") != std::string::npos) return std::nullopt;
    const std::string name = percentDecoded(uri);
    if (name.find('\0') != std::string::npos) return std::nullopt;
    const std::filesystem::path file = glb.path.parent_path() / name;
    GlbBytes bytes = bytesOfFile(file);
    glb.files_read.push_back(file);
    return bytes;
}

GlbJson& listOf(GlbJson& document, const char* key) {
    if (!document.contains(key)) document[key] = GlbJson::array();
    return document[key];
}

// Where the bytes of an old buffer went: into which buffer, and behind how many bytes of it.
struct NewPlace {
    std::size_t buffer = 0, start = 0;
};

void moveView(const std::filesystem::path& path, const std::vector<NewPlace>& places, GlbJson& view) {
    const auto buffer = view.at("buffer").get<std::size_t>();
    if (buffer >= places.size()) failAtFile(path, "a buffer view names a buffer that does not exist");
    view["buffer"] = places[buffer].buffer;
    if (places[buffer].start > 0) view["byteOffset"] = view.value("byteOffset", std::size_t(0)) + places[buffer].start;
}

// Puts all buffers that have bytes into the binary chunk. Others, which are there for readers without an extension,
// stay behind it.
void takeBuffers(GrowingGlb& glb, bool has_binary) {
    GlbJson& buffers = listOf(glb.document, "buffers");
    GlbBytes merged;
    std::vector<NewPlace> places;
    GlbJson kept = GlbJson::array({GlbJson::object()});
    for (std::size_t i = 0; i < buffers.size(); ++i) {
        GlbJson& buffer = buffers[i];
        const bool own = i == 0 && has_binary && !buffer.contains("uri");
        if (!own && !buffer.contains("uri")) {
            places.push_back({kept.size(), 0});
            kept.push_back(buffer);
            continue;
        }
        std::optional<GlbBytes> bytes =
            own ? std::move(glb.binary) : bytesOfUri(glb, buffer.at("uri").get<std::string>());
        if (merged.empty()) {  // the first one's name and extras stay
            kept[0] = buffer;
            kept[0].erase("uri");
        }
        const auto size = buffer.at("byteLength").get<std::size_t>();
        if (!bytes || bytes->size() < size)
            failAtFile(glb.path, "buffer " + std::to_string(i) + " is missing or cut short");
        padTo4(merged);
        places.push_back({0, merged.size()});
        merged.insert(merged.end(), bytes->begin(), bytes->begin() + std::ptrdiff_t(size));
    }
    kept[0]["byteLength"] = merged.size();
    buffers = std::move(kept);
    for (GlbJson& view : listOf(glb.document, "bufferViews")) {
        moveView(glb.path, places, view);
        for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
            if (view.contains("extensions") && view["extensions"].contains(extension))
                moveView(glb.path, places, view["extensions"][extension]);
    }
    glb.binary = std::move(merged);
}

const char* mimeTypeOf(const GlbBytes& bytes) {
    const auto begins = [&](std::initializer_list<int> magic) {
        return bytes.size() >= magic.size() &&
               std::equal(magic.begin(), magic.end(), bytes.begin(), [](int a, unsigned char b) { return a == b; });
    };
    if (begins({0x89, 'P', 'N', 'G'})) return "image/png";
    if (begins({0xff, 0xd8})) return "image/jpeg";
    if (begins({0xab, 'K', 'T', 'X'})) return "image/ktx2";
    if (begins({'R', 'I', 'F', 'F'})) return "image/webp";
    return nullptr;
}

std::size_t addView(GrowingGlb& glb, const unsigned char* bytes, std::size_t size) {
    padTo4(glb.binary);
    GlbJson& views = listOf(glb.document, "bufferViews");
    views.push_back({{"buffer", 0}, {"byteOffset", glb.binary.size()}, {"byteLength", size}});
    glb.binary.insert(glb.binary.end(), bytes, bytes + size);
    return views.size() - 1;
}

// Takes the pictures that lie in other files into the binary chunk. Returns how many.
std::size_t takePictures(GrowingGlb& glb) {
    std::size_t taken = 0;
    if (!glb.document.contains("images")) return taken;
    for (GlbJson& image : glb.document["images"]) {
        if (!image.contains("uri")) continue;
        const std::string uri = image.at("uri").get<std::string>();
        if (uri.starts_with("data:")) continue;
        std::optional<GlbBytes> bytes;
        try {
            bytes = bytesOfUri(glb, uri);
        } catch (const IoError&) {
        }
        const char* type = bytes ? mimeTypeOf(*bytes) : nullptr;
        if (!type) {
            glb.notes.push_back(glb.path.string() + ": the picture '" + cleanText(uri) +
                                "' is not taken into the file, and is looked for beside it");
            continue;
        }
        image.erase("uri");
        image["bufferView"] = addView(glb, bytes->data(), bytes->size());
        image["mimeType"] = type;
        ++taken;
    }
    return taken;
}

}  // namespace

GrowingGlb openGrowingGlb(const std::filesystem::path& path) {
    GrowingGlb glb;
    glb.path = path;
    glb.files_read = {path};
    try {
        const bool has_binary = readChunks(bytesOfFile(path), glb);
        GlbJson& buffers = listOf(glb.document, "buffers");
        const auto has_uri = [](const GlbJson& buffer) { return buffer.contains("uri"); };
        const bool elsewhere = std::any_of(buffers.begin(), buffers.end(), has_uri);
        if (elsewhere || !has_binary || buffers.empty())
            takeBuffers(glb, has_binary);
        else if (const auto size = buffers[0].at("byteLength").get<std::size_t>(); size <= glb.binary.size())
            glb.binary.resize(size);
        else
            failAtFile(path, "its BIN chunk is shorter than its buffer");
        const std::size_t pictures = takePictures(glb);
        if (elsewhere || pictures > 0)
            glb.notes.push_back(path.string() + ": its buffers and pictures are taken into one file");
    } catch (const nlohmann::json::exception& error) {
        failAtFile(path, std::string("is not valid glTF: ") + error.what());
    }
    return glb;
}

namespace {

const char* accessorType(int components) {
    constexpr std::array kTypes = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    return kTypes.at(std::size_t(components - 1));
}

}  // namespace

std::size_t addAccessor(GrowingGlb& glb, std::span<const float> numbers, int components, AccessorUse use) {
    static_assert(std::endian::native == std::endian::little);
    const std::size_t view = addView(glb, reinterpret_cast<const unsigned char*>(numbers.data()), numbers.size_bytes());
    constexpr int kFloat = 5126, kVertexBuffer = 34962;
    if (use == AccessorUse::kVertices) glb.document["bufferViews"][view]["target"] = kVertexBuffer;
    GlbJson accessor{{"bufferView", view},
                     {"componentType", kFloat},
                     {"count", numbers.size() / std::size_t(components)},
                     {"type", accessorType(components)}};
    if (use == AccessorUse::kTimes) {
        const auto [low, high] = std::minmax_element(numbers.begin(), numbers.end());
        accessor["min"] = {*low};
        accessor["max"] = {*high};
    }
    GlbJson& accessors = listOf(glb.document, "accessors");
    accessors.push_back(std::move(accessor));
    return accessors.size() - 1;
}

std::size_t addZeros(GrowingGlb& glb, std::size_t count, int components) {
    const std::vector<int> zeros(std::size_t(components), 0);
    GlbJson& accessors = listOf(glb.document, "accessors");
    accessors.push_back({{"componentType", 5126},
                         {"count", count},
                         {"type", accessorType(components)},
                         {"min", zeros},
                         {"max", zeros}});
    return accessors.size() - 1;
}

std::size_t addBytes(GrowingGlb& glb, std::span<const std::byte> bytes) {
    return addView(glb, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
}

std::vector<std::byte> bytesOf(const GrowingGlb& glb) {
    GlbJson document = glb.document;
    document["buffers"][0]["byteLength"] = glb.binary.size();
    std::string text = document.dump(-1, ' ', false, GlbJson::error_handler_t::replace);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::size_t padded = (glb.binary.size() + 3) / 4 * 4;
    const std::size_t size = 12 + 8 + text.size() + 8 + padded + glb.chunks.size();
    if (size > std::numeric_limits<std::uint32_t>::max())
        throw Unsupported(glb.path.string() + ": would be larger than the 4 GiB of a .glb");
    std::vector<std::byte> out;
    out.reserve(size);
    for (const std::size_t number :
         {std::size_t(kGlbMagic), std::size_t(2), size, text.size(), std::size_t(kJsonChunk)})
        putNumber(number, out);
    const auto* json = reinterpret_cast<const std::byte*>(text.data());
    out.insert(out.end(), json, json + text.size());
    for (const std::size_t number : {padded, std::size_t(kBinaryChunk)}) putNumber(number, out);
    const auto append = [&](const GlbBytes& bytes) {
        const auto* first = reinterpret_cast<const std::byte*>(bytes.data());
        out.insert(out.end(), first, first + bytes.size());
    };
    append(glb.binary);
    out.resize(out.size() + padded - glb.binary.size());
    append(glb.chunks);
    return out;
}

}  // namespace penumbra
