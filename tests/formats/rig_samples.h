#pragma once
// The synthetic rigs (data-samples/README.md), and GLB files that a test changes before it reads them.
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "formats/rig/rig_build.h"
#include "formats/source/source_readers.h"

namespace penumbra::samples {

inline std::filesystem::path samplePath(const std::string& name) {
    return std::filesystem::path(PENUMBRA_BINARY_DIR) / ".." / "samples" / (name + ".glb");
}

inline Rig readSample(const std::string& name) { return readRig({samplePath(name)}); }

// Reads a file of any format, an FBX file as assimp has it, be that right or not: swing_pivot.fbx is refused where the
// converter is not there, because assimp is right about it at its keys alone.
inline Rig readAny(const std::string& file_name) {
    const std::filesystem::path path = samplePath("bend").replace_filename(file_name);
    std::vector<RigSource> sources;
    if (path.extension() != ".fbx") return readRig({path});
    sources.push_back(readWithAssimp(path));
    return joinRig(std::move(sources), {});
}

inline std::string readText(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

// A new file each time: a disk with ext4 writes out at once what replaces the contents of a file.
inline void writeText(const std::filesystem::path& path, const std::string& text) {
    std::filesystem::remove(path);
    std::ofstream(path, std::ios::binary) << text;
}

// A triangle of node 0, with as many joints as influences, all of equal weight.
inline RigSource skinnedTriangle(int influences) {
    RigSource source;
    source.file = "f.glb";
    SourceSkin& skin = source.skins.emplace_back();
    SourcePart& part = source.parts.emplace_back();
    part.skin = 0;
    part.influences = influences;
    part.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    part.triangles = {{0, 1, 2}};
    for (int j = 0; j < influences; ++j) {
        source.nodes.emplace_back().name = "n" + std::to_string(j);
        skin.nodes.push_back(j);
        skin.inverse_bind.push_back(kIdentityMatrix);
    }
    for (int i = 0; i < 3 * influences; ++i) {
        part.joints.push_back(std::uint32_t(i % influences));
        part.weights.push_back(1);
    }
    return source;
}

struct EditableGlb {
    nlohmann::json json;
    std::string binary;

    static EditableGlb of(const std::string& sample) {
        const std::string bytes = readText(samplePath(sample));
        std::uint32_t json_size = 0;
        std::memcpy(&json_size, bytes.data() + 12, 4);
        return {nlohmann::json::parse(bytes.substr(20, json_size)), bytes.substr(28 + json_size)};
    }

    std::string bytes() const {
        std::string text = json.dump(), data = binary;
        text.resize((text.size() + 3) / 4 * 4, ' ');
        data.resize((data.size() + 3) / 4 * 4, '\0');
        const auto u32 = [](std::size_t v) {
            const std::uint32_t value = std::uint32_t(v);
            return std::string(reinterpret_cast<const char*>(&value), 4);
        };
        return "glTF" + u32(2) + u32(28 + text.size() + data.size()) + u32(text.size()) + "JSON" + text +
               u32(data.size()) + std::string("BIN\0", 4) + data;
    }

    // Returns where the bytes of an accessor start in `binary`.
    std::size_t offsetOf(int accessor) const {
        const auto& a = json["accessors"][std::size_t(accessor)];
        const auto& view = json["bufferViews"][a["bufferView"].get<std::size_t>()];
        return view.value("byteOffset", std::size_t(0)) + a.value("byteOffset", std::size_t(0));
    }

    nlohmann::json& attributes() { return json["meshes"][0]["primitives"][0]["attributes"]; }
};

}  // namespace penumbra::samples
