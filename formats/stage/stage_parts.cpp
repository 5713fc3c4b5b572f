#include "formats/stage/stage_parts.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "formats/common/errors.h"
#include "formats/stage/morphs_stored.h"
#include "sh/sh_basis.h"

namespace penumbra {

void writeKind(hid_t file, const FileFormat& format, const Provenance& provenance) {
    writeTextAttribute(file, "/", "format", format.name);
    writeIntegerAttribute(file, "/", "format_version", format.version);
    writeTextAttribute(file, "/", "provenance", toJson(provenance));
}

void writeRoot(hid_t file, const FileFormat& format, int sh_order, const Provenance& provenance) {
    writeKind(file, format, provenance);
    writeTextAttribute(file, "/", "sh_convention", std::string(kShConvention));
    writeIntegerAttribute(file, "/", "sh_order", sh_order);
}

namespace {

void checkText(const Hdf5Reader& in, const std::string& attribute, std::string_view expected) {
    const std::string found = readTextAttribute(in, "/", attribute);
    if (found != expected)
        throw InvalidInput(in.name + ": attribute " + attribute + " is \"" + found + "\", not \"" +
                           std::string(expected) + "\"");
}

}  // namespace

void readKind(const Hdf5Reader& in, const FileFormat& format, Provenance& provenance) {
    checkText(in, "format", format.name);
    const std::int64_t version = readIntegerAttribute(in, "/", "format_version", 1, INT32_MAX);
    if (const std::string problem = findVersionProblem(format, version); !problem.empty())
        throw Unsupported(in.name + ": " + problem);
    try {
        provenance = provenanceFromJson(readTextAttribute(in, "/", "provenance"));
    } catch (const InvalidInput& error) {
        throw InvalidInput(in.name + ": " + error.what());
    }
}

int readRoot(const Hdf5Reader& in, const FileFormat& format, Provenance& provenance) {
    readKind(in, format, provenance);
    checkText(in, "sh_convention", kShConvention);
    return int(readIntegerAttribute(in, "/", "sh_order", 1, kMaxOrder));
}

void writeVectors(hid_t file, const std::string& dataset, const std::vector<Vec3>& vectors) {
    writeFloats(file, dataset, floatsOf(vectors), {vectors.size(), 3});
}

std::vector<Vec3> readVectors(const Hdf5Reader& in, const std::string& dataset, std::size_t n) {
    std::vector<hsize_t> shape{n, 3};
    const std::vector<float> values = readFloats(in, dataset, shape);
    std::vector<Vec3> vectors(values.size() / 3);
    std::copy(values.begin(), values.end(), floatsOf(vectors).begin());
    return vectors;
}

std::vector<std::uint32_t> readIndices(const Hdf5Reader& in, const std::string& dataset, std::size_t n,
                                       std::size_t limit) {
    std::vector<hsize_t> shape{n};
    const std::vector<std::int64_t> values = readIntegers(in, dataset, shape, 0, std::int64_t(limit) - 1);
    return {values.begin(), values.end()};
}

void writeIndices(hid_t file, const std::string& dataset, std::span<const std::uint32_t> indices) {
    writeIntegers(file, dataset, std::vector<std::int64_t>(indices.begin(), indices.end()), {indices.size()},
                  H5T_STD_U32LE);
}

std::vector<float> readExactly(const Hdf5Reader& in, const std::string& dataset, const std::vector<hsize_t>& shape) {
    std::vector<hsize_t> found = shape;
    std::vector<float> values = readFloats(in, dataset, found);
    if (found != shape) throw InvalidInput(in.name + ": " + dataset + ": entries where none belong");
    return values;
}

// --- /mesh ----------------------------------------------------------------------------------------------------------

namespace {

void writeBytes(hid_t file, const std::string& dataset, const std::vector<std::uint8_t>& bytes) {
    writeIntegers(file, dataset, std::vector<std::int64_t>(bytes.begin(), bytes.end()), {bytes.size()}, H5T_STD_U8LE);
}

std::vector<std::uint8_t> readBytes(const Hdf5Reader& in, const std::string& dataset, std::size_t n,
                                    std::int64_t least) {
    std::vector<hsize_t> shape{n};
    const std::vector<std::int64_t> values = readIntegers(in, dataset, shape, least, 255);
    return {values.begin(), values.end()};
}

}  // namespace

void writeOpacity(hid_t file, const Opacity& opacity, const std::string& mesh) {
    if (opacity.empty()) return;
    writeIndices(file, mesh + "/opacity_triangles", opacity.triangles);
    writeBytes(file, mesh + "/opacity_pieces", opacity.pieces);
    writeIndices(file, mesh + "/opacity_first", opacity.first);
    writeBytes(file, mesh + "/opacity_values", opacity.values);
}

Opacity readOpacity(const Hdf5Reader& in, std::size_t triangles, const std::string& mesh) {
    Opacity out;
    if (!exists(in, mesh + "/opacity_triangles")) return out;
    const auto refuse = [&](const std::string& dataset, std::size_t at, const char* problem) {
        throw InvalidInput(in.name + ": " + dataset + ": row " + std::to_string(at) + " " + problem);
    };
    out.triangles = readIndices(in, mesh + "/opacity_triangles", 0, triangles);
    out.values = readBytes(in, mesh + "/opacity_values", 0, 0);
    if (out.triangles.empty()) throw InvalidInput(in.name + ": " + mesh + "/opacity_triangles: has no entry");
    out.pieces = readBytes(in, mesh + "/opacity_pieces", out.triangles.size(), 1);
    out.first =
        readIndices(in, mesh + "/opacity_first", out.triangles.size(), std::max<std::size_t>(out.values.size(), 1));
    for (std::size_t a = 0; a < out.triangles.size(); ++a) {
        if (a > 0 && out.triangles[a] <= out.triangles[a - 1])
            refuse(mesh + "/opacity_triangles", a, "does not ascend");
        const std::size_t n = out.pieces[a];
        if (n > kMaxOpacityPieces) refuse(mesh + "/opacity_pieces", a, "has too many pieces");
        if (out.first[a] + n * n > out.values.size()) refuse(mesh + "/opacity_first", a, "reaches behind the values");
    }
    return out;
}

void writeMesh(hid_t file, const Mesh& mesh, const std::vector<Vec3>& rest_normals) {
    std::vector<std::int64_t> corners;
    for (const Triangle& triangle : mesh.triangles) corners.insert(corners.end(), triangle.begin(), triangle.end());
    writeIntegers(file, "/mesh/triangles", corners, {mesh.triangles.size(), 3}, H5T_STD_U32LE);
    writeVectors(file, "/mesh/rest_positions", mesh.rest_positions);
    writeIndices(file, "/mesh/source_vertex", mesh.source_vertex);
    writeVectors(file, "/mesh/rest_normals", rest_normals);
    if (mesh.two_sided) writeIntegerAttribute(file, "/", "two_sided", 1);
    writeMorphs(file, mesh.morphs);
    writeOpacity(file, mesh.opacity, "/mesh");
    if (mesh.slots.empty()) return;
    writeStrings(file, "/mesh/slots", mesh.slots);
    writeIntegers(file, "/mesh/slot_of_vertex",
                  std::vector<std::int64_t>(mesh.slot_of_vertex.begin(), mesh.slot_of_vertex.end()),
                  {mesh.slot_of_vertex.size()}, H5T_STD_U16LE);
}

namespace {

// Reads the slots, which a mesh need not have.
void readSlots(const Hdf5Reader& in, Mesh& mesh) {
    if (!exists(in, "/mesh/slots") && !exists(in, "/mesh/slot_of_vertex")) return;
    mesh.slots = readStrings(in, "/mesh/slots");
    if (mesh.slots.empty() || mesh.slots.size() > 65535)
        throw InvalidInput(in.name + ": /mesh/slots: " + std::to_string(mesh.slots.size()) + " slots");
    checkUnique(in, "/mesh/slots", mesh.slots);
    std::vector<hsize_t> shape{mesh.vertexCount()};
    const std::vector<std::int64_t> slots =
        readIntegers(in, "/mesh/slot_of_vertex", shape, 0, std::int64_t(mesh.slots.size()) - 1);
    mesh.slot_of_vertex.assign(slots.begin(), slots.end());
}

// Checks the pairing of fronts and backs, on which everything downstream relies.
void checkTwoSided(const Hdf5Reader& in, const Mesh& mesh) {
    const std::size_t fronts = mesh.frontVertexCount(), triangles = mesh.frontTriangleCount();
    const auto refuse = [&](const std::string& dataset, std::size_t at, const char* problem) {
        throw InvalidInput(in.name + ": " + dataset + ": two-sided, but row " + std::to_string(at) + " " + problem);
    };
    if (2 * fronts != mesh.vertexCount() || 2 * triangles != mesh.triangles.size())
        throw InvalidInput(in.name + ": attribute two_sided: the number of vertices or of triangles is odd");
    for (std::size_t v = 0; v < fronts; ++v)
        if (mesh.rest_positions[v] != mesh.rest_positions[fronts + v])
            refuse("/mesh/rest_positions", fronts + v, "is not at its front");
    for (std::size_t t = 0; t < triangles; ++t) {
        const auto [a, b, c] = mesh.triangles[t];
        const auto back = std::uint32_t(fronts);
        if (a >= fronts || b >= fronts || c >= fronts) refuse("/mesh/triangles", t, "has a back vertex");
        if (mesh.triangles[triangles + t] != Triangle{a + back, c + back, b + back})
            refuse("/mesh/triangles", triangles + t, "is not its front from behind");
    }
    for (std::size_t i = 0; i < mesh.source_vertex.size(); ++i)
        if (mesh.source_vertex[i] >= fronts) refuse("/mesh/source_vertex", i, "is a back vertex");
}

}  // namespace

Mesh readMesh(const Hdf5Reader& in) {
    Mesh mesh;
    mesh.rest_positions = readVectors(in, "/mesh/rest_positions", 0);
    const std::size_t vertices = mesh.vertexCount();
    if (vertices == 0 || vertices > INT32_MAX)
        throw InvalidInput(in.name + ": /mesh/rest_positions: " + std::to_string(vertices) + " vertices");
    std::vector<hsize_t> shape{0, 3};
    const std::vector<std::int64_t> corners = readIntegers(in, "/mesh/triangles", shape, 0, std::int64_t(vertices) - 1);
    mesh.triangles.resize(corners.size() / 3);
    for (std::size_t i = 0; i < corners.size(); ++i) mesh.triangles[i / 3][i % 3] = std::uint32_t(corners[i]);
    mesh.source_vertex = readIndices(in, "/mesh/source_vertex", 0, vertices);
    readSlots(in, mesh);
    mesh.two_sided = hasAttribute(in, "/", "two_sided") && readIntegerAttribute(in, "/", "two_sided", 0, 1) == 1;
    if (mesh.two_sided) checkTwoSided(in, mesh);
    mesh.morphs = readMorphs(in, vertices);
    mesh.opacity = readOpacity(in, mesh.frontTriangleCount(), "/mesh");
    return mesh;
}

// --- /skin ----------------------------------------------------------------------------------------------------------

namespace {

void writeAffines(hid_t file, const std::string& dataset, const std::vector<Affine>& matrices) {
    const float* first = matrices.data()->m.data();
    writeFloats(file, dataset, {first, first + 12 * matrices.size()}, {matrices.size(), 3, 4});
}

std::vector<Affine> readAffines(const Hdf5Reader& in, const std::string& dataset, std::size_t n) {
    std::vector<hsize_t> shape{n, 3, 4};
    const std::vector<float> values = readFloats(in, dataset, shape);
    std::vector<Affine> matrices(n);
    for (std::size_t i = 0; i < n; ++i) std::copy_n(values.begin() + std::ptrdiff_t(12 * i), 12, matrices[i].m.begin());
    return matrices;
}

}  // namespace

void writeSkin(hid_t file, const Skin& skin) {
    const hsize_t influences = hsize_t(skin.influences);
    const hsize_t vertices = influences ? skin.joints.size() / influences : 0;
    writeStrings(file, "/skin/joint_names", skin.joint_names);
    writeIntegers(file, "/skin/parents", std::vector<std::int64_t>(skin.parents.begin(), skin.parents.end()),
                  {skin.parents.size()}, H5T_STD_I32LE);
    writeIntegers(file, "/skin/joints", std::vector<std::int64_t>(skin.joints.begin(), skin.joints.end()),
                  {vertices, influences}, H5T_STD_U16LE);
    writeFloats(file, "/skin/weights", skin.weights, {vertices, influences});
    if (skin.rest_transforms.empty()) return;
    writeAffines(file, "/skin/rest_transforms", skin.rest_transforms);
    writeAffines(file, "/skin/inverse_bind", skin.inverse_bind);
}

void checkUnique(const Hdf5Reader& in, const std::string& dataset, const std::vector<std::string>& names) {
    std::unordered_set<std::string> seen;
    for (const std::string& name : names)
        if (!seen.insert(name).second) throw InvalidInput(in.name + ": " + dataset + ": \"" + name + "\" occurs twice");
}

namespace {

// Checks that every joint comes to a root (-1) in at most J steps.
void checkParents(const Hdf5Reader& in, const std::vector<std::int32_t>& parents) {
    std::vector<char> rooted(parents.size(), 0);
    for (std::size_t joint = 0; joint < parents.size(); ++joint) {
        std::size_t steps = 0;
        std::int32_t at = std::int32_t(joint);
        while (at >= 0 && !rooted[std::size_t(at)]) {
            if (++steps > parents.size())
                throw InvalidInput(in.name + ": /skin/parents: a cycle at joint " + std::to_string(joint));
            at = parents[std::size_t(at)];
        }
        for (at = std::int32_t(joint); at >= 0 && !rooted[std::size_t(at)]; at = parents[std::size_t(at)])
            rooted[std::size_t(at)] = 1;
    }
}

void checkWeights(const Hdf5Reader& in, const Skin& skin) {
    const std::size_t influences = std::size_t(skin.influences);
    for (std::size_t begin = 0; begin < skin.weights.size(); begin += influences) {
        double sum = 0;
        for (std::size_t i = begin; i < begin + influences; ++i) {
            if (skin.weights[i] < 0)
                throw InvalidInput(in.name + ": /skin/weights: negative at vertex " +
                                   std::to_string(begin / influences));
            sum += skin.weights[i];
        }
        if (std::abs(sum - 1) > 1e-3)
            throw InvalidInput(in.name + ": /skin/weights: vertex " + std::to_string(begin / influences) + " sums to " +
                               std::to_string(sum));
    }
}

}  // namespace

Skin readSkin(const Hdf5Reader& in, std::size_t vertices) {
    Skin skin;
    skin.joint_names = readStrings(in, "/skin/joint_names");
    const std::size_t joints = skin.jointCount();
    if (joints == 0 || joints > 65535)
        throw InvalidInput(in.name + ": /skin/joint_names: " + std::to_string(joints) + " joints");
    checkUnique(in, "/skin/joint_names", skin.joint_names);
    std::vector<hsize_t> shape{joints};
    const std::vector<std::int64_t> parents = readIntegers(in, "/skin/parents", shape, -1, std::int64_t(joints) - 1);
    skin.parents.assign(parents.begin(), parents.end());
    checkParents(in, skin.parents);
    shape = {vertices, 0};
    const std::vector<std::int64_t> indices = readIntegers(in, "/skin/joints", shape, 0, std::int64_t(joints) - 1);
    skin.joints.assign(indices.begin(), indices.end());
    if (shape[1] == 0) throw InvalidInput(in.name + ": /skin/joints: no influences");
    skin.influences = int(shape[1]);
    skin.weights = readFloats(in, "/skin/weights", shape);
    checkWeights(in, skin);
    if (exists(in, "/skin/rest_transforms") || exists(in, "/skin/inverse_bind")) {
        skin.rest_transforms = readAffines(in, "/skin/rest_transforms", joints);
        skin.inverse_bind = readAffines(in, "/skin/inverse_bind", joints);
    }
    return skin;
}

// --- /frames/clip, /frames/time, /clips/names -----------------------------------------------------------------------

void writeFrameList(hid_t file, const FrameList& frames) {
    writeIntegers(file, "/frames/clip", std::vector<std::int64_t>(frames.clip.begin(), frames.clip.end()),
                  {frames.clip.size()}, H5T_STD_U16LE);
    writeDoubles(file, "/frames/time", frames.time, {frames.time.size()});
    writeStrings(file, "/clips/names", frames.clip_names);
}

FrameList readFrameList(const Hdf5Reader& in) {
    FrameList frames;
    frames.clip_names = readStrings(in, "/clips/names");
    if (frames.clip_names.empty() || frames.clip_names.size() > 65535)
        throw InvalidInput(in.name + ": /clips/names: " + std::to_string(frames.clip_names.size()) + " clips");
    checkUnique(in, "/clips/names", frames.clip_names);
    std::vector<hsize_t> shape{0};
    frames.time = readDoubles(in, "/frames/time", shape);
    if (frames.time.empty()) throw InvalidInput(in.name + ": /frames/time: no frames");
    const std::vector<std::int64_t> clip =
        readIntegers(in, "/frames/clip", shape, 0, std::int64_t(frames.clip_names.size()) - 1);
    frames.clip.assign(clip.begin(), clip.end());
    if (!std::is_sorted(clip.begin(), clip.end())) throw InvalidInput(in.name + ": /frames/clip: not ascending");
    return frames;
}

}  // namespace penumbra
