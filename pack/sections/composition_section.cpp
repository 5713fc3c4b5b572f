#include "pack/sections/composition_section.h"

#include <array>

#include "formats/common/errors.h"

namespace penumbra {

namespace {

Offset<flatbuffers::Vector<float>> writePoint(FlatBufferBuilder& builder, Vec3 point) {
    return builder.CreateVector(std::array{point.x, point.y, point.z}.data(), 3);
}

Offset<fbs::FieldBox> writeBox(FlatBufferBuilder& builder, const FieldBox& box, const std::string& what) {
    std::array<std::uint16_t, 3> size{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (box.size[axis] < 2 || box.size[axis] > 65535)
            throw InvalidInput(what + ": a box has " + std::to_string(box.size[axis]) + " points along an axis");
        size[axis] = std::uint16_t(box.size[axis]);
    }
    const auto low = writePoint(builder, box.low), high = writePoint(builder, box.high);
    return fbs::CreateFieldBox(builder, low, high, builder.CreateVector(size.data(), 3));
}

Offset<fbs::PartField> writePart(FlatBufferBuilder& builder, const PartFields& fields, std::size_t index) {
    const PartField& part = fields.parts[index];
    const std::string what = "model.composition.fields[" + std::to_string(index) + "]";
    const FieldBytes bytes = fields.bytesOf(index);
    std::vector<Offset<fbs::FieldBox>> boxes;
    for (const FieldBox& box : part.boxes) boxes.push_back(writeBox(builder, box, what));
    if (bytes.values.size() != part.pointCount() * kFieldCoefficients ||
        bytes.distances.size() != part.boxes[0].pointCount())
        throw InvalidInput(what + ": does not have the bytes of its points");
    const auto center = writePoint(builder, part.center);
    const auto box_vector = builder.CreateVector(boxes);
    const auto scale = builder.CreateVector(part.scale[0].data(), kFieldLevels * kFieldOrder);
    const auto values = writeVector<std::int8_t>(builder, bytes.values);
    const auto distances = writeVector<std::int8_t>(builder, bytes.distances);
    return fbs::CreatePartField(builder, std::uint16_t(part.joint), center, part.radius, box_vector, scale,
                                part.distance_scale, values, distances);
}

}  // namespace

Offset<fbs::Composition> writeComposition(FlatBufferBuilder& builder, const Composition& composition,
                                          const VertexParts& vertices,
                                          const std::vector<Offset<fbs::Cluster>>& residual) {
    const PartFields& fields = composition.fields;
    if (fields.values.size() != fields.parts.size() || fields.distances.size() != fields.parts.size())
        throw InvalidInput("model.composition.fields: not every part has its bytes");
    std::vector<Offset<fbs::PartField>> parts;
    for (std::size_t p = 0; p < fields.parts.size(); ++p) parts.push_back(writePart(builder, fields, p));
    const auto steps = writeVector<std::uint8_t>(builder, composition.steps);
    const auto part_vector = writeVector<std::uint16_t>(builder, vertices.part_of_vertex);
    const auto field_vector = builder.CreateVector(parts);
    Offset<flatbuffers::Vector<std::uint16_t>> near_parts;
    Offset<flatbuffers::Vector<std::uint8_t>> near_gains;
    if (composition.near_count > 0) {
        near_parts = writeVector<std::uint16_t>(builder, composition.near_parts);
        near_gains = writeVector<std::uint8_t>(builder, vertices.near_gains);
    }
    Offset<flatbuffers::Vector<Offset<fbs::Cluster>>> residual_vector;
    if (!residual.empty()) residual_vector = builder.CreateVector(residual);
    return fbs::CreateComposition(builder, std::uint8_t(composition.local_steps), steps, part_vector, field_vector,
                                  fields.fade, residual_vector, composition.floor, std::uint8_t(composition.near_count),
                                  near_parts, near_gains);
}

}  // namespace penumbra
