#pragma once
// Makes small textured rigs: triangles that share no vertices, each with texture coordinates of its own.
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/image/image_file.h"
#include "tests/formats/rig_samples.h"

namespace penumbra::samples {

using Uv = std::array<float, 2>;

struct TexturedTriangle {
    std::array<Vec3, 3> corners;
    std::array<Uv, 3> uv;  // v points down
};

// Returns the bytes of a PNG whose pixels are these grey values, row by row from the top.
inline std::string greyPng(int width, const std::vector<int>& values) {
    Image image{width, int(values.size()) / width, {}, {}};
    for (const int value : values) {
        const float linear = linearFromSrgb(float(value) / 255);
        image.pixels.push_back({linear, linear, linear});
    }
    const std::filesystem::path path = std::filesystem::temp_directory_path() / "penumbra_grey.png";
    writePng(path, image, 1);
    const std::string bytes = readText(path);
    std::filesystem::remove(path);
    return bytes;
}

// Appends bytes as a buffer view and returns its index.
inline std::size_t addView(EditableGlb& glb, const std::string& bytes) {
    glb.binary.resize((glb.binary.size() + 3) / 4 * 4, '\0');
    glb.json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", glb.binary.size()}, {"byteLength", bytes.size()}});
    glb.binary += bytes;
    glb.json["buffers"][0]["byteLength"] = glb.binary.size();
    return glb.json["bufferViews"].size() - 1;
}

// Gives the only primitive an attribute of floats.
inline void addAttribute(EditableGlb& glb, const char* name, const char* type, int components,
                         const std::vector<float>& numbers) {
    const std::string bytes(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(float));
    nlohmann::json accessor{{"bufferView", addView(glb, bytes)},
                            {"componentType", 5126},
                            {"count", numbers.size() / std::size_t(components)},
                            {"type", type}};
    if (components == 3) accessor.update({{"min", {-1e3, -1e3, -1e3}}, {"max", {1e3, 1e3, 1e3}}});
    glb.json["accessors"].push_back(accessor);
    glb.attributes()[name] = glb.json["accessors"].size() - 1;
}

// A rig of one part without a skin, whose material "paint" has the picture `png` inside.
inline EditableGlb texturedRig(const std::vector<TexturedTriangle>& triangles, const std::string& png) {
    EditableGlb glb{nlohmann::json::parse(R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 0}],
        "bufferViews": [], "accessors": [], "scenes": [{"nodes": [0]}], "nodes": [{"name": "sheet", "mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {}, "material": 0}]}], "textures": [{"source": 0}],
        "materials": [{"name": "paint", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]})"),
                    ""};
    std::vector<float> positions, uv;
    for (const TexturedTriangle& triangle : triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            for (int c = 0; c < 3; ++c) positions.push_back(triangle.corners[k][c]);
            uv.insert(uv.end(), triangle.uv[k].begin(), triangle.uv[k].end());
        }
    addAttribute(glb, "POSITION", "VEC3", 3, positions);
    addAttribute(glb, "TEXCOORD_0", "VEC2", 2, uv);
    glb.json["images"] = {{{"bufferView", addView(glb, png)}, {"mimeType", "image/png"}}};
    return glb;
}

// A triangle of area 1/2, `x` metres to the right.
inline std::array<Vec3, 3> triangleAt(float x) { return {Vec3{x, 0, 0}, Vec3{x + 1, 0, 0}, Vec3{x, 1, 0}}; }

}  // namespace penumbra::samples
