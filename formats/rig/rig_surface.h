#pragma once
// The pictures of a rig's materials on its mesh, as pictures of it are drawn.
#include <string>
#include <vector>

#include "formats/common/surface.h"
#include "formats/rig/rig_file.h"

namespace penumbra {

struct RigSurface {
    MeshSurface surface;
    std::vector<std::string> notes;  // properties of the materials that the pictures do not show
};

// Returns the surface of the rig's mesh with the base colours, pictures and numbers of its materials. Texture files are
// not opened. `file` names the rig in messages. What a damaged material or damaged coordinates would show is left out,
// and a note says so. Throws Unsupported where pictures take more than kMaxUvSets sets of coordinates.
RigSurface surfaceOf(const Rig& rig, const std::string& file);

// Lays the surface of a rig on `mesh`, which a bake has of it: by other options it may have other shading points, but
// it has the same triangles, and with `two_sided` the backs of all of them. Throws InvalidInput where it is another
// mesh.
void fitSurface(const Rig& rig, const Mesh& mesh, const std::string& file, MeshSurface& surface);

}  // namespace penumbra
