#pragma once
// A bending tube with a made-up linear model: every array has the size and the kind of numbers that a fitted model has.
// Tests of the asset, the evaluator and the player use it; nothing in it is trained.
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include "formats/stage/brdf_file.h"
#include "formats/stage/light_file.h"
#include "formats/stage/model_file.h"
#include "sh/reflectance.h"

namespace penumbra::synthetic {

// The kinds of features that a skinned model can have.
inline constexpr std::array kSkinnedFeatures{FeatureKind::kJointAngles, FeatureKind::kRelativeBones};

struct TubeOptions {
    int rings = 6, segments = 5;  // V = rings * segments
    int joints = 3, clusters = 2, components = 3, inputs = 2, frames = 4;
    Convention convention{BelowHorizon::kMirrored, 5};
    FeatureKind features = FeatureKind::kRelativeBones;
    ModelKind kind = ModelKind::kLinear;
};

// Gives numbers that are uniform in [-1, 1), the same with every standard library.
class Noise {
public:
    explicit Noise(std::uint32_t seed) : generator_(seed) {}
    float operator()() { return float(generator_() / 2147483648.0 - 1); }

private:
    std::mt19937 generator_;
};

inline void fillNoise(std::vector<float>& values, std::size_t count, float scale, Noise& noise) {
    values.resize(count);
    for (float& v : values) v = scale * noise();
}

inline void addTube(Model& model, const TubeOptions& o) {
    const double radius = 0.15, height = 1.8;
    model.skin.influences = 2;
    for (int r = 0; r < o.rings; ++r)
        for (int s = 0; s < o.segments; ++s) {
            const double a = 2 * std::numbers::pi * s / o.segments, c = std::cos(a), d = std::sin(a);
            const double y = height * r / std::max(1, o.rings - 1);
            model.mesh.rest_positions.push_back({float(radius * c), float(y), float(radius * d)});
            model.rest_normals.push_back({float(c), 0, float(d)});
            model.rest_tangents.push_back({0, 1, 0});
            const double at = y / height * (o.joints - 1);
            const int first = std::min(int(at), std::max(0, o.joints - 2));
            const float second_weight = o.joints > 1 ? float(at - first) : 0;
            model.skin.joints.push_back(std::uint16_t(first));
            model.skin.joints.push_back(std::uint16_t(o.joints > 1 ? first + 1 : 0));
            model.skin.weights.push_back(1 - second_weight);
            model.skin.weights.push_back(second_weight);
            model.mesh.source_vertex.push_back(std::uint32_t(r * o.segments + s));
            if (r == 0) continue;
            const auto v = [&](int ring, int segment) {
                return std::uint32_t(ring * o.segments + segment % o.segments);
            };
            model.mesh.triangles.push_back({v(r - 1, s), v(r, s), v(r, s + 1)});
            model.mesh.triangles.push_back({v(r - 1, s), v(r, s + 1), v(r - 1, s + 1)});
        }
    for (int j = 0; j < o.joints; ++j) {
        model.skin.joint_names.push_back("joint" + std::to_string(j));
        model.skin.parents.push_back(j - 1);
        model.joint_centers.push_back({0, float(height * j / std::max(1, o.joints - 1)), 0});
        model.joint_spreads.push_back({{0.1f, 0.01f, 0, 0.01f, 0.2f, 0.02f, 0, 0.02f, 0.1f}});
        const float y = model.joint_centers.back().y, below = j > 0 ? model.joint_centers[std::size_t(j - 1)].y : 0;
        model.skin.rest_transforms.push_back({{1, 0, 0, 0, 0, 1, 0, y - below, 0, 0, 1, 0}});
        model.skin.inverse_bind.push_back({{1, 0, 0, 0, 0, 1, 0, -y, 0, 0, 1, 0}});
    }
}

// Every joint turns a little more each frame: about x in the first clip, about z in the second, which is held out.
inline void addFrames(Model& model, const TubeOptions& o) {
    model.frames.clip_names = {"bend", "twist"};
    model.holdout_clips = {"twist"};
    model.pose_size = 3 * o.joints;
    for (int f = 0; f < o.frames; ++f) {
        const bool second = f >= (o.frames + 1) / 2;
        model.frames.clip.push_back(second);
        model.frames.time.push_back((second ? f - (o.frames + 1) / 2 : f) / 3.0);
        const double a = 0.3 * std::sin(0.7 * f + 0.2), c = std::cos(a), s = std::sin(a);
        const Mat3d turn = second ? Mat3d{{c, -s, 0, s, c, 0, 0, 0, 1}} : Mat3d{{1, 0, 0, 0, c, -s, 0, s, c}};
        Mat3d rotation;
        Vec3d translation;
        for (int j = 0; j < o.joints; ++j) {
            const Vec3d at = toDouble(model.joint_centers[std::size_t(j)]);
            translation += rotation * (at - turn * at);
            rotation = rotation * turn;
            const auto& m = rotation.m;
            const Vec3d& t = translation;
            model.bones.push_back({{float(m[0]), float(m[1]), float(m[2]), float(t.x), float(m[3]), float(m[4]),
                                    float(m[5]), float(t.y), float(m[6]), float(m[7]), float(m[8]), float(t.z)}});
            model.pose.insert(model.pose.end(), {second ? 0.0f : float(a), 0.0f, second ? float(a) : 0.0f});
        }
    }
}

// Makes a group of every other joint (for angles: every joint; for dihedral angles: every number of the pose), with
// ranges that some frames leave, and `units` of an additive model.
inline void addGroups(ClusterModel& cluster, const Model& model, std::size_t units, Noise& noise) {
    const bool bones = model.features == FeatureKind::kRelativeBones;
    const std::size_t size = groupInputs(model.features);
    const std::size_t groups = bones ? model.skin.jointCount() : std::size_t(model.pose_size) / size;
    for (std::uint32_t j = 0; j < groups; ++j)
        if (!bones || int(j) != cluster.joint) cluster.groups.push_back(j);
    cluster.group_weight.assign(cluster.groups.size(), 1 / float(cluster.groups.size()));
    cluster.group_min.assign(cluster.groups.size() * size, -0.8f);
    cluster.group_max.assign(cluster.groups.size() * size, 0.7f);
    for (std::size_t h = 0; h < units; ++h) cluster.unit_group.push_back(std::uint32_t(h * 5 % cluster.groups.size()));
    if (units > 0) fillNoise(cluster.hidden, units * size, 0.5f, noise);
}

inline std::size_t unitCount(const ClusterModel& cluster, const TubeOptions& o) {
    const auto inputs = std::size_t(o.inputs);
    switch (o.kind) {
        case ModelKind::kLinear:
            break;
        case ModelKind::kQuadratic:
            return inputs + inputs * (inputs + 1) / 2;
        case ModelKind::kNeural:
            return cluster.hidden.size() / (inputs + 1);
        case ModelKind::kAdditive:
            return cluster.unit_group.size();
    }
    return inputs;
}

// The mean is an open hemisphere, dimmed; components and regressors are noise of a fitted model's magnitude.
inline void addClusters(Model& model, const TubeOptions& o) {
    Noise noise(7);
    const std::size_t size = std::size_t(model.convention.size());
    std::vector<double> below(std::size_t(coefficientCount(model.convention.order)));
    belowHorizonCoefficients(model.convention.order, below);
    std::vector<float> moments(below.size());
    for (std::size_t i = 0; i < below.size(); ++i)
        moments[i] = float((i == 0 ? 2 * std::sqrt(std::numbers::pi) : 0) - below[i]);
    std::vector<float> open(size);
    fromMoments(model.convention, moments, open);
    const bool bones = o.features == FeatureKind::kRelativeBones;
    const std::size_t features = bones ? 12 * (model.skin.jointCount() - 1) : std::size_t(model.pose_size);
    const std::size_t vertices = model.mesh.vertexCount();
    for (int c = 0; c < o.clusters; ++c) {
        ClusterModel cluster;
        for (std::size_t v = 0; v < vertices; ++v)  // interleaved, so that packing has to reorder
            if (v * 7 % vertices * std::size_t(o.clusters) / vertices == std::size_t(c))
                cluster.vertices.push_back(std::uint32_t(v));
        cluster.joint = c * o.joints / o.clusters;
        const bool additive = o.kind == ModelKind::kAdditive;
        if (!additive) {
            fillNoise(cluster.feature_mean, features, 0.1f, noise);
            fillNoise(cluster.input_basis, features * std::size_t(o.inputs), 1 / std::sqrt(float(features)), noise);
            cluster.input_min.assign(std::size_t(o.inputs), -0.2f);
            cluster.input_max.assign(std::size_t(o.inputs), 0.2f);
        }
        if (o.kind == ModelKind::kNeural) fillNoise(cluster.hidden, 7 * std::size_t(o.inputs + 1), 1, noise);
        addGroups(cluster, model, additive ? 2 * std::size_t(o.inputs) : 0, noise);
        fillNoise(cluster.weights, std::size_t(o.components) * unitCount(cluster, o), 2, noise);
        fillNoise(cluster.bias, std::size_t(o.components), 1, noise);
        for (std::size_t v = 0; v < cluster.vertices.size(); ++v) {
            const float dimmed = 0.5f + 0.1f * noise();  // E stays in (0, 1)
            for (float value : open) cluster.mean.push_back(dimmed * value);
        }
        fillNoise(cluster.basis, std::size_t(o.components) * cluster.vertices.size() * size, 0.05f, noise);
        model.clusters.push_back(cluster);
    }
    model.cluster_of_vertex.resize(vertices);
    for (std::uint32_t c = 0; c < model.clusters.size(); ++c)
        for (std::uint32_t v : model.clusters[c].vertices) model.cluster_of_vertex[v] = c;
}

inline Model tubeModel(const TubeOptions& options = {}) {
    Model model;
    model.convention = options.convention;
    model.features = options.features;
    model.kind = options.kind;
    model.feature_scale = 2;
    addTube(model, options);
    addFrames(model, options);
    addClusters(model, options);
    model.provenance = {"test", "0", "{}", {}};
    return model;
}

// Turns every joint of every frame by itself, so that no two scores move together. Tests of ranks need this.
inline void turnJointsApart(Model& model) {
    Noise noise(17);
    const std::size_t joints = model.joint_centers.size();
    for (std::size_t b = 0; b < model.bones.size(); ++b) {
        const double x = 0.4 * noise(), y = 0.4 * noise(), z = 0.4 * noise();
        const Mat3d about_x{{1, 0, 0, 0, std::cos(x), -std::sin(x), 0, std::sin(x), std::cos(x)}};
        const Mat3d about_y{{std::cos(y), 0, std::sin(y), 0, 1, 0, -std::sin(y), 0, std::cos(y)}};
        const Mat3d about_z{{std::cos(z), -std::sin(z), 0, std::sin(z), std::cos(z), 0, 0, 0, 1}};
        const Mat3d turn = about_x * (about_y * about_z);
        const Vec3d center = toDouble(model.joint_centers[b % joints]), t = center - turn * center;
        const auto& m = turn.m;
        model.bones[b] = {{float(m[0]), float(m[1]), float(m[2]), float(t.x), float(m[3]), float(m[4]), float(m[5]),
                           float(t.y), float(m[6]), float(m[7]), float(m[8]), float(t.z)}};
    }
}

// Makes Lambert of albedo 1 exactly: f_i = sum of cos / pi times y_i over the hemisphere, whatever the view.
inline BrdfFile lambert(Vec3d color = {1, 1, 1}) {
    BrdfFile brdf;
    brdf.name = "lambert";
    brdf.even_index = evenIndices(brdf.view_order);
    const std::size_t even = brdf.even_index.size();
    brdf.slices.assign(std::size_t(coefficientCount(brdf.slice_order)) * even * 3, 0.0);
    const double pi = std::numbers::pi;
    const double cosine[5] = {std::sqrt(pi) / 2, std::sqrt(pi / 3), std::sqrt(5 * pi) / 8, 0, -std::sqrt(pi) / 16};
    for (int l = 0; l < 5; ++l)
        for (int c = 0; c < 3; ++c)
            brdf.slices[(std::size_t(shIndex(l, 0)) * even) * 3 + std::size_t(c)] =
                color[c] * cosine[l] / pi * std::sqrt(4 * pi);  // y_0 = 1 / sqrt(4 pi)
    brdf.lobes = {{BrdfModel::kLambert, {}, toFloat(color)}};
    return brdf;
}

// Makes radiance 1 from everywhere, or noise around it.
inline LightFile light(int order, double noise_amount, std::uint32_t seed = 3) {
    LightFile light;
    light.name = noise_amount > 0 ? "noise" : "uniform";
    light.order = order;
    Noise noise(seed);
    for (int i = 0; i < order * order; ++i)
        for (int c = 0; c < 3; ++c)
            light.sh.push_back((i == 0 ? std::sqrt(4 * std::numbers::pi) : 0) + noise_amount * noise());
    return light;
}

}  // namespace penumbra::synthetic
