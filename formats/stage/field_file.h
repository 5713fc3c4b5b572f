#pragma once
// x.fields.h5: how much of the sky each rigid part of a character blocks, at any point around it (HDF5, format
// "penumbra.fields"; formats/README.md lists every dataset). One field holds for every pose.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/common/file_format.h"
#include "formats/common/mesh.h"
#include "formats/common/part_fields.h"
#include "formats/common/provenance.h"

namespace penumbra {

constexpr FileFormat kFieldsFormat{"penumbra.fields", 1};
constexpr std::int32_t kMaxFieldPoints = 1024;  // along one axis of a box

// Where the parts of a shard belong: they are the parts first_part, first_part + 1, ... of part_count.
struct FieldShard {
    std::size_t first_part = 0, part_count = 0;
};

// How a mesh without joints moves in its own frames, as something that others are baked with (--occluder).
struct OccluderMotion {
    // NAME of the point NAME.x, NAME.y, NAME.z of --inputs that it keeps its distance from, without turning.
    std::string follows;
    Vec3 origin;         // where that point is when the mesh has its rest positions
    bool moves = false;  // it moves, and follows no point
};

struct FieldFile {
    // Identifies the character: a fit refuses fields whose names differ. A mesh without joints has none, and its only
    // part has joint 0.
    std::vector<std::string> joint_names;      // [J]
    std::vector<std::uint16_t> part_of_joint;  // [J], < P of the whole, also in a shard
    std::vector<std::uint8_t> steps;           // [P, P] of the whole, PartTable::steps
    std::size_t vertex_count = 0;              // V of the rig's mesh, without backs
    std::string mesh_sha256;                   // meshSha256() of the rig's mesh
    int rays = 0;                              // directions that a point was traced with
    PartFields fields;                         // [P], or those of the shard
    std::optional<FieldShard> shard;
    OccluderMotion motion;
    Provenance provenance;

    std::size_t partCount() const { return shard ? shard->part_count : fields.parts.size(); }
    // Returns the name of the joint of fields.parts[part], "" for a mesh without joints.
    std::string partName(std::size_t part) const {
        return joint_names.empty() ? std::string() : joint_names[fields.parts[part].joint];
    }
};

// Returns the SHA-256 of the corners of all triangles, and then of the rest positions, as a bake stores them
// (/mesh/triangles, /mesh/rest_positions, little-endian). Of a two-sided mesh only the fronts count.
std::string meshSha256(const Mesh& mesh);

// Writes through PartialFile. Throws IoError.
void writeFields(const std::filesystem::path& path, const FieldFile& file);
// Throws IoError and InvalidInput. Checks every count, index, box and number. Refuses a shard.
FieldFile readFields(const std::filesystem::path& path);
// Reads a shard or a whole. Throws the errors of readFields().
FieldFile readFieldShard(const std::filesystem::path& path);

}  // namespace penumbra
