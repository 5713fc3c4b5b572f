#include "formats/stage/part_fields_stored.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "formats/common/errors.h"
#include "formats/common/part_table.h"
#include "formats/stage/field_file.h"

namespace penumbra {

namespace {

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
    std::vector<Vec3> center;
    std::vector<float> radius, scale, distance_scale;
    for (const PartField& part : parts) {
        joint.push_back(part.joint);
        center.push_back(part.center);
        radius.push_back(part.radius);
        for (const auto& bands : part.scale) scale.insert(scale.end(), bands.begin(), bands.end());
        distance_scale.push_back(part.distance_scale);
    }
    writeIntegers(file, "/parts/joint", joint, {count}, H5T_STD_U16LE);
    writeVectors(file, "/parts/centre", center);
    writeFloats(file, "/parts/radius", radius, {count});
    writeBoxes(file, parts);
    writeFloats(file, "/parts/scale", scale, {count, kFieldLevels, kFieldOrder});
    writeFloats(file, "/parts/distance_scale", distance_scale, {count});
}

void writeRows(hid_t file, const std::string& dataset, const std::vector<std::vector<std::int8_t>>& parts,
               hsize_t row) {
    constexpr hsize_t kChunkBytes = 1 << 18;  // compressed one by one
    std::vector<std::int8_t> all;
    for (const std::vector<std::int8_t>& bytes : parts) all.insert(all.end(), bytes.begin(), bytes.end());
    std::vector<hsize_t> shape{all.size() / row}, chunk{std::min<hsize_t>(all.size(), kChunkBytes) / row};
    if (row > 1) {
        shape.push_back(row);
        chunk.push_back(row);
    }
    writeBytes(file, dataset, all, shape, chunk);
}

}  // namespace

void writePartFields(hid_t file, const PartFields& fields) {
    writeParts(file, fields.parts);
    writeNumberAttribute(file, "/", "fade", fields.fade);
    writeRows(file, "/fields/values", fields.values, kFieldCoefficients);
    writeRows(file, "/fields/distances", fields.distances, 1);
}

namespace {

[[noreturn]] void refuse(const Hdf5Reader& in, const std::string& field, std::size_t part, const std::string& problem) {
    throw InvalidInput(in.name + ": " + field + ": part " + std::to_string(part) + " " + problem);
}

// Larger lengths would overflow when a lookup squares them.
void checkLengths(const Hdf5Reader& in, const std::string& dataset, std::span<const float> values, std::size_t parts) {
    constexpr float kMaxLength = 1e15f;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (std::abs(values[i]) > kMaxLength)
            refuse(in, dataset, i / (values.size() / parts), "is farther than 1e15 from the origin");
}

std::vector<FieldBox> readBoxes(const Hdf5Reader& in, std::size_t parts) {
    const std::size_t count = parts * kBoxes;
    const std::vector<float> low = readExactly(in, "/parts/box_low", {parts, kBoxes, 3});
    const std::vector<float> high = readExactly(in, "/parts/box_high", {parts, kBoxes, 3});
    checkLengths(in, "/parts/box_low", low, parts);
    checkLengths(in, "/parts/box_high", high, parts);
    std::vector<hsize_t> shape{parts, kBoxes, 3};
    const std::vector<std::int64_t> size = readIntegers(in, "/parts/box_size", shape, 2, kMaxFieldPoints);
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

std::vector<PartField> readParts(const Hdf5Reader& in, const PartJoints& joints) {
    std::vector<hsize_t> shape{0};
    const std::vector<std::int64_t> joint = readIntegers(in, "/parts/joint", shape, 0, kStillJoint);
    const std::size_t count = shape[0];
    if (count == 0 || count > kMaxParts + kMaxOccluders)
        throw InvalidInput(in.name + ": /parts/joint: " + std::to_string(count) + " parts, not 1 to " +
                           std::to_string(kMaxParts + kMaxOccluders));
    const std::vector<Vec3> center = readVectors(in, "/parts/centre", count);
    const std::vector<float> radius = readExactly(in, "/parts/radius", {count});
    checkLengths(in, "/parts/centre", floatsOf(center), count);
    checkLengths(in, "/parts/radius", radius, count);
    const std::vector<FieldBox> boxes = readBoxes(in, count);
    const std::vector<float> scale = readScales(in, "/parts/scale", {count, kFieldLevels, kFieldOrder});
    const std::vector<float> distance_scale = readScales(in, "/parts/distance_scale", {count});
    std::vector<PartField> parts(count);
    for (std::size_t p = 0; p < count; ++p) {
        const bool own = joint[p] < std::int64_t(joints.own), still = joint[p] == kStillJoint && joints.may_stand;
        if (!own && !still && joint[p] >= std::int64_t(joints.own + joints.inputs))
            refuse(in, "/parts/joint", p, "moves with joint " + std::to_string(joint[p]) + ", which there is not");
        if (p > 0 && own && joint[p] <= joint[p - 1]) refuse(in, "/parts/joint", p, "does not have a later joint");
        if (!(radius[p] > 0)) refuse(in, "/parts/radius", p, "has a radius that is not above 0");
        parts[p] = {std::uint32_t(joint[p]), center[p], radius[p], {boxes[kBoxes * p], boxes[kBoxes * p + 1]}, {}, 0};
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

}  // namespace

PartFields readPartFields(const Hdf5Reader& in, const PartJoints& joints) {
    PartFields fields;
    fields.fade = float(readNumberAttribute(in, "/", "fade"));
    if (!(fields.fade > 0 && std::isfinite(fields.fade)))
        throw InvalidInput(in.name + ": attribute fade: not above 0, or too large");
    fields.parts = readParts(in, joints);
    std::vector<std::size_t> points, fine_points;
    for (const PartField& part : fields.parts) {
        points.push_back(part.pointCount());
        fine_points.push_back(part.boxes[0].pointCount());
    }
    fields.values = readBytes(in, "/fields/values", points, kFieldCoefficients);
    fields.distances = readBytes(in, "/fields/distances", fine_points, 1);
    return fields;
}

}  // namespace penumbra
