#include "formats/stage/field_file.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <span>

#include "formats/common/errors.h"
#include "formats/common/part_table.h"
#include "formats/common/sha256.h"
#include "formats/common/write_file.h"
#include "formats/stage/stage_parts.h"

namespace penumbra {

namespace {

constexpr FileKind kFieldsKind{"penumbra.fields", kFieldsVersion};
constexpr std::size_t kBoxes = 2;

// Calls visit(number) for every float of a part that one dataset holds.
template <class Part, class Visit>
void visitBoxCorners(Part& part, bool high, const Visit& visit) {
    for (auto& box : part.boxes)
        for (int axis = 0; axis < 3; ++axis) {
            auto& corner = high ? box.high : box.low;
            visit(axis == 0 ? corner.x : axis == 1 ? corner.y : corner.z);
        }
}

}  // namespace

std::string meshSha256(const Mesh& mesh) {
    Sha256 hash;
    hash.update(std::as_bytes(mesh.frontTriangles()));
    hash.update(std::as_bytes(std::span(mesh.rest_positions).first(mesh.frontVertexCount())));
    return hash.hex();
}

// --- Writing --------------------------------------------------------------------------------------------------------

namespace {

void writeBoxes(hid_t file, const std::vector<PartField>& parts) {
    std::vector<float> low, high;
    std::vector<std::int64_t> size;
    for (const PartField& part : parts) {
        visitBoxCorners(part, false, [&](float x) { low.push_back(x); });
        visitBoxCorners(part, true, [&](float x) { high.push_back(x); });
        for (const FieldBox& box : part.boxes) size.insert(size.end(), box.size.begin(), box.size.end());
    }
    const std::vector<hsize_t> shape{parts.size(), kBoxes, 3};
    writeFloats(file, "/parts/box_low", low, shape);
    writeFloats(file, "/parts/box_high", high, shape);
    writeIntegers(file, "/parts/box_size", size, shape, H5T_STD_U16LE);
}

void writeParts(hid_t file, const std::vector<PartField>& parts) {
    const hsize_t count = parts.size();
    std::vector<std::int64_t> joint;
    std::vector<Vec3> centre;
    std::vector<float> radius, scale, distance_scale;
    for (const PartField& part : parts) {
        joint.push_back(part.joint);
        centre.push_back(part.centre);
        radius.push_back(part.radius);
        for (const auto& bands : part.scale) scale.insert(scale.end(), bands.begin(), bands.end());
        distance_scale.push_back(part.distance_scale);
    }
    writeIntegers(file, "/parts/joint", joint, {count}, H5T_STD_U16LE);
    writeVectors(file, "/parts/centre", centre);
    writeFloats(file, "/parts/radius", radius, {count});
    writeBoxes(file, parts);
    writeFloats(file, "/parts/scale", scale, {count, kFieldLevels, kFieldOrder});
    writeFloats(file, "/parts/distance_scale", distance_scale, {count});
}

void writeBytes(hid_t file, const std::string& dataset, const std::vector<std::vector<std::int8_t>>& parts,
                hsize_t row) {
    constexpr hsize_t kChunkBytes = 1 << 18;  // compressed one by one
    std::vector<std::int8_t> all;
    for (const std::vector<std::int8_t>& bytes : parts) all.insert(all.end(), bytes.begin(), bytes.end());
    std::vector<hsize_t> shape{all.size() / row}, chunk{std::min<hsize_t>(all.size(), kChunkBytes) / row};
    if (row > 1) {
        shape.push_back(row);
        chunk.push_back(row);
    }
    Hdf5Handle opened = createDataset(file, dataset, H5T_STD_I8LE, shape, chunk);
    checkHdf5(H5Dwrite(opened, H5T_NATIVE_INT8, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()), dataset);
    opened.close(dataset);
}

}  // namespace

void writeFields(const std::filesystem::path& path, const FieldFile& fields) {
    const hsize_t joints = fields.joint_names.size(), parts = fields.partCount();
    assert(fields.part_of_joint.size() == joints && fields.steps.size() == parts * parts);
    PartialFile partial(path);
    Hdf5Handle file = createHdf5(partial.path());
    writeRoot(file, kFieldsKind, kFieldOrder, fields.provenance);
    writeIntegerAttribute(file, "/", "rays", fields.rays);
    writeNumberAttribute(file, "/", "fade", fields.fields.fade);
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
    writeParts(file, fields.fields.parts);
    writeBytes(file, "/fields/values", fields.fields.values, kFieldNumbers);
    writeBytes(file, "/fields/distances", fields.fields.distances, 1);
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

[[noreturn]] void refuse(const Hdf5Reader& in, const std::string& field, std::size_t part, const std::string& problem) {
    throw InvalidInput(in.name + ": " + field + ": part " + std::to_string(part) + " " + problem);
}

// Larger lengths would overflow when a lookup squares them.
void checkLengths(const Hdf5Reader& in, const std::string& dataset, std::span<const float> values, std::size_t parts) {
    constexpr float kMostLength = 1e15f;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (std::abs(values[i]) > kMostLength)
            refuse(in, dataset, i / (values.size() / parts), "is farther than 1e15 from the origin");
}

std::vector<FieldBox> readBoxes(const Hdf5Reader& in, std::size_t parts) {
    const std::size_t count = parts * kBoxes;
    const std::vector<float> low = readExactly(in, "/parts/box_low", {parts, kBoxes, 3});
    const std::vector<float> high = readExactly(in, "/parts/box_high", {parts, kBoxes, 3});
    checkLengths(in, "/parts/box_low", low, parts);
    checkLengths(in, "/parts/box_high", high, parts);
    std::vector<hsize_t> shape{parts, kBoxes, 3};
    const std::vector<std::int64_t> size = readIntegers(in, "/parts/box_size", shape, 2, kMostFieldPoints);
    std::vector<FieldBox> boxes(count);
    for (std::size_t i = 0; i < 3 * count; ++i) {
        FieldBox& box = boxes[i / 3];
        box.low[int(i % 3)] = low[i];
        box.high[int(i % 3)] = high[i];
        box.size[i % 3] = std::int32_t(size[i]);
        // A lookup divides by the extent.
        if (!(low[i] < high[i])) refuse(in, "/parts/box_high", i / (3 * kBoxes), "is not above /parts/box_low");
    }
    return boxes;
}

// Reads numbers of each part that must not be negative.
std::vector<float> readScales(const Hdf5Reader& in, const std::string& dataset, const std::vector<hsize_t>& shape) {
    const std::vector<float> scales = readExactly(in, dataset, shape);
    for (std::size_t i = 0; i < scales.size(); ++i)
        if (scales[i] < 0) refuse(in, dataset, i / (scales.size() / shape[0]), "is negative");
    return scales;
}

std::vector<PartField> readParts(const Hdf5Reader& in, std::size_t joints) {
    std::vector<hsize_t> shape{0};
    const std::int64_t last_joint = std::int64_t(std::max<std::size_t>(joints, 1)) - 1;
    const std::vector<std::int64_t> joint = readIntegers(in, "/parts/joint", shape, 0, last_joint);
    const std::size_t count = shape[0];
    if (count == 0 || count > kMostParts)
        throw InvalidInput(in.name + ": /parts/joint: " + std::to_string(count) + " parts, not 1 to " +
                           std::to_string(kMostParts));
    const std::vector<Vec3> centre = readVectors(in, "/parts/centre", count);
    const std::vector<float> radius = readExactly(in, "/parts/radius", {count});
    checkLengths(in, "/parts/centre", floatsOf(centre), count);
    checkLengths(in, "/parts/radius", radius, count);
    const std::vector<FieldBox> boxes = readBoxes(in, count);
    const std::vector<float> scale = readScales(in, "/parts/scale", {count, kFieldLevels, kFieldOrder});
    const std::vector<float> distance_scale = readScales(in, "/parts/distance_scale", {count});
    std::vector<PartField> parts(count);
    for (std::size_t p = 0; p < count; ++p) {
        if (p > 0 && joint[p] <= joint[p - 1]) refuse(in, "/parts/joint", p, "does not have a later joint");
        if (!(radius[p] > 0)) refuse(in, "/parts/radius", p, "has a radius that is not above 0");
        parts[p] = {std::uint32_t(joint[p]), centre[p], radius[p], {boxes[kBoxes * p], boxes[kBoxes * p + 1]}, {}, 0};
        for (std::size_t i = 0; i < kFieldLevels * kFieldOrder; ++i)
            parts[p].scale[i / kFieldOrder][i % kFieldOrder] = scale[p * kFieldLevels * kFieldOrder + i];
        parts[p].distance_scale = distance_scale[p];
    }
    return parts;
}

// Reads the bytes of all parts, whose rows of `row` numbers the parts tell, and hands each part its own.
std::vector<std::vector<std::int8_t>> readBytes(const Hdf5Reader& in, const std::string& dataset,
                                                const std::vector<std::size_t>& rows, hsize_t row) {
    // At most 32 parts of 2 boxes of 2^30 points: the sum stays far below 2^64.
    std::size_t sum = 0;
    for (std::size_t count : rows) sum += count;
    std::vector<hsize_t> shape{sum};
    if (row > 1) shape.push_back(row);
    // -128 would make the range lopsided; the writer never makes it.
    const std::vector<std::int64_t> all = readIntegers(in, dataset, shape, -127, 127);
    std::vector<std::vector<std::int8_t>> parts;
    auto next = all.begin();
    for (std::size_t count : rows) {
        const auto end = next + std::ptrdiff_t(count * row);
        parts.emplace_back(next, end);
        next = end;
    }
    return parts;
}

void readSkinOfFields(const Hdf5Reader& in, FieldFile& file) {
    if (!exists(in, "/skin/joint_names")) return;
    file.joint_names = readStrings(in, "/skin/joint_names");
    const std::size_t joints = file.joint_names.size();
    if (joints == 0 || joints > 65535)
        throw InvalidInput(in.name + ": /skin/joint_names: " + std::to_string(joints) + " joints");
    checkUnique(in, "/skin/joint_names", file.joint_names);
    std::vector<hsize_t> shape{joints};
    const std::vector<std::int64_t> parts =
        readIntegers(in, "/skin/part_of_joint", shape, 0, std::int64_t(kMostParts) - 1);
    file.part_of_joint.assign(parts.begin(), parts.end());
}

void readPlace(const Hdf5Reader& in, FieldFile& file) {
    const std::size_t parts = file.fields.parts.size();
    if (exists(in, "/shard")) {
        FieldShard shard;
        shard.part_count = std::size_t(readIntegerAttribute(in, "/shard", "part_count", 1, kMostParts));
        shard.first_part = std::size_t(readIntegerAttribute(in, "/shard", "first_part", 0, kMostParts));
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
            refuse(in, "/skin/part_of_joint", first + p, "is not that of its own joint");
    std::vector<hsize_t> shape{file.partCount(), file.partCount()};
    const std::vector<std::int64_t> steps = readIntegers(in, "/skin/steps", shape, 0, 255);
    file.steps.assign(steps.begin(), steps.end());
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
    if (const int order = readRoot(in, kFieldsKind, file.provenance); order != kFieldOrder)
        throw InvalidInput(in.name + ": attribute sh_order: " + std::to_string(order) + ", not " +
                           std::to_string(kFieldOrder));
    file.rays = int(readIntegerAttribute(in, "/", "rays", 1, INT32_MAX));
    file.fields.fade = float(readNumberAttribute(in, "/", "fade"));
    if (!(file.fields.fade > 0 && std::isfinite(file.fields.fade)))
        throw InvalidInput(in.name + ": attribute fade: not above 0, or too large");
    file.vertex_count = std::size_t(readIntegerAttribute(in, "/", "vertex_count", 1, INT32_MAX));
    file.mesh_sha256 = readHash(in);
    readSkinOfFields(in, file);
    file.fields.parts = readParts(in, file.joint_names.size());
    readPlace(in, file);
    std::vector<std::size_t> points, fine_points;
    for (const PartField& part : file.fields.parts) {
        points.push_back(part.pointCount());
        fine_points.push_back(part.boxes[0].pointCount());
    }
    file.fields.values = readBytes(in, "/fields/values", points, kFieldNumbers);
    file.fields.distances = readBytes(in, "/fields/distances", fine_points, 1);
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
