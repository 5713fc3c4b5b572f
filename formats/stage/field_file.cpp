#include "formats/stage/field_file.h"

#include <algorithm>
#include <cassert>
#include <span>

#include "formats/common/errors.h"
#include "formats/common/part_table.h"
#include "formats/common/sha256.h"
#include "formats/common/twin_triangles.h"
#include "formats/common/write_file.h"
#include "formats/stage/part_fields_stored.h"
#include "formats/stage/stage_parts.h"

namespace penumbra {

namespace {

bool hasMotion(const OccluderMotion& motion) { return motion.moves || !motion.follows.empty(); }

// Leaves out triangles that lie behind an earlier one, and vertices of which only such triangles know: what stops light
// is the same with and without them. Returns which vertices stay.
std::vector<bool> leaveOutBacks(std::span<const std::uint32_t> twins, std::vector<Triangle>& triangles,
                                std::vector<Vec3>& positions) {
    std::vector<bool> in_front(positions.size()), behind(positions.size());
    std::vector<Triangle> kept;
    for (std::uint32_t t = 0; t < twins.size(); ++t) {
        for (const std::uint32_t corner : triangles[t]) (twins[t] < t ? behind : in_front)[corner] = true;
        if (twins[t] >= t) kept.push_back(triangles[t]);
    }
    std::vector<Vec3> places;
    for (std::size_t v = 0; v < positions.size(); ++v) {
        in_front[v] = in_front[v] || !behind[v];
        if (in_front[v]) places.push_back(positions[v]);
    }
    triangles = std::move(kept);
    positions = std::move(places);
    return in_front;
}

}  // namespace

std::string meshSha256(const Mesh& mesh) {
    std::vector<Triangle> triangles(mesh.frontTriangles().begin(), mesh.frontTriangles().end());
    std::vector<Vec3> positions(mesh.rest_positions.begin(),
                                mesh.rest_positions.begin() + std::ptrdiff_t(mesh.frontVertexCount()));
    const std::vector<std::uint32_t> twins = twinsByPlace(triangles, positions);
    std::vector<bool> stays(positions.size(), true);
    if (!twins.empty()) stays = leaveOutBacks(twins, triangles, positions);
    Sha256 hash;
    hash.update(std::as_bytes(std::span(triangles)));
    hash.update(std::as_bytes(std::span(positions)));
    for (std::size_t r = 0; r < mesh.morphs.vertices.size(); ++r) {
        if (mesh.morphs.vertices[r] >= stays.size() || !stays[mesh.morphs.vertices[r]]) continue;
        hash.update(std::as_bytes(std::span(&mesh.morphs.vertices[r], 1)));
        hash.update(std::as_bytes(std::span(&mesh.morphs.positions[r], 1)));
    }
    return hash.hex();
}

// --- Writing --------------------------------------------------------------------------------------------------------

void writeFields(const std::filesystem::path& path, const FieldFile& fields) {
    const hsize_t joints = fields.joint_names.size(), parts = fields.partCount();
    assert(fields.part_of_joint.size() == joints && fields.steps.size() == parts * parts);
    PartialFile partial(path);
    Hdf5Handle file = createHdf5(partial.path());
    writeRoot(file, kFieldsFormat, kFieldOrder, fields.provenance);
    writeIntegerAttribute(file, "/", "rays", fields.rays);
    writeIntegerAttribute(file, "/", "vertex_count", std::int64_t(fields.vertex_count));
    writeTextAttribute(file, "/", "mesh_sha256", fields.mesh_sha256);
    if (joints > 0) {
        writeStrings(file, "/skin/joint_names", fields.joint_names);
        writeIntegers(file, "/skin/part_of_joint",
                      std::vector<std::int64_t>(fields.part_of_joint.begin(), fields.part_of_joint.end()), {joints},
                      H5T_STD_U16LE);
    }
    writeIntegers(file, "/skin/steps", std::vector<std::int64_t>(fields.steps.begin(), fields.steps.end()),
                  {parts, parts}, H5T_STD_U8LE);
    writePartFields(file, fields.fields);
    if (hasMotion(fields.motion)) {
        makeGroup(file, "/motion");
        writeTextAttribute(file, "/motion", "follows", fields.motion.follows);
        writeVectors(file, "/motion/origin", {fields.motion.origin});
    }
    if (fields.shard) {
        makeGroup(file, "/shard");
        writeIntegerAttribute(file, "/shard", "first_part", std::int64_t(fields.shard->first_part));
        writeIntegerAttribute(file, "/shard", "part_count", std::int64_t(fields.shard->part_count));
    }
    closeHdf5(file);
    partial.commit();
}

// --- Reading --------------------------------------------------------------------------------------------------------

namespace {

void readSkinOfFields(const Hdf5Reader& in, FieldFile& file) {
    if (!exists(in, "/skin/joint_names") && !exists(in, "/skin/part_of_joint")) return;
    file.joint_names = readStrings(in, "/skin/joint_names");
    const std::size_t joints = file.joint_names.size();
    if (joints == 0 || joints > 65535)
        throw InvalidInput(in.name + ": /skin/joint_names: " + std::to_string(joints) + " joints");
    checkUnique(in, "/skin/joint_names", file.joint_names);
    std::vector<hsize_t> shape{joints};
    const std::vector<std::int64_t> parts =
        readIntegers(in, "/skin/part_of_joint", shape, 0, std::int64_t(kMaxParts) - 1);
    file.part_of_joint.assign(parts.begin(), parts.end());
}

void readPlace(const Hdf5Reader& in, FieldFile& file) {
    const std::size_t parts = file.fields.parts.size();
    if (exists(in, "/shard")) {
        FieldShard shard;
        shard.part_count = std::size_t(readIntegerAttribute(in, "/shard", "part_count", 1, kMaxParts));
        shard.first_part = std::size_t(readIntegerAttribute(in, "/shard", "first_part", 0, kMaxParts));
        if (shard.first_part + parts > shard.part_count)
            throw InvalidInput(in.name + ": /shard attribute first_part: the parts end beyond part_count");
        file.shard = shard;
    }
    const std::size_t first = file.shard ? file.shard->first_part : 0;
    for (const std::uint16_t part : file.part_of_joint)
        if (part >= file.partCount())
            throw InvalidInput(in.name + ": /skin/part_of_joint: part " + std::to_string(part) + " of " +
                               std::to_string(file.partCount()));
    for (std::size_t p = 0; p < parts && !file.part_of_joint.empty(); ++p)
        if (file.part_of_joint[file.fields.parts[p].joint] != first + p)
            throw InvalidInput(in.name + ": /skin/part_of_joint: part " + std::to_string(first + p) +
                               " is not that of its own joint");
    std::vector<hsize_t> shape{file.partCount(), file.partCount()};
    const std::vector<std::int64_t> steps = readIntegers(in, "/skin/steps", shape, 0, 255);
    file.steps.assign(steps.begin(), steps.end());
}

void readMotion(const Hdf5Reader& in, FieldFile& file) {
    if (!exists(in, "/motion")) return;
    file.motion.follows = readTextAttribute(in, "/motion", "follows");
    file.motion.origin = readVectors(in, "/motion/origin", 1).front();
    file.motion.moves = file.motion.follows.empty();
}

std::string readHash(const Hdf5Reader& in) {
    std::string hash = readTextAttribute(in, "/", "mesh_sha256");
    if (hash.size() != 64 || hash.find_first_not_of("0123456789abcdef") != std::string::npos)
        throw InvalidInput(in.name + ": attribute mesh_sha256: not 64 lower-case hexadecimal digits");
    return hash;
}

}  // namespace

FieldFile readFieldShard(const std::filesystem::path& path) {
    const Hdf5Reader in = openHdf5(path);
    FieldFile file;
    if (const int order = readRoot(in, kFieldsFormat, file.provenance); order != kFieldOrder)
        throw InvalidInput(in.name + ": attribute sh_order: " + std::to_string(order) + ", not " +
                           std::to_string(kFieldOrder));
    file.rays = int(readIntegerAttribute(in, "/", "rays", 1, INT32_MAX));
    file.vertex_count = std::size_t(readIntegerAttribute(in, "/", "vertex_count", 1, INT32_MAX));
    file.mesh_sha256 = readHash(in);
    readSkinOfFields(in, file);
    file.fields = readPartFields(in, {std::max<std::size_t>(file.joint_names.size(), 1), 0, false});
    readPlace(in, file);
    readMotion(in, file);
    return file;
}

FieldFile readFields(const std::filesystem::path& path) {
    FieldFile file = readFieldShard(path);
    if (file.shard)
        throw InvalidInput(path.string() + ": /shard: holds " + std::to_string(file.fields.parts.size()) + " of " +
                           std::to_string(file.shard->part_count) + " parts; merge the shards first");
    return file;
}

}  // namespace penumbra
