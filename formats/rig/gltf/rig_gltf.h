#pragma once
// The parts of the glTF importer: the container (bytes to a tinygltf model with one buffer), accessors, and the
// scene.
#include <tiny_gltf.h>

#include <array>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/rig/gltf/rig_gltf_extensions.h"
#include "formats/rig/gltf/rig_gltf_look.h"
#include "formats/rig/rig_file.h"
#include "formats/rig/source_look.h"

namespace penumbra {

// Which texture coordinates a picture takes.
struct GltfUv {
    int set = 0;                                        // n in TEXCOORD_n
    std::array<double, 6> transform{1, 0, 0, 0, 1, 0};  // row-major 2x3, from these to the texture's coordinates
};

struct GltfMaterial {
    std::string name;                 // "" where it has none
    std::vector<GltfEffect> effects;  // in bakes
    MaterialColor color;
    SourceLook look;
    GltfUv uv;                          // for the base colour
    std::vector<PartTexture> textures;  // without coordinates
    std::vector<GltfUv> textures_uv;    // one for each
    std::string textures_problem;       // see PartColor
};

struct GltfFile {
    std::filesystem::path path;  // for messages
    tinygltf::Model model;       // without materials and images; one buffer; no compression left
    std::vector<GltfMaterial> materials;
    std::vector<GltfNodeExtensions> node_extensions;  // one for each node
    std::vector<RigNote> notes;
    std::vector<std::filesystem::path> files_read;
};

// Reads .glb (which it knows by its magic) or .gltf with the buffers that it names, and decodes
// EXT_meshopt_compression. Throws IoError, InvalidInput, and Unsupported for required extensions that we do not have.
GltfFile openGltf(const std::filesystem::path& path);

// Reads the materials of a document whose buffer views are all in `buffer` and inside it.
std::vector<GltfMaterial> readMaterials(const std::filesystem::path& path, const nlohmann::json& document,
                                        std::span<const unsigned char> buffer);
std::string percentDecoded(const std::string& uri);
// Returns the bytes of a data URI of any type or of none, or nothing where it is damaged (rig_data_uri.cpp).
std::optional<std::vector<unsigned char>> decodeDataUri(const std::string& uri);

struct AccessorValues {
    int components = 0;          // numbers of one element
    std::vector<double> values;  // [count, components]; normalised integers are in [-1, 1] already
    std::size_t count() const { return values.size() / std::size_t(components); }
};
// Reads an accessor, also a sparse or strided one. Every byte is checked to lie inside its buffer view. `what` names
// the accessor in messages ("mesh 'Body' POSITION").
AccessorValues readAccessor(const GltfFile& file, int accessor, const std::string& what);
// The same, but numbers need not be finite.
AccessorValues readAnyNumbers(const GltfFile& file, int accessor, const std::string& what);

struct SourcePart;
struct RigSource;
// Reads triangles of a list, a strip or a fan, of `vertices` vertices.
std::vector<Triangle> readTriangles(const GltfFile& file, const tinygltf::Primitive& primitive, std::size_t vertices,
                                    const std::string& where);
// Reads JOINTS_n and WEIGHTS_n for n = 0, 1, ..., which have four influences each.
void readInfluences(const GltfFile& file, const tinygltf::Primitive& primitive, const std::string& where,
                    SourcePart& part);

// Reads NORMAL of a primitive whose positions are already read, if it has it.
void readNormals(const GltfFile& file, const tinygltf::Primitive& primitive, const std::string& where,
                 RigSource& source, SourcePart& part);

// Returns how TANGENT of a primitive lies to the coordinates `uv` of its normal map, one for each vertex: the mean over
// the vertex' triangles. Returns nothing where it has no TANGENT, or where no turn is more than a step of 8 bits.
std::vector<TangentTurn> readTangentTurns(const GltfFile& file, const tinygltf::Primitive& primitive,
                                          const std::string& where, const SourcePart& part,
                                          const std::vector<std::array<double, 2>>& uv);

// Reads what a primitive whose positions are already read looks like. Damage goes into the part's problem.
void readPartColor(const GltfFile& file, const tinygltf::Primitive& primitive, const std::string& where,
                   SourcePart& part);

// Reads the morph targets of a primitive of the node's mesh, whose positions are already read, with the weights at rest
// that the node or its mesh gives and the names that the mesh gives (extras.targetNames). A file may have up to
// kMaxTargetVertices vertices of targets.
constexpr std::size_t kMaxTargetVertices = std::size_t(1) << 26;  // 800 MB
void readMorphTargets(const GltfFile& file, const tinygltf::Node& node, const tinygltf::Primitive& primitive,
                      const std::string& where, SourcePart& part);
// Notes what the morph targets of a primitive change that stays as it is at rest here.
void noteTargets(const tinygltf::Primitive& primitive, const std::filesystem::path& file, const std::string& node,
                 std::vector<RigNote>& notes);

}  // namespace penumbra
