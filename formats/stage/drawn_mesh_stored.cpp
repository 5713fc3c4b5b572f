#include "formats/stage/drawn_mesh_stored.h"

#include <cmath>

#include "formats/common/errors.h"
#include "formats/stage/morphs_stored.h"
#include "formats/stage/stage_parts.h"

namespace penumbra {

namespace {

[[noreturn]] void refuseRow(const Hdf5Reader& in, const char* dataset, std::size_t row, const char* problem) {
    throw InvalidInput(in.name + ": " + dataset + ": row " + std::to_string(row) + " " + problem);
}

void writeCorners(hid_t file, const std::string& dataset, const std::vector<Triangle>& triangles) {
    std::vector<std::int64_t> corners;
    for (const Triangle& t : triangles) corners.insert(corners.end(), t.begin(), t.end());
    writeIntegers(file, dataset, corners, {triangles.size(), 3}, H5T_STD_U32LE);
}

std::vector<Triangle> readCorners(const Hdf5Reader& in, const std::string& dataset, std::size_t rows,
                                  std::size_t limit) {
    std::vector<hsize_t> shape{rows, 3};
    const std::vector<std::int64_t> corners = readIntegers(in, dataset, shape, 0, std::int64_t(limit) - 1);
    std::vector<Triangle> triangles(corners.size() / 3);
    for (std::size_t i = 0; i < corners.size(); ++i) triangles[i / 3][i % 3] = std::uint32_t(corners[i]);
    return triangles;
}

// Each row must add up to 1.
void checkRows(const Hdf5Reader& in, const char* dataset, const std::vector<float>& weights, std::size_t width) {
    for (std::size_t begin = 0; begin < weights.size(); begin += width) {
        double sum = 0;
        for (std::size_t i = begin; i < begin + width; ++i) {
            if (weights[i] < 0) refuseRow(in, dataset, begin / width, "has a negative weight");
            sum += double(weights[i]);
        }
        if (!(std::abs(sum - 1) <= 1e-3)) refuseRow(in, dataset, begin / width, "does not add up to 1");
    }
}

void readDrawnSkin(const Hdf5Reader& in, const Skin& skin, std::size_t vertices, Skin& out) {
    out = skin;
    std::vector<hsize_t> shape{vertices, 0};
    const std::vector<std::int64_t> joints =
        readIntegers(in, "/drawn/joints", shape, 0, std::int64_t(skin.jointCount()) - 1);
    if (shape[1] == 0 || shape[1] > 255) throw InvalidInput(in.name + ": /drawn/joints: no influences, or too many");
    out.joints.assign(joints.begin(), joints.end());
    out.influences = int(shape[1]);
    out.weights = readFloats(in, "/drawn/weights", shape);
    checkRows(in, "/drawn/weights", out.weights, shape[1]);
}

void readTable(const Hdf5Reader& in, const Mesh& mesh, DrawnMesh& drawn) {
    const std::size_t vertices = drawn.mesh.vertexCount();
    drawn.points.corners = readCorners(in, "/drawn/point_corners", vertices, mesh.vertexCount());
    const std::vector<float> weights = readExactly(in, "/drawn/point_weights", {vertices, 3});
    checkRows(in, "/drawn/point_weights", weights, 3);
    drawn.points.weights.resize(vertices);
    for (std::size_t i = 0; i < weights.size(); ++i) drawn.points.weights[i / 3][i % 3] = weights[i];
    drawn.vertex_of_point = readIndices(in, "/drawn/vertex_of_point", mesh.vertexCount(), vertices);
    for (std::size_t p = 0; p < drawn.vertex_of_point.size(); ++p)
        if (drawn.mesh.rest_positions[drawn.vertex_of_point[p]] != mesh.rest_positions[p])
            refuseRow(in, "/drawn/vertex_of_point", p, "is a vertex elsewhere");
}

}  // namespace

void writeDrawnMesh(hid_t file, const DrawnMesh& drawn) {
    const hsize_t vertices = drawn.mesh.vertexCount(), influences = hsize_t(drawn.skin.influences);
    writeCorners(file, "/drawn/triangles", drawn.mesh.triangles);
    writeVectors(file, "/drawn/rest_positions", drawn.mesh.rest_positions);
    writeVectors(file, "/drawn/rest_normals", drawn.rest_normals);
    writeIndices(file, "/drawn/source_vertex", drawn.mesh.source_vertex);
    if (!drawn.mesh.slots.empty())
        writeIntegers(file, "/drawn/slot_of_vertex",
                      std::vector<std::int64_t>(drawn.mesh.slot_of_vertex.begin(), drawn.mesh.slot_of_vertex.end()),
                      {vertices}, H5T_STD_U16LE);
    writeIntegers(file, "/drawn/joints", std::vector<std::int64_t>(drawn.skin.joints.begin(), drawn.skin.joints.end()),
                  {vertices, influences}, H5T_STD_U16LE);
    writeFloats(file, "/drawn/weights", drawn.skin.weights, {vertices, influences});
    writeCorners(file, "/drawn/point_corners", drawn.points.corners);
    std::vector<float> weights;
    for (const auto& row : drawn.points.weights) weights.insert(weights.end(), row.begin(), row.end());
    writeFloats(file, "/drawn/point_weights", weights, {vertices, 3});
    writeIndices(file, "/drawn/vertex_of_point", drawn.vertex_of_point);
    writeMorphs(file, drawn.mesh.morphs, "/drawn");
    writeOpacity(file, drawn.mesh.opacity, "/drawn");
}

std::optional<DrawnMesh> readDrawnMesh(const Hdf5Reader& in, const Mesh& mesh, const Skin& skin) {
    if (!exists(in, "/drawn")) return {};
    if (mesh.two_sided) throw InvalidInput(in.name + ": /drawn: the mesh is two-sided");
    DrawnMesh drawn;
    drawn.mesh.slots = mesh.slots;
    drawn.mesh.rest_positions = readVectors(in, "/drawn/rest_positions", 0);
    const std::size_t vertices = drawn.mesh.vertexCount();
    if (vertices < mesh.vertexCount() || vertices > INT32_MAX)
        throw InvalidInput(in.name + ": /drawn/rest_positions: " + std::to_string(vertices) + " vertices");
    drawn.rest_normals = readVectors(in, "/drawn/rest_normals", vertices);
    drawn.mesh.triangles = readCorners(in, "/drawn/triangles", 0, vertices);
    drawn.mesh.source_vertex = readIndices(in, "/drawn/source_vertex", 0, vertices);
    if (!mesh.slots.empty()) {
        std::vector<hsize_t> shape{vertices};
        const std::vector<std::int64_t> slots =
            readIntegers(in, "/drawn/slot_of_vertex", shape, 0, std::int64_t(mesh.slots.size()) - 1);
        drawn.mesh.slot_of_vertex.assign(slots.begin(), slots.end());
    }
    readDrawnSkin(in, skin, vertices, drawn.skin);
    readTable(in, mesh, drawn);
    drawn.mesh.morphs = readMorphs(in, vertices, "/drawn");
    if (drawn.mesh.morphs.names != mesh.morphs.names)
        throw InvalidInput(in.name + ": /drawn/morphs/names: are not those of /mesh/morphs/names");
    drawn.mesh.opacity = readOpacity(in, drawn.mesh.triangles.size(), "/drawn");
    return drawn;
}

}  // namespace penumbra
