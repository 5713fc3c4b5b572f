#pragma once
// Writes small glTF files that a test makes up: GlbWriter collects accessors and nodes.
#include <span>

#include "tests/bake/shapes.h"
#include "tests/formats/rig_samples.h"

namespace penumbra::samples {

struct GlbWriter {
    EditableGlb glb{{{"asset", {{"version", "2.0"}}},
                     {"scene", 0},
                     {"scenes", {{{"nodes", nlohmann::json::array()}}}},
                     {"nodes", nlohmann::json::array()},
                     {"meshes", nlohmann::json::array()},
                     {"accessors", nlohmann::json::array()},
                     {"bufferViews", nlohmann::json::array()}},
                    ""};

    // Adds an accessor of floats, or of unsigned integers.
    template <class T>
    int accessor(std::span<const T> numbers, const char* type, std::size_t components) {
        const bool floats = std::is_same_v<T, float>;
        auto& json = glb.json;
        json["bufferViews"].push_back(
            {{"buffer", 0}, {"byteOffset", glb.binary.size()}, {"byteLength", numbers.size_bytes()}});
        glb.binary.append(reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes());
        json["accessors"].push_back({{"bufferView", json["bufferViews"].size() - 1},
                                     {"componentType", floats ? 5126 : 5125},
                                     {"count", numbers.size() / components},
                                     {"type", type}});
        return int(json["accessors"].size()) - 1;
    }
    int vectors(const std::vector<Vec3>& list) {
        return accessor(std::span(&list.data()->x, 3 * list.size()), "VEC3", 3);
    }
    int quaternions(const std::vector<float>& list) { return accessor(std::span(list), "VEC4", 4); }
    int scalars(const std::vector<float>& list) { return accessor(std::span(list), "SCALAR", 1); }

    int mesh(const shapes::Shape& shape) {
        const int positions = vectors(shape.positions);
        const int corners =
            accessor(std::span(shape.triangles.data()->data(), 3 * shape.triangles.size()), "SCALAR", 1);
        glb.json["meshes"].push_back(
            {{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"indices", corners}}}}});
        return int(glb.json["meshes"].size()) - 1;
    }
    // Adds a node to the scene, or below `parent`.
    int node(const std::string& name, int mesh = -1, int parent = -1) {
        nlohmann::json node{{"name", name}};
        if (mesh >= 0) node["mesh"] = mesh;
        auto& nodes = glb.json["nodes"];
        nodes.push_back(node);
        const int index = int(nodes.size()) - 1;
        if (parent < 0)
            glb.json["scenes"][0]["nodes"].push_back(index);
        else
            nodes[std::size_t(parent)]["children"].push_back(index);
        return index;
    }
    // Adds a clip with one channel.
    void clip(const std::string& name, const nlohmann::json& target, int times, int values,
              const char* interpolation = "LINEAR") {
        glb.json["animations"].push_back(
            {{"name", name},
             {"samplers", {{{"input", times}, {"output", values}, {"interpolation", interpolation}}}},
             {"channels", {{{"sampler", 0}, {"target", target}}}}});
    }
    nlohmann::json& extensionsOf(int node) { return glb.json["nodes"][std::size_t(node)]["extensions"]; }

    std::filesystem::path save(const std::string& name) {
        glb.json["buffers"] = {{{"byteLength", glb.binary.size()}}};
        const std::filesystem::path path = std::filesystem::temp_directory_path() / ("penumbra_" + name + ".glb");
        writeText(path, glb.bytes());
        return path;
    }
};

}  // namespace penumbra::samples
