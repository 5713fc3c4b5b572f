#include "formats/rig/rig_bytes.h"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstring>
#include <functional>
#include <map>
#include <stdexcept>
#include <type_traits>

namespace penumbra {

namespace {

// --- The fields of each struct, in one order for writing and reading ------------------------------------------------

template <class T, class Struct>
concept Is = std::same_as<std::remove_const_t<T>, Struct>;

void visit(auto& archive, Is<Node> auto& node) {
    archive(node.name, node.parent, node.translation, node.rotation, node.scale, node.matrix);
}
void visit(auto& archive, Is<SourceSkin> auto& skin) { archive(skin.nodes, skin.inverse_bind); }
void visit(auto& archive, Is<Texture> auto& texture) { archive(texture.name, texture.file, texture.bytes); }
void visit(auto& archive, Is<MaterialColor> auto& color) {
    archive(color.base, color.texture, color.wrap_u, color.wrap_v, color.problem);
    archive(color.alpha_mode, color.alpha_cutoff, color.alpha, color.double_sided);
}
void visit(auto& archive, Is<PartTexture> auto& picture) {
    archive(picture.role, picture.texture, picture.wrap_u, picture.wrap_v, picture.strength, picture.uv);
}
void visit(auto& archive, Is<PartColor> auto& color) {
    archive(color.material, color.uv, color.textures, color.textures_problem);
}
void visit(auto& archive, Is<Principled> auto& look) {
    archive(look.color, look.metallic, look.roughness, look.ior, look.specular, look.specular_color, look.emission);
}
void visit(auto& archive, Is<SourceLook> auto& look) {
    archive(look.material, look.principled, look.textures, look.notes, look.problem);
}
void visit(auto& archive, Is<SourcePart> auto& part) {
    archive(part.node, part.skin, part.material, part.color, part.positions, part.normals, part.triangles,
            part.influences, part.joints, part.weights, part.visible, part.look);
}
void visit(auto& archive, Is<Channel> auto& channel) {
    archive(channel.node, channel.path, channel.interpolation, channel.times, channel.values);
}
void visit(auto& archive, Is<Clip> auto& clip) { archive(clip.name, clip.duration, clip.channels); }
void visit(auto& archive, Is<RigNote> auto& note) { archive(note.file, note.node, note.feature, note.effect); }
void visit(auto& archive, Is<RigSource> auto& source) {
    archive(source.nodes, source.skins, source.parts, source.clips, source.notes);
}

// Numbers, enums, and arrays of these: their bytes are their value.
template <class T>
concept Plain = std::is_arithmetic_v<T> || std::is_enum_v<T> || std::same_as<T, std::byte> || std::same_as<T, Vec3> ||
    std::same_as<T, Vec3d> || requires(T value) {
    []<class U, std::size_t n>(const std::array<U, n>&) {}(value);
};

// Parts share textures. Each texture follows its first index, which counts from 1; 0 means no texture.
struct ByteWriter {
    std::vector<std::byte> bytes;
    std::map<const Texture*, std::uint32_t> index_of_texture = {{nullptr, 0}};

    void operator()(const auto&... values) { (put(values), ...); }

    void putRaw(const void* from, std::size_t size) {
        const auto* first = static_cast<const std::byte*>(from);
        bytes.insert(bytes.end(), first, first + size);
    }
    void put(const Plain auto& value) { putRaw(&value, sizeof value); }
    template <class T>
    void put(const std::vector<T>& list) {
        put(list.size());
        if constexpr (Plain<T>)
            putRaw(list.data(), list.size() * sizeof(T));
        else
            for (const T& value : list) put(value);
    }
    void put(const std::string& text) { put(std::vector<char>(text.begin(), text.end())); }
    void put(const std::filesystem::path& path) { put(path.string()); }
    template <class T>
    void put(const std::optional<T>& value) {
        put(std::uint8_t(value.has_value()));
        if (value) put(*value);
    }
    void put(const std::shared_ptr<const Texture>& texture) {
        const auto [at, is_new] = index_of_texture.try_emplace(texture.get(), std::uint32_t(index_of_texture.size()));
        put(at->second);
        if (is_new) put(*texture);
    }
    void put(const auto& record) { visit(*this, record); }
};

struct ByteReader {
    std::span<const std::byte> rest;
    std::vector<std::shared_ptr<const Texture>> textures = {nullptr};

    void operator()(auto&... values) { (get(values), ...); }

    void getRaw(void* to, std::size_t size) {
        if (size > rest.size()) throw std::out_of_range("the bytes end too early");
        if (size > 0) std::memcpy(to, rest.data(), size);
        rest = rest.subspan(size);
    }
    void get(Plain auto& value) { getRaw(&value, sizeof value); }
    void get(bool& flag) { flag = getFlag(); }
    template <class T>
    void get(std::vector<T>& list) {
        std::size_t count = 0;
        get(count);
        if constexpr (Plain<T>) {
            if (count > rest.size() / sizeof(T)) throw std::out_of_range("a list is longer than the bytes");
            list.resize(count);
            getRaw(list.data(), count * sizeof(T));
        } else {
            for (std::size_t i = 0; i < count; ++i) get(list.emplace_back());  // each takes bytes, so they end the loop
        }
    }
    void get(std::string& text) {
        std::vector<char> letters;
        get(letters);
        text.assign(letters.begin(), letters.end());
    }
    void get(std::filesystem::path& path) {
        std::string text;
        get(text);
        path = text;
    }
    template <class T>
    void get(std::optional<T>& value) {
        if (getFlag()) get(value.emplace());
    }
    void get(std::shared_ptr<const Texture>& texture) {
        std::uint32_t index = 0;
        get(index);
        if (index > textures.size()) throw std::out_of_range("a texture is missing");
        if (index == textures.size()) {
            auto made = std::make_shared<Texture>();
            get(*made);
            textures.push_back(std::move(made));
        }
        texture = textures[index];
    }
    void get(auto& record) { visit(*this, record); }

    bool getFlag() {
        std::uint8_t flag = 0;
        get(flag);
        return flag != 0;
    }
};

}  // namespace

std::vector<std::byte> bytesOf(const RigSource& source) {
    ByteWriter writer;
    writer(source);
    return std::move(writer.bytes);
}

RigSource rigFromBytes(std::span<const std::byte> bytes) {
    ByteReader reader{bytes};
    RigSource source;
    reader(source);
    if (!reader.rest.empty()) throw std::out_of_range("there are bytes behind the end");
    return source;
}

// --- Checks ---------------------------------------------------------------------------------------------------------

namespace {

bool isFinite(Vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

bool allFinite(const auto& numbers) {
    return std::all_of(numbers.begin(), numbers.end(), [](auto v) { return std::isfinite(v); });
}

// Indices are right unless an importer has overwritten its memory, so all of them share one message.
void requireSound(const RigSource& source, bool sound) {
    if (!sound) failAtFile(source.file, "cannot be read (importer crashed): an index or a count is wrong");
}

bool isIndex(int index, std::size_t count) { return index >= 0 && std::size_t(index) < count; }

void checkNodes(const RigSource& source) {
    for (std::size_t n = 0; n < source.nodes.size(); ++n) {
        const Node& node = source.nodes[n];
        requireSound(source, node.parent == -1 || isIndex(node.parent, n));
        if (!allFinite(node.translation) || !allFinite(node.rotation) || !allFinite(node.scale) ||
            (node.matrix && !allFinite(*node.matrix)))
            failAtNode(source, int(n), "its transform is not finite");
    }
}

void checkSkins(const RigSource& source) {
    for (const SourceSkin& skin : source.skins) {
        requireSound(source, skin.nodes.size() == skin.inverse_bind.size());
        for (std::size_t j = 0; j < skin.nodes.size(); ++j) {
            requireSound(source, isIndex(skin.nodes[j], source.nodes.size()));
            if (!allFinite(skin.inverse_bind[j])) failAtNode(source, skin.nodes[j], "its bind matrix is not finite");
        }
    }
}

void checkColor(const RigSource& source, const SourcePart& part) {
    const MaterialColor& color = part.color.material;
    requireSound(source, color.wrap_u <= TextureWrap::kClamp && color.wrap_v <= TextureWrap::kClamp);
    requireSound(source, color.alpha_mode <= AlphaMode::kBlend);
    requireSound(source, part.color.uv.size() == (color.texture ? part.positions.size() : 0));
    for (const auto& uv : part.color.uv) requireSound(source, allFinite(uv));
}

void checkInfluences(const RigSource& source, const SourcePart& part) {
    const std::size_t rows = part.skin < 0 ? 0 : part.positions.size();
    requireSound(source, part.influences >= 0 && part.joints.size() == rows * std::size_t(part.influences) &&
                             part.weights.size() == part.joints.size());
    for (const std::uint32_t joint : part.joints)
        requireSound(source, joint < source.skins[std::size_t(part.skin)].nodes.size());
}

void checkParts(const RigSource& source) {
    std::size_t vertices = 0;
    for (const SourcePart& part : source.parts) {
        requireSound(source, isIndex(part.node, source.nodes.size()));
        requireSound(source, part.skin == -1 || isIndex(part.skin, source.skins.size()));
        vertices += part.positions.size();
        requireSound(source, vertices <= kMaxSourceVertices);
        for (const Triangle& triangle : part.triangles)
            for (const std::uint32_t v : triangle)
                if (v >= part.positions.size()) failAtNode(source, part.node, "names a vertex that does not exist");
        for (std::size_t v = 0; v < part.positions.size(); ++v)
            if (!isFinite(part.positions[v]))
                failAtNode(source, part.node, "vertex " + std::to_string(v) + " is not finite");
        requireSound(source, part.normals.empty() || part.normals.size() == part.positions.size());
        requireSound(source, std::all_of(part.normals.begin(), part.normals.end(), isFinite));
        checkInfluences(source, part);
        checkColor(source, part);
    }
}

void checkChannel(const RigSource& source, const Clip& clip, const Channel& channel) {
    requireSound(source, isIndex(channel.node, source.nodes.size()));
    const Node& node = source.nodes[std::size_t(channel.node)];
    const bool rotates = channel.path == Channel::Path::kRotation;
    requireSound(source, !node.matrix && channel.path <= Channel::Path::kScale &&
                             channel.interpolation == Interpolation::kLinear && !channel.times.empty() &&
                             channel.values.size() == channel.times.size() * (rotates ? 4 : 3));
    const auto fail = [&](const char* problem) {
        failAtFile(source.file, "clip '" + clip.name + "': node '" + node.name + "': " + problem);
    };
    if (!allFinite(channel.times) ||
        std::adjacent_find(channel.times.begin(), channel.times.end(), std::greater_equal<>()) != channel.times.end())
        fail("key times do not ascend");
    if (!allFinite(channel.values)) fail("a key is not finite");
    for (std::size_t i = 0; rotates && i < channel.values.size(); i += 4)
        if (!normalized({channel.values[i], channel.values[i + 1], channel.values[i + 2], channel.values[i + 3]}))
            fail("a key is a quaternion of length 0");
}

}  // namespace

void checkSource(const RigSource& source) {
    checkNodes(source);
    checkSkins(source);
    checkParts(source);
    for (const Clip& clip : source.clips) {
        for (const Channel& channel : clip.channels) checkChannel(source, clip, channel);
        requireSound(source, std::isfinite(clip.duration) && clip.duration >= 0);
    }
}

}  // namespace penumbra
