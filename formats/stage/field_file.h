#pragma once
// x.fields.h5: how much of the sky each rigid part of a character blocks, at any point around it (HDF5, format
// "penumbra.fields", version 1; formats/README.md lists every dataset). One field holds for every pose.
#include <filesystem>
#include <string>
#include <vector>

#include "formats/common/part_fields.h"
#include "formats/common/provenance.h"

namespace penumbra {

constexpr int kFieldsVersion = 1;

struct FieldFile {
    // What tells a character from another: a fit refuses fields of another one by these names.
    std::vector<std::string> joint_names;      // [J]
    std::vector<std::uint16_t> part_of_joint;  // [J], index into fields.parts
    std::size_t vertex_count = 0;              // V of the rig's mesh
    std::string mesh_sha256;                   // of /mesh/triangles and /mesh/rest_positions as a bake stores them
    int rays = 0;                              // directions over the sphere that a point was traced with
    PartFields fields;
    Provenance provenance;
};

// Writes through PartialFile. Throws IoError.
void writeFields(const std::filesystem::path& path, const FieldFile& file);
// Throws IoError and InvalidInput. Checks every count, index, box and number.
FieldFile readFields(const std::filesystem::path& path);

}  // namespace penumbra
