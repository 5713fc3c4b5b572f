// Reads the triangles and the influences of a primitive.
#include <array>
#include <cmath>

#include "formats/rig/gltf/rig_gltf.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {

std::vector<std::uint32_t> readIndices(const GltfFile& file, const tinygltf::Primitive& primitive, std::size_t vertices,
                                       const std::string& where) {
    std::vector<std::uint32_t> indices;
    if (primitive.indices < 0) {
        for (std::size_t i = 0; i < vertices; ++i) indices.push_back(std::uint32_t(i));
        return indices;
    }
    const AccessorValues values = readAccessor(file, primitive.indices, where + " indices");
    if (values.components != 1) failAtFile(file.path, where + ": indices are not scalars");
    indices.reserve(values.values.size());
    for (const double v : values.values) {
        if (!(v >= 0) || v >= double(vertices) || v != std::floor(v))
            failAtFile(file.path, where + ": index " + std::to_string(std::int64_t(v)) + " of " +
                                      std::to_string(vertices) + " vertices");
        indices.push_back(std::uint32_t(v));
    }
    return indices;
}

}  // namespace

std::vector<Triangle> readTriangles(const GltfFile& file, const tinygltf::Primitive& primitive, std::size_t vertices,
                                    const std::string& where) {
    const std::vector<std::uint32_t> i = readIndices(file, primitive, vertices, where);
    std::vector<Triangle> triangles;
    triangles.reserve(primitive.mode == TINYGLTF_MODE_TRIANGLES ? i.size() / 3 : i.size());
    if (primitive.mode == TINYGLTF_MODE_TRIANGLES) {
        if (i.size() % 3 != 0) failAtFile(file.path, where + ": the number of indices is not a multiple of 3");
        for (std::size_t k = 0; k + 2 < i.size(); k += 3) triangles.push_back({i[k], i[k + 1], i[k + 2]});
    } else if (primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP) {  // every other triangle is turned: glTF 2.0, 3.7.2.1
        for (std::size_t k = 0; k + 2 < i.size(); ++k) triangles.push_back({i[k], i[k + 1 + k % 2], i[k + 2 - k % 2]});
    } else {
        for (std::size_t k = 1; k + 1 < i.size(); ++k) triangles.push_back({i[k], i[k + 1], i[0]});
    }
    return triangles;
}

namespace {

// Reads four numbers for every vertex into place `set` of each row of `part`. Accessors are read one after the other,
// since their numbers are doubles and a dense character has millions.
template <class Take>
void readFours(const GltfFile& file, int accessor, const std::string& where, const SourcePart& part, const Take& take) {
    const AccessorValues values = readAccessor(file, accessor, where);
    if (values.components != 4 || values.count() != part.positions.size())
        failAtFile(file.path, where + " does not have 4 numbers for every vertex");
    for (std::size_t i = 0; i < values.values.size(); ++i) take(i / 4, i % 4, values.values[i]);
}

}  // namespace

void readInfluences(const GltfFile& file, const tinygltf::Primitive& primitive, const std::string& where,
                    SourcePart& part) {
    std::vector<std::array<int, 2>> sets;
    for (int n = 0;; ++n) {
        const auto j = primitive.attributes.find("JOINTS_" + std::to_string(n));
        const auto w = primitive.attributes.find("WEIGHTS_" + std::to_string(n));
        if (j == primitive.attributes.end() && w == primitive.attributes.end()) break;
        if (j == primitive.attributes.end() || w == primitive.attributes.end())
            failAtFile(file.path,
                       where + ": has only one of JOINTS_" + std::to_string(n) + " and WEIGHTS_" + std::to_string(n));
        sets.push_back({j->second, w->second});
    }
    if (sets.empty()) failAtFile(file.path, where + ": has a skin but no JOINTS_0 and WEIGHTS_0");
    const std::size_t row = 4 * sets.size();
    part.influences = int(row);
    part.joints.resize(part.positions.size() * row);
    part.weights.resize(part.joints.size());
    for (std::size_t set = 0; set < sets.size(); ++set) {
        const std::string number = std::to_string(set);
        readFours(file, sets[set][0], where + ": JOINTS_" + number, part,
                  [&](std::size_t v, std::size_t k, double joint) {
                      if (joint < 0 || joint > 65535)
                          failAtFile(file.path, where + ": vertex " + std::to_string(v) + " names a wrong joint");
                      part.joints[v * row + 4 * set + k] = std::uint32_t(joint);
                  });
        readFours(file, sets[set][1], where + ": WEIGHTS_" + number, part,
                  [&](std::size_t v, std::size_t k, double weight) { part.weights[v * row + 4 * set + k] = weight; });
    }
}

}  // namespace penumbra
