#include "formats/stage/visibility_header.h"

#include "formats/common/errors.h"
#include "formats/stage/drawn_mesh_stored.h"
#include "formats/stage/morphs_stored.h"

namespace penumbra {

namespace {

void writeShard(hid_t file, const ShardPlace& shard) {
    const auto write = [&](const char* dataset, const std::vector<std::uint32_t>& values) {
        writeIntegers(file, dataset, std::vector<std::int64_t>(values.begin(), values.end()), {values.size()},
                      H5T_STD_U32LE);
    };
    writeStrings(file, "/shard/clip_names", shard.clip_names);
    write("/shard/clip_frames", shard.clip_frames);
    write("/shard/frame_in_clip", shard.frame_in_clip);
}

void writeEdges(hid_t file, const std::vector<InnerEdge>& edges) {
    std::vector<std::int64_t> vertices;
    for (const InnerEdge& edge : edges) vertices.insert(vertices.end(), edge.begin(), edge.end());
    writeIntegers(file, "/mesh/edges", vertices, {edges.size(), 4}, H5T_STD_U32LE);
}

constexpr const char* kAlbedo = "/mesh/albedo";
constexpr const char* kTransmission = "/mesh/transmission";

}  // namespace

void writeVisibilityHeader(hid_t file, const VisibilityHeader& header) {
    writeRoot(file, kVisibilityFormat, header.order, header.provenance);
    writeTextAttribute(file, "/", "quantity", header.quantity);
    writeTextAttribute(file, "/", "frame", "model");
    writeIntegerAttribute(file, "/", "rays", header.rays);
    if (header.seed > std::uint64_t(INT64_MAX)) throw BadOption("seed", "must be at most 2^63 - 1");
    writeIntegerAttribute(file, "/", "seed", std::int64_t(header.seed));
    writeIntegerAttribute(file, "/", "bounces", header.bounces);
    if (header.ground_y) writeNumberAttribute(file, "/", "ground_y", *header.ground_y);
    if (header.distance) writeNumberAttribute(file, "/", "distance", *header.distance);
    writeMesh(file, header.mesh, header.rest_normals);
    if (header.hasBounces()) {
        writeVectors(file, kAlbedo, header.colors.albedo);
        if (!header.colors.transmission.empty()) writeVectors(file, kTransmission, header.colors.transmission);
    }
    if (!header.edges.empty()) writeEdges(file, header.edges);
    if (!header.input_names.empty()) writeStrings(file, "/inputs/names", header.input_names);
    if (header.skin) writeSkin(file, *header.skin);
    if (header.drawn) writeDrawnMesh(file, *header.drawn);
    writeFrameList(file, header.frames);
    if (header.shard) writeShard(file, *header.shard);
}

void writeLocalAttributes(hid_t file, const LocalMoments& local) {
    writeIntegerAttribute(file, kLocal, "steps", local.steps);
    writeIntegerAttribute(file, kLocal, "order", local.order);
}

namespace {

// Reads the place of the shard. Every frame must be one of the sampled frames of a clip, in ascending order.
ShardPlace readShard(const Hdf5Reader& in, const FrameList& frames) {
    ShardPlace shard;
    shard.clip_names = readStrings(in, "/shard/clip_names");
    checkUnique(in, "/shard/clip_names", shard.clip_names);
    std::vector<hsize_t> shape{shard.clip_names.size()};
    std::vector<std::int64_t> values = readIntegers(in, "/shard/clip_frames", shape, 0, INT32_MAX);
    shard.clip_frames.assign(values.begin(), values.end());
    shape = {frames.frameCount()};
    values = readIntegers(in, "/shard/frame_in_clip", shape, 0, INT32_MAX);
    shard.frame_in_clip.assign(values.begin(), values.end());
    std::vector<int> clips;
    for (const std::string& name : frames.clip_names) {
        clips.push_back(shard.clipNamed(name));
        if (clips.back() < 0) throw InvalidInput(in.name + ": /shard/clip_names: no clip '" + name + "'");
    }
    for (std::size_t f = 0; f < frames.frameCount(); ++f) {
        const bool follows = f > 0 && frames.clip[f] == frames.clip[f - 1];
        if (shard.frame_in_clip[f] >= shard.clip_frames[std::size_t(clips[frames.clip[f]])] ||
            (follows && shard.frame_in_clip[f] <= shard.frame_in_clip[f - 1]))
            throw InvalidInput(in.name + ": /shard/frame_in_clip: entry " + std::to_string(f) +
                               " is beyond the clip or not ascending");
    }
    return shard;
}

std::vector<InnerEdge> readEdges(const Hdf5Reader& in, const Mesh& mesh) {
    std::vector<hsize_t> shape{0, 4};
    const std::vector<std::int64_t> vertices =
        readIntegers(in, "/mesh/edges", shape, 0, std::int64_t(mesh.frontVertexCount()) - 1);
    std::vector<InnerEdge> edges(vertices.size() / 4);
    for (std::size_t i = 0; i < vertices.size(); ++i) edges[i / 4][i % 4] = std::uint32_t(vertices[i]);
    for (std::size_t e = 0; e < edges.size(); ++e)
        if (edges[e][0] >= edges[e][1] ||
            (e > 0 && std::pair(edges[e][0], edges[e][1]) <= std::pair(edges[e - 1][0], edges[e - 1][1])))
            throw InvalidInput(in.name + ": /mesh/edges: row " + std::to_string(e) + " is not ascending");
    return edges;
}

std::vector<std::string> readInputNames(const Hdf5Reader& in) {
    const std::vector<std::string> names = readStrings(in, "/inputs/names");
    if (names.empty() || names.size() > 65535)
        throw InvalidInput(in.name + ": /inputs/names: " + std::to_string(names.size()) + " inputs");
    checkUnique(in, "/inputs/names", names);
    return names;
}

LocalMoments readLocalMoments(const Hdf5Reader& in) {
    LocalMoments local;
    local.steps = int(readIntegerAttribute(in, kLocal, "steps", 1, kMaxLocalSteps));
    local.order = int(readIntegerAttribute(in, kLocal, "order", kMinLocalOrder, kMaxLocalOrder));
    return local;
}

std::string readQuantity(const Hdf5Reader& in) {
    const std::string quantity = readTextAttribute(in, "/", "quantity");
    for (const char* known : {kHemisphereVisibility, kMirroredVisibility, kDiffuseTransfer})
        if (quantity == known) return quantity;
    throw Unsupported(in.name + ": attribute quantity: \"" + quantity + "\" is unknown");
}

// Reads the colours of a file with bounces. A surface must not give back more light than it gets.
SurfaceColors readColors(const Hdf5Reader& in, const Mesh& mesh) {
    SurfaceColors colors{readVectors(in, kAlbedo, mesh.vertexCount())};
    if (exists(in, kTransmission)) colors.transmission = readVectors(in, kTransmission, mesh.vertexCount());
    if (const std::string problem = findProblem(colors, mesh); !problem.empty())
        throw InvalidInput(in.name + ": " + kAlbedo + ": " + problem);
    return colors;
}

}  // namespace

std::string findProblem(const SurfaceColors& colors, const Mesh& mesh) {
    if (!colors.transmission.empty() && !mesh.two_sided) return "transmission, but the mesh is not two-sided";
    for (std::size_t v = 0; v < colors.albedo.size(); ++v)
        for (int c = 0; c < 3; ++c) {
            const float albedo = colors.albedo[v][c];
            const float through = colors.transmission.empty() ? 0 : colors.transmission[v][c];
            const std::string where = " at vertex " + std::to_string(v);
            if (!(albedo >= 0 && albedo < 1)) return "albedo " + std::to_string(albedo) + where + ", not in [0, 1)";
            if (!(through >= 0 && albedo + through <= 1.00001f))
                return "transmission " + std::to_string(through) + where + ", not in [0, 1 - albedo]";
        }
    return "";
}

void checkPose(const std::string& name, const VisibilityHeader& header) {
    const auto fail = [&](std::size_t expected, const char* what) {
        throw InvalidInput(name + ": /frames/pose: " + std::to_string(header.pose_size) + " numbers a frame, not " +
                           std::to_string(expected) + what);
    };
    const std::size_t inputs = header.input_names.size(), size = std::size_t(header.pose_size);
    if (size < inputs) fail(inputs, " or more, as /inputs/names has");
    if (size > 0 && header.pose_parameterisation == kDihedralAngles && size != header.edges.size() + inputs)
        fail(header.edges.size() + inputs, ", as /mesh/edges and /inputs/names have");
}

VisibilityHeader readVisibilityHeader(const Hdf5Reader& in) {
    VisibilityHeader header;
    header.order = readRoot(in, kVisibilityFormat, header.provenance);
    header.quantity = readQuantity(in);
    if (const std::string frame = readTextAttribute(in, "/", "frame"); frame != "model")
        throw Unsupported(in.name + ": attribute frame: \"" + frame + "\", not \"model\"");
    header.rays = int(readIntegerAttribute(in, "/", "rays", 0, INT32_MAX));
    header.seed = std::uint64_t(readIntegerAttribute(in, "/", "seed", 0, INT64_MAX));
    header.bounces =
        int(readIntegerAttribute(in, "/", "bounces", 0, header.quantity == kDiffuseTransfer ? kMaxBounces : INT32_MAX));
    if (hasAttribute(in, "/", "ground_y")) header.ground_y = float(readNumberAttribute(in, "/", "ground_y"));
    if (hasAttribute(in, "/", "distance")) {
        header.distance = float(readNumberAttribute(in, "/", "distance"));
        if (!(*header.distance > 0)) throw InvalidInput(in.name + ": attribute distance: is not above 0");
    }
    header.mesh = readMesh(in);
    const std::size_t vertices = header.mesh.vertexCount();
    if (header.hasBounces()) header.colors = readColors(in, header.mesh);
    // Files that others made may lack these datasets, which are not in the published layout.
    header.rest_normals = exists(in, "/mesh/rest_normals") ? readVectors(in, "/mesh/rest_normals", vertices)
                                                           : meshNormals(header.mesh, header.mesh.rest_positions);
    if (exists(in, "/mesh/edges")) header.edges = readEdges(in, header.mesh);
    if (exists(in, "/inputs")) header.input_names = readInputNames(in);
    checkMorphInputs(in, header.mesh.morphs, header.input_names);
    if (exists(in, "/skin")) header.skin = readSkin(in, vertices);
    if (header.skin) header.drawn = readDrawnMesh(in, header.mesh, *header.skin);
    header.frames = readFrameList(in);
    if (exists(in, "/shard")) header.shard = readShard(in, header.frames);
    if (exists(in, kLocal)) header.local = readLocalMoments(in);
    return header;
}

}  // namespace penumbra
