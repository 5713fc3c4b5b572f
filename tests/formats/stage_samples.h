#pragma once
// Small files to test with: a bent strip of quads with two joints, a few frames, and numbers from a counter.
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "formats/stage/blocker_file.h"
#include "formats/stage/brdf_file.h"
#include "formats/stage/field_file.h"
#include "formats/stage/light_file.h"
#include "formats/stage/lobe_file.h"
#include "formats/stage/model_file.h"
#include "formats/stage/pose_file.h"
#include "formats/stage/transfer_file.h"
#include "formats/stage/visibility_file.h"
#include "sh/reflectance.h"

namespace penumbra::samples {

// A folder in memory where there is one. Tests that write thousands of small files wait for little else than the files.
inline std::filesystem::path memoryFolder() {
    const std::filesystem::path shared = "/dev/shm";
    return std::filesystem::is_directory(shared) ? shared : std::filesystem::temp_directory_path();
}

// A folder of its own for one test, which is removed at the end.
struct Folder {
    std::filesystem::path path;
    explicit Folder(const std::string& name,
                    const std::filesystem::path& parent = std::filesystem::temp_directory_path())
        : path(parent / ("penumbra_" + name + std::to_string(::getpid()))) {
        std::filesystem::remove_all(path);
        std::filesystem::create_directories(path);
    }
    ~Folder() { std::filesystem::remove_all(path); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    std::size_t entries() const {
        return std::size_t(
            std::distance(std::filesystem::directory_iterator(path), std::filesystem::directory_iterator()));
    }
};

inline std::string bytesOf(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

// Removes the file first: a disk with ext4 writes out at once what replaces the contents of a file, so that thousands
// of small files would take a minute of waiting.
inline void writeBytes(const std::filesystem::path& path, std::string_view bytes) {
    std::filesystem::remove(path);
    std::ofstream(path, std::ios::binary) << bytes;
}

// Returns numbers that are smooth, different everywhere, and within [-1, 1].
inline std::vector<float> numbers(std::size_t count, double phase) {
    std::vector<float> values(count);
    for (std::size_t i = 0; i < count; ++i) values[i] = float(std::sin(phase + 0.37 * double(i)));
    return values;
}

inline std::vector<Vec3> vectors(std::size_t count, double phase) {
    const std::vector<float> values = numbers(3 * count, phase);
    std::vector<Vec3> out(count);
    for (std::size_t i = 0; i < count; ++i) out[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
    return out;
}

inline std::vector<Affine> bones(std::size_t count, double phase) {
    std::vector<Affine> out(count);
    const std::vector<float> values = numbers(12 * count, phase);
    for (std::size_t i = 0; i < 12 * count; ++i) out[i / 12].m[i % 12] = values[i];
    return out;
}

inline Mesh strip(std::uint32_t quads) {
    Mesh mesh;
    for (std::uint32_t i = 0; i <= quads; ++i) {
        mesh.rest_positions.push_back({0, float(i), 0});
        mesh.rest_positions.push_back({1, float(i), 0});
    }
    for (std::uint32_t i = 0; i < quads; ++i) {
        mesh.triangles.push_back({2 * i, 2 * i + 1, 2 * i + 2});
        mesh.triangles.push_back({2 * i + 1, 2 * i + 3, 2 * i + 2});
    }
    for (std::uint32_t v = 0; v < mesh.rest_positions.size(); ++v) {
        mesh.source_vertex.push_back(v);
        mesh.source_vertex.push_back(v);
        mesh.slot_of_vertex.push_back(std::uint16_t(v % 2));
    }
    mesh.slots = {"strip/left", "strip/right"};
    return mesh;
}

inline Skin twoJoints(const Mesh& mesh) {
    Skin skin{{"root", "Ellbogen-\xc3\xa4"}, {-1, 0}, 2, {}, {}, {}, {}};
    skin.rest_transforms = {{{1, 0, 0, 0, 0, 0, -1, 0.5f, 0, 1, 0, 0}}, {{1, 0, 0, 0, 0, 1, 0, 2, 0, 0, 1, 0}}};
    skin.inverse_bind = {{{1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0.5f}}, {}};
    for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
        const float upper = float(v) / float(mesh.vertexCount());
        const std::uint16_t first = upper > 0.5f, second = 1 - first;
        skin.joints.insert(skin.joints.end(), {first, second});
        skin.weights.insert(skin.weights.end(), {std::max(upper, 1 - upper), std::min(upper, 1 - upper)});
    }
    return skin;
}

inline Provenance provenance() {
    return {"penumbra-bake visibility", "0.1.0", R"({"order":3,"rays":64})", {{"strip.glb", std::string(64, 'a')}}};
}

inline VisibilityHeader visibilityHeader(std::uint32_t quads, std::size_t frames) {
    VisibilityHeader header;
    header.order = 3;
    header.rays = 64;
    header.seed = 7;
    header.ground_y = 0.25f;
    header.distance = 0.75f;
    header.mesh = strip(quads);
    header.skin = twoJoints(header.mesh);
    header.rest_normals.assign(header.mesh.vertexCount(), {0, 0, 1});
    header.frames.clip_names = {"walk", "run"};
    for (std::size_t f = 0; f < frames; ++f) {
        header.frames.clip.push_back(f >= frames / 2);
        header.frames.time.push_back(double(f) / 3);
    }
    header.pose_size = 6;
    header.provenance = provenance();
    return header;
}

// Makes a sheet without a skin, with either side of every vertex, dihedral angles and two inputs.
inline VisibilityHeader sheetHeader(std::uint32_t quads, std::size_t frames) {
    VisibilityHeader header = visibilityHeader(quads, frames);
    header.skin.reset();
    header.edges = innerEdges(header.mesh.triangles);
    header.mesh = withBacks(header.mesh);
    appendBackNormals(header.rest_normals);
    header.input_names = {"ball.x", "wind"};
    header.pose_size = int(header.edges.size() + 2);
    header.pose_parameterisation = kDihedralAngles;
    return header;
}

// Makes a bake with local moments of order 6.
inline VisibilityHeader localHeader(std::uint32_t quads, std::size_t frames) {
    VisibilityHeader header = visibilityHeader(quads, frames);
    header.local = LocalMoments{6, 3};
    return header;
}

// Makes the bake of four points of a strip of two quads: its ends. The vertices between are halfway.
inline VisibilityHeader pointsHeader(std::size_t frames) {
    VisibilityHeader header = visibilityHeader(1, frames);
    DrawnMesh drawn;
    drawn.mesh = strip(2);
    drawn.skin = twoJoints(drawn.mesh);
    drawn.rest_normals.assign(drawn.mesh.vertexCount(), {0, 0, 1});
    drawn.points.corners = {{0, 1, 2}, {1, 3, 2}, {0, 1, 2}, {1, 3, 2}, {2, 0, 1}, {3, 2, 1}};
    drawn.points.weights = {{1, 0, 0}, {1, 0, 0}, {0.5f, 0, 0.5f}, {0.5f, 0.5f, 0}, {1, 0, 0}, {1, 0, 0}};
    drawn.vertex_of_point = {0, 1, 4, 5};
    for (std::size_t p = 0; p < 4; ++p)
        header.mesh.rest_positions[p] = drawn.mesh.rest_positions[drawn.vertex_of_point[p]];
    header.input_names = {"smile"};
    header.pose_size = 7;
    header.mesh.morphs = {{"smile"}, {0.25f}, {0, 1}, {1}, {{0, 0, 1}}, {{0, 1, 0}}};
    drawn.mesh.morphs = {{"smile"}, {0.25f}, {0, 2}, {1, 2}, {{0, 0, 1}, {0, 0, 0.5f}}, {{0, 1, 0}, {0, 0.5f, 0}}};
    drawn.mesh.opacity = {{1, 2}, {1, 1}, {0, 1}, {128, 64}};
    header.drawn = drawn;
    return header;
}

inline VisibilityFrame visibilityFrame(const VisibilityHeader& header, std::size_t frame) {
    const std::size_t vertices = header.mesh.vertexCount();
    const double phase = double(frame);
    return {vectors(vertices, phase),
            vectors(vertices, phase + 1),
            bones(header.skin ? header.skin->jointCount() : 0, phase + 2),
            numbers(std::size_t(header.pose_size), phase + 3),
            numbers(vertices * header.coefficientCount(), phase + 4),
            numbers(header.local ? vertices * header.local->coefficientCount() : 0, phase + 5),
            numbers(vertices * header.indirectCount(), phase + 6),
            numbers(header.hasBounces() ? 2 : 0, phase + 7)};
}

inline void writeVisibility(const std::filesystem::path& path, const VisibilityHeader& header, Precision precision) {
    VisibilityWriter writer(path, header, precision);
    for (std::size_t f = 0; f < header.frames.frameCount(); ++f) writer.writeFrame(visibilityFrame(header, f));
    writer.finish();
}

// Makes a list of five chosen frames of two clips, and two sampled poses of two joints.
inline PoseFile poseFile() {
    PoseFile out;
    out.frames = {{"walk", "run", kSampledClip}, {0, 0, 0, 1, 1, 2, 2}, {0, 0.5, 2, 0.25, 1, 0, 1}};
    out.rank = {3, 0, 1, 4, 2, 5, 6};
    out.distance = {0.125, 0, 0.5, 0.0625, 0.25, 0, 0};
    out.joint_names = {"root", "Ellbogen-\xc3\xa4"};
    out.rotations = numbers(2 * 6, 3);
    out.provenance = {"penumbra-bake poses", "0.1.0", R"({"choose":5})", {{"strip.glb", std::string(64, 'a')}}};
    return out;
}

// Makes fields of two parts of three joints. The last joint moves with the second part.
inline FieldFile fieldFile() {
    FieldFile out;
    out.joint_names = {"root", "Ellbogen-\xc3\xa4", "hand"};
    out.part_of_joint = {0, 1, 1};
    out.steps = {0, 1, 1, 0};
    out.vertex_count = 9;
    out.mesh_sha256 = std::string(64, 'b');
    out.rays = 64;
    for (std::uint32_t p = 0; p < 2; ++p) {
        PartField part;
        part.joint = p;
        part.center = {0.5f * float(p), 1, 0};
        part.radius = 0.25f;
        part.boxes[0] = {{0, 0.5f, -1}, {1, 1.5f, 1}, {2, 3, 2}};
        part.boxes[1] = {{-1, 0, -2}, {2, 2, 2}, {2, 2, 2}};
        for (auto& bands : part.scale) bands.fill(1.0f / 1024);
        part.distance_scale = 1.0f / 512;
        std::vector<std::int8_t> values(part.pointCount() * kFieldCoefficients), distances(part.boxes[0].pointCount());
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::int8_t(int((i * 7 + p) % 255) - 127);
        for (std::size_t i = 0; i < distances.size(); ++i) distances[i] = std::int8_t(int(i * 11) - 60);
        out.fields.parts.push_back(part);
        out.fields.values.push_back(values);
        out.fields.distances.push_back(distances);
    }
    out.fields.fade = 0.01f;
    out.provenance = {"penumbra-bake fields", "0.1.0", R"({"rays":64})", {{"strip.glb", std::string(64, 'a')}}};
    return out;
}

// Makes three spheres of two joints.
inline BlockerFile blockerFile() {
    BlockerFile out;
    out.joint_names = {"root", "Ellbogen-\xc3\xa4"};
    out.mesh_sha256 = std::string(64, 'b');
    out.skin_sha256 = std::string(64, 'c');
    out.blockers.spheres = {{{0, 1, -0.5f}, 0.25f}, {{0.5f, 1, 0}, 0.125f}, {{-0.5f, 0, 2}, 1}};
    out.blockers.joints = {0, 1, 1};
    out.method = "area";
    out.scale = 0.9375;
    out.mesh_area = 0.375;
    out.area = 0.5;
    out.provenance = {"penumbra-fit blockers", "0.1.0", R"({"spheres":3})", {{"strip.model.h5", std::string(64, 'a')}}};
    return out;
}

// Makes two lobes of order 3 a vertex, of two components of six angles.
inline LobeModel lobeModel() {
    LobeModel model;
    model.order = 3;
    model.lobes = 2;
    model.mesh = strip(2);
    const std::size_t vertices = model.mesh.vertexCount();
    model.rest_normals.assign(vertices, {0, 0, 1});
    model.rest_tangents.assign(vertices, {1, 0, 0});
    model.skin = twoJoints(model.mesh);
    for (std::size_t v = 0; v < vertices; ++v) model.cluster_of_vertex.push_back(std::uint32_t(v % 2));
    model.joint_of_cluster = {1, 0};
    model.pose_mean = numbers(6, 0.2);
    model.pose_basis = numbers(2 * 6, 0.3);
    for (std::size_t v = 0; v < vertices; ++v) model.axes.insert(model.axes.end(), {{0, 0, 1}, {0.6f, 0, 0.8f}});
    model.weights = numbers(vertices * 3 * 2 * 5, 0.4);
    model.ridge = 0.1;
    model.holdout_clips = {"run"};
    model.clip_errors = {{"walk", false, 0.5, 0.1, 0.02}, {"run", true, 0.9, 0.2, 0.05}};
    model.provenance = {"test", "0", "{}", {}};
    return model;
}

// Makes a model of order 2 with three of six angles, and two components of the vertices where it is reduced.
inline TransferModel transferModel(TransferModelKind kind) {
    TransferModel model;
    model.order = 2;
    model.kind = kind;
    model.mesh = strip(2);
    model.rest_normals.assign(model.mesh.vertexCount(), {0, 0, 1});
    model.skin = twoJoints(model.mesh);
    model.frames = {{"walk", "run"}, {0, 0, 1}, {0, 0.25, 0}};
    model.bones = bones(3 * 2, 0.6);
    model.pose_size = 6;
    model.pose = numbers(3 * 6, 0.7);
    model.angles = {0, 2, 5};
    model.alpha = 0.5;
    model.holdout_clips = {"run"};
    model.provenance = provenance();
    if (kind == TransferModelKind::kLinear) {
        model.weights = numbers(4 * 4 * model.mesh.vertexCount(), 0.5);
        return model;
    }
    model.pose_basis = numbers(3 * 2, 0.1);
    model.weights = numbers(4 * 3 * 2, 0.2);
    model.basis = numbers(2 * model.mesh.vertexCount(), 0.3);
    model.mean = numbers(model.mesh.vertexCount(), 0.4);
    return model;
}

// Makes a list that has two mixed poses of three nodes besides, one of which has no name.
inline PoseFile mixedPoseFile() {
    PoseFile out = poseFile();
    out.frames.clip_names.push_back(kMixedClip);
    out.frames.clip.insert(out.frames.clip.end(), {3, 3});
    out.frames.time.insert(out.frames.time.end(), {0, 1});
    out.rank.insert(out.rank.end(), {7, 8});
    out.distance.insert(out.distance.end(), {0, 0});
    out.node_names = {"root", "", "Ellbogen-\xc3\xa4"};
    out.mixed = numbers(2 * 3 * kMixedValues, 1);
    for (std::size_t row = 0; row < out.mixed.size(); row += kMixedValues) {
        double squared = 0;
        for (std::size_t i = 3; i < 7; ++i) squared += double(out.mixed[row + i]) * out.mixed[row + i];
        for (std::size_t i = 3; i < 7; ++i) out.mixed[row + i] /= float(std::sqrt(squared));
    }
    return out;
}

// Makes a model of two clusters, the second of which has no components (visibility that never changes).
inline Model model(FeatureKind features) {
    Model out;
    const VisibilityHeader header = visibilityHeader(5, 4);
    out.mesh = header.mesh;
    out.skin = *header.skin;
    out.rest_normals = header.rest_normals;
    out.rest_tangents.assign(out.mesh.vertexCount(), {1, 0, 0});
    out.frames = header.frames;
    out.bones = bones(4 * 2, 1);
    out.pose_size = 6;
    out.pose = numbers(4 * 6, 2);
    out.holdout_clips = {"run"};
    out.convention = parseConvention("D5");
    out.features = features;
    out.feature_scale = 5.5;
    out.joint_centers = vectors(2, 3);
    out.joint_spreads.resize(2);
    const std::size_t raw = features == FeatureKind::kJointAngles ? 6 : 12, stride = 15;
    for (std::size_t c = 0; c < 2; ++c) {
        ClusterModel cluster;
        for (std::uint32_t v = 0; v < out.mesh.vertexCount(); ++v)
            if (v % 2 == c) cluster.vertices.push_back(v);
        const std::size_t inputs = c == 0 ? 3 : 0, components = c == 0 ? 2 : 0, vertices = cluster.vertices.size();
        cluster.joint = int(c);
        cluster.feature_mean = numbers(raw, 1);
        cluster.input_basis = numbers(inputs * raw, 2);
        cluster.input_min.assign(inputs, -1);
        cluster.input_max.assign(inputs, 0.5f);
        cluster.center = {0.1f, 0.2f, float(c)};
        cluster.groups = {features == FeatureKind::kJointAngles ? 0 : std::uint32_t(1 - c)};
        cluster.group_weight = {1};
        cluster.group_min.assign(groupInputs(features), -0.25f);
        cluster.group_max.assign(groupInputs(features), 0.75f);
        cluster.weights = numbers(components * inputs, 5);
        cluster.bias = numbers(components, 6);
        cluster.mean = numbers(vertices * stride, 7);
        cluster.basis = numbers(components * vertices * stride, 8);
        cluster.ridge = 0.125;
        cluster.train_error = 0.25;
        cluster.holdout_error = c == 0 ? 0.5 : std::nan("");
        out.clusters.push_back(cluster);
    }
    for (std::uint32_t v = 0; v < out.mesh.vertexCount(); ++v) out.cluster_of_vertex.push_back(v % 2);
    out.clip_errors = {{"walk", false, 0.3, 0.01, 0.02}, {"run", true, 0.6, 0.03, 0.04}};
    out.provenance = provenance();
    out.provenance.tool = "penumbra-fit visibility";
    return out;
}

// Makes a model of a strip in two parts with fronts and backs, a ball's center and a number as inputs, and two edges.
inline Model deformingModel(FeatureKind features) {
    Model out = model(features == FeatureKind::kDihedrals ? FeatureKind::kJointAngles : features);
    const auto fronts = std::uint32_t(out.mesh.vertexCount()), triangles = std::uint32_t(out.mesh.triangles.size());
    out.mesh.two_sided = out.deforming = true;
    for (std::uint32_t v = 0; v < fronts; ++v) {
        out.mesh.rest_positions.push_back(out.mesh.rest_positions[v]);
        out.mesh.slot_of_vertex.push_back(out.mesh.slot_of_vertex[v]);
        out.rest_normals.push_back(-out.rest_normals[v]);
        out.rest_tangents.push_back(out.rest_tangents[v]);
        ClusterModel& cluster = out.clusters[v % 2];
        cluster.vertices.push_back(v + fronts);
        out.cluster_of_vertex.push_back(v % 2);
    }
    for (std::uint32_t t = 0; t < triangles; ++t) {
        const auto [a, b, c] = out.mesh.triangles[t];
        out.mesh.triangles.push_back({a + fronts, c + fronts, b + fronts});
    }
    out.skin = {{"part0", "part1", "ball", "wind"}, {-1, -1, -1, -1}, 1, {}, {}, {}, {}};
    for (std::uint32_t v = 0; v < 2 * fronts; ++v) out.skin.joints.push_back(std::uint16_t(v % fronts >= 4));
    out.skin.weights.assign(2 * fronts, 1);
    const std::size_t frames = out.frames.frameCount();
    out.bones = bones(frames * 4, 1);
    out.joint_centers = vectors(4, 3);
    out.joint_spreads.resize(4);
    out.positions = vectors(frames * fronts, 9);
    out.input_names = {"ball.x", "ball.y", "ball.z", "wind"};
    out.input_joints = {{2, 0, 3, 0, 1}, {3, 3, 1, 0.5f, 4}};
    out.features = features;
    const bool angles = features == FeatureKind::kDihedrals;
    out.pose_size = angles ? 6 : 4;
    out.pose = numbers(frames * std::size_t(out.pose_size), 2);
    if (angles) out.pose_mean = numbers(5, 3), out.pose_basis = numbers(2 * 5, 4);
    for (ClusterModel& cluster : out.clusters) {
        const std::size_t raw = angles ? 6 : 36, inputs = cluster.input_min.size();
        cluster.feature_mean = numbers(raw, 1);
        cluster.input_basis = numbers(inputs * raw, 2);
        cluster.group_min.assign(groupInputs(features), -0.25f);
        cluster.group_max.assign(groupInputs(features), 0.75f);
        cluster.mean = numbers(cluster.vertices.size() * 15, 7);
        cluster.basis = numbers(cluster.components() * cluster.vertices.size() * 15, 8);
    }
    return out;
}

inline LightFile sampleLight() {
    LightFile light;
    light.name = "sky.exr";
    light.order = 2;
    for (int i = 0; i < 12; ++i) light.sh.push_back(std::cos(0.3 * i));
    light.residual = 0.125;
    light.provenance = {"penumbra-fit light", "0.1.0", R"({"order":2})", {{"sky.exr", std::string(64, 'a')}}};
    return light;
}

inline LightLobesFit sampleLobes() {
    LightLobesFit lobes{"joint", {{0, 0, 1}, {0.6, -0.8, 0}, {-1, 0, 0}}, {}, 0.0625, 1.0 / 3};
    for (int i = 0; i < 3 * 2 * 3; ++i) lobes.coefficients.push_back(std::sin(0.7 * i));
    return lobes;
}

inline BrdfFile sampleBrdf() {
    BrdfFile brdf;
    brdf.name = "ggx:alpha=0.3,f0=0.9";
    brdf.slice_order = 3;
    brdf.view_order = 2;
    brdf.even_index = evenIndices(2);
    for (int i = 0; i < 9 * 3 * 3; ++i) brdf.slices.push_back(std::sin(0.1 * i));
    brdf.lobes = {lobeOf(parseBrdf(brdf.name))};
    brdf.errors = {{"fit", 0.25}, {"albedo_r", 1.0 / 3}};
    brdf.provenance = {"penumbra-fit brdf", "0.1.0", R"({"analytic":"ggx"})", {}};
    return brdf;
}

inline BrdfOperators sampleOperators() {
    BrdfOperators operators{2, 2, {}, evenIndices(2), {}, "slices"};
    for (int i = 0; i < 2 * 4 * 3; ++i) operators.u.push_back(std::sin(0.2 * i));
    for (int i = 0; i < 2 * 3 * 3; ++i) operators.w.push_back(std::cos(0.3 * i));
    return operators;
}

}  // namespace penumbra::samples
