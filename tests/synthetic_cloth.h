#pragma once
// A waving sheet with a made-up model: a deforming mesh of two rigid parts, with a ball and a number as inputs. As
// tests/synthetic_model.h, nothing in it is trained.
#include <algorithm>

#include "sh/dihedral_angles.h"
#include "sh/rigid_fit.h"
#include "tests/synthetic_model.h"

namespace penumbra::synthetic {

struct ClothOptions {
    int rows = 5, columns = 6;  // Vs = rows * columns
    bool two_sided = true;
    int frames = 5;
    FeatureKind features = FeatureKind::kRelativeBones;
    ModelKind kind = ModelKind::kAdditive;
    int pose_components = 3;  // number of principal components of dihedral angles
    Convention convention{BelowHorizon::kMirrored, 5};
};

constexpr int kClothParts = 2;

// Returns where the sheet is in a frame: 1.5 m along x, 1 m along z, waving along x and turning slowly about y.
inline std::vector<Vec3> clothPoints(const ClothOptions& o, double time) {
    std::vector<Vec3> points;
    for (int r = 0; r < o.rows; ++r)
        for (int c = 0; c < o.columns; ++c) {
            const double x = 1.5 * c / (o.columns - 1) - 0.75, z = double(r) / (o.rows - 1) - 0.5;
            const double y = time == 0 ? 0.0 : 0.25 * std::sin(4 * x + 2 * time) * std::sin(time + z);
            const double turn = 0.3 * time, s = std::sin(turn), w = std::cos(turn);
            points.push_back({float(w * x + s * z), float(1 + y), float(w * z - s * x)});
        }
    return points;
}

inline void addSheet(Model& model, const ClothOptions& o) {
    Mesh& mesh = model.mesh;
    mesh.rest_positions = clothPoints(o, 0);
    for (int r = 0; r + 1 < o.rows; ++r)
        for (int c = 0; c + 1 < o.columns; ++c) {
            const auto a = std::uint32_t(r * o.columns + c), b = a + std::uint32_t(o.columns);
            mesh.triangles.push_back({a, b, a + 1});  // the front is above
            mesh.triangles.push_back({a + 1, b, b + 1});
        }
    model.rest_normals.assign(mesh.rest_positions.size(), {0, 1, 0});
    model.rest_tangents.assign(mesh.rest_positions.size(), {1, 0, 0});
    model.skin.influences = 1;
    model.skin.weights.assign(mesh.rest_positions.size(), 1);
    for (std::size_t v = 0; v < mesh.rest_positions.size(); ++v) {
        model.skin.joints.push_back(int(v) % o.columns < o.columns / 2 ? 0 : 1);
        mesh.source_vertex.push_back(std::uint32_t(mesh.rest_positions.size() - 1 - v));  // backwards
    }
    if (!o.two_sided) return;
    mesh.two_sided = true;
    const auto points = std::uint32_t(mesh.rest_positions.size());
    for (std::size_t t = 0, count = mesh.triangles.size(); t < count; ++t) {
        const Triangle front = mesh.triangles[t];
        mesh.triangles.push_back({front[0] + points, front[2] + points, front[1] + points});
    }
    for (std::uint32_t v = 0; v < points; ++v) {
        mesh.rest_positions.push_back(Vec3(mesh.rest_positions[v]));
        model.rest_normals.push_back({0, -1, 0});
        model.rest_tangents.push_back({1, 0, 0});
        model.skin.joints.push_back(std::uint16_t(model.skin.joints[v]));
        model.skin.weights.push_back(1);
    }
}

inline void addInputs(Model& model) {
    model.skin.joint_names = {"part0", "part1", "ball", "wind"};
    model.skin.parents = {-1, -1, -1, -1};
    model.joint_centers = {{-0.4f, 1, 0}, {0.4f, 1, 0}, {0.1f, 0.5f, 0.2f}, {0, 1, 0}};
    model.joint_spreads.assign(4, {{0.1f, 0.01f, 0, 0.01f, 0.2f, 0.02f, 0, 0.02f, 0.1f}});
    for (std::size_t j = kClothParts; j < 4; ++j) model.joint_spreads[j] = Mat3{{}};  // they move nothing
    model.input_names = {"wind", "ball.x", "ball.y", "ball.z"};
    model.input_joints = {{2, 1, 3, 0, 1}, {3, 0, 1, 2.5f, 0.4f}};
}

inline std::vector<float> clothInputs(double time) {
    return {float(2 + std::sin(time)), float(0.1 + 0.2 * time), 0.5f, float(0.2 - 0.1 * time)};
}

// Any orthogonal directions serve as a basis; these are rows of cosines.
inline void addDihedralPose(Model& model, const ClothOptions& o) {
    const std::vector<InnerEdge> edges =
        innerEdges(std::span(model.mesh.triangles).first(model.mesh.frontTriangleCount()));
    for (std::size_t e = 0; e < edges.size(); ++e) {
        model.pose_mean.push_back(0.1f * float(std::sin(double(e))));
    }
    for (int k = 0; k < o.pose_components; ++k)
        for (std::size_t e = 0; e < edges.size(); ++e)
            model.pose_basis.push_back(float(std::cos((k + 1) * 3.0 * double(e) / double(edges.size()))));
}

// Computes the first reduced numbers of a pose, which Model::pose has for dihedral angles, by the definition.
inline std::vector<float> reducedAngles(const Model& model, std::span<const Vec3> points) {
    const std::vector<InnerEdge> edges =
        innerEdges(std::span(model.mesh.triangles).first(model.mesh.frontTriangleCount()));
    std::vector<float> angles(edges.size()), reduced;
    dihedralAngles(edges, points, angles);
    for (std::size_t row = 0; row < model.pose_basis.size(); row += edges.size()) {
        double sum = 0;
        for (std::size_t e = 0; e < edges.size(); ++e) {
            double away = double(angles[e]) - model.pose_mean[e];
            away -= 2 * std::numbers::pi * std::round(away / (2 * std::numbers::pi));
            sum += model.pose_basis[row + e] * away;
        }
        reduced.push_back(float(sum));
    }
    return reduced;
}

inline void addClothFrames(Model& model, const ClothOptions& o) {
    model.frames.clip_names = {"wave", "gust"};
    model.holdout_clips = {"gust"};
    const std::size_t points = model.mesh.frontVertexCount(), joints = model.skin.jointCount();
    const std::span<const Vec3> rest(model.mesh.rest_positions.data(), points);
    const std::span<const std::uint16_t> parts(model.skin.joints.data(), points);
    std::vector<PartSums> sums(joints);
    std::vector<Affine> bones(joints);
    for (int f = 0; f < o.frames; ++f) {
        const double time = f / 3.0;
        const std::vector<Vec3> moved = clothPoints(o, time);
        const std::vector<float> inputs = clothInputs(time);
        model.frames.clip.push_back(f >= (o.frames + 1) / 2);
        model.frames.time.push_back(time);
        model.positions.insert(model.positions.end(), moved.begin(), moved.end());
        partMotions(rest, parts, moved, sums, bones);
        bones[2] = pointBone({inputs[1], inputs[2], inputs[3]}, model.joint_centers[2]);
        bones[3] = numberBone(inputs[0], 2.5f, 0.4f);
        model.bones.insert(model.bones.end(), bones.begin(), bones.end());
        if (o.features == FeatureKind::kDihedrals) {
            const std::vector<float> reduced = reducedAngles(model, moved);
            model.pose.insert(model.pose.end(), reduced.begin(), reduced.end());
        }
        model.pose.insert(model.pose.end(), inputs.begin(), inputs.end());
    }
}

inline Model clothModel(const ClothOptions& o = {}) {
    Model model;
    model.deforming = true;
    TubeOptions clusters{.joints = kClothParts, .convention = o.convention, .features = o.features, .kind = o.kind};
    model.convention = clusters.convention;
    model.features = o.features;
    model.kind = o.kind;
    model.feature_scale = 2;
    addSheet(model, o);
    addInputs(model);
    model.pose_size = int(model.input_names.size());
    if (o.features == FeatureKind::kDihedrals) {
        addDihedralPose(model, o);
        model.pose_size += o.pose_components;
    }
    addClothFrames(model, o);
    addClusters(model, clusters);
    model.provenance = {"test", "0", "{}", {}};
    return model;
}

}  // namespace penumbra::synthetic
