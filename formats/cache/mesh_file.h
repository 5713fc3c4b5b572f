#pragma once
// Meshes of files that hold one: Wavefront .obj, and .ply in ASCII or binary of either byte order.
//
// Every face is kept, also where an edge has more than two of them, and vertices keep their order and number: frames of
// a sequence must agree vertex by vertex. That is why no half-edge library reads them.
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

struct MeshFile {
    std::vector<Vec3d> positions;     // as in the file; may be infinite or NaN
    std::vector<Triangle> triangles;  // indices < positions.size(); faces of more corners are fans from their first one
    // Of .obj: "OBJECT/MATERIAL" by its o (or g) and usemtl lines, where it has any; a vertex has that of the first
    // face that uses it. Else empty.
    std::vector<std::string> slots;
    std::vector<std::uint16_t> slot_of_vertex;
};

bool isMeshFile(const std::filesystem::path& path);  // by its extension

// IoError; InvalidInput "FILE: line 3: ..." or "FILE: face 7: ..."; Unsupported.
MeshFile readMeshFile(const std::filesystem::path& path);

// The two formats; `name` is for messages.
MeshFile parseObj(std::string_view text, const std::string& name);
MeshFile parsePly(std::string_view bytes, const std::string& name);

}  // namespace penumbra
