#pragma once
// Reads meshes from files that hold one: Wavefront .obj, and .ply in ASCII or binary of either byte order.
//
// It keeps every face, even where an edge has more than two of them, and vertices keep their order and number,
// because the frames of a sequence must agree vertex by vertex. That is why no half-edge library reads these files.
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

struct MeshFile {
    std::vector<Vec3d> positions;     // unchanged from the file; may be infinite or NaN
    std::vector<Triangle> triangles;  // indices < positions.size(); a face of more corners is a fan from its first one
    // For .obj with o (or g) or usemtl lines: "OBJECT/MATERIAL"; a vertex has that of the first face that uses it.
    // Otherwise empty.
    std::vector<std::string> slots;
    std::vector<std::uint16_t> slot_of_vertex;
};

bool isMeshFile(const std::filesystem::path& path);  // decides by the extension

// Reads the file. Throws IoError, Unsupported, or InvalidInput with a message such as "FILE: line 3: ..." or
// "FILE: face 7: ...".
MeshFile readMeshFile(const std::filesystem::path& path);

// These parse the two formats. Messages of errors begin with `name`.
MeshFile parseObj(std::string_view text, const std::string& name);
MeshFile parsePly(std::string_view bytes, const std::string& name);

}  // namespace penumbra
