#pragma once
// Reads a mesh that stands still: all triangles of a Wavefront .obj, or of a binary glTF 2.0 (.glb) as its nodes place
// them at rest. Materials, skins, morph targets and compression are not read.
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

struct StillMesh {
    std::vector<Vec3> positions;           // [V] finite, metres
    std::vector<std::uint32_t> triangles;  // [3 T], T > 0
};

// Throws IoError, InvalidInput for a damaged file and for one without triangles, and Unsupported for another extension
// and for a .glb that is compressed or whose buffer is not inside.
StillMesh readStillMesh(const std::filesystem::path& path);

// Parses the bytes of a .glb. Messages begin with `name`.
StillMesh parseStillGlb(std::span<const std::byte> bytes, const std::string& name);

}  // namespace penumbra
