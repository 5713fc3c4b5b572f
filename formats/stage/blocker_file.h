#pragma once
// x.blockers.h5: spheres that move with the bones of a character and cast in its place (HDF5, format
// "penumbra.blockers"; formats/README.md lists every dataset).
#include <filesystem>
#include <string>
#include <vector>

#include "formats/common/file_format.h"
#include "formats/common/mesh.h"
#include "formats/common/provenance.h"
#include "formats/common/sphere_blockers.h"

namespace penumbra {

constexpr FileFormat kBlockersFormat{"penumbra.blockers", 1};

struct BlockerFile {
    // Identifies the character; see checkCharacter().
    std::vector<std::string> joint_names;  // [J]
    std::string mesh_sha256, skin_sha256;
    SphereBlockers blockers;
    std::string method;    // "area" or "paper" (fit/blockers/fit_blockers.h)
    double scale = 1;      // factor on the method's radii, > 0
    double mesh_area = 0;  // m^2, mean silhouette of the mesh over poses and views, > 0
    double area = 0;       // m^2, mean silhouette of the spheres over the same, > 0
    Provenance provenance;
};

// Fills joint_names and the hashes from a mesh (meshSha256(), field_file.h) and its skin, whose hash is over the joints
// and weights of the fronts.
void setCharacter(const Mesh& mesh, const Skin& skin, BlockerFile& file);
// Throws InvalidInput when the blockers are of another character than this one.
void checkCharacter(const BlockerFile& file, const Mesh& mesh, const Skin& skin);

// Writes through PartialFile. Throws IoError.
void writeBlockers(const std::filesystem::path& path, const BlockerFile& file);
// Throws IoError and InvalidInput. Checks every count, index and number.
BlockerFile readBlockers(const std::filesystem::path& path);

}  // namespace penumbra
