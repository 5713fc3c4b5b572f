#pragma once
// A tube of four bones whose visibility is exactly linear in the relative poses of its bones. A fit has to find this.
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>
#include <string>

#include "fit/clusters/tangent_frames.h"
#include "fit/clusters/vertex_clusters.h"
#include "fit/models/features.h"
#include "fit/visibility/local_coefficients.h"
#include "formats/stage/visibility_file.h"
#include "sh/sh_rotation.h"

namespace penumbra::synthetic {

// A file name that belongs to this process. The file is removed at the end of the test.
struct TemporaryFile {
    std::filesystem::path path;
    explicit TemporaryFile(const std::string& name)
        : path(std::filesystem::temp_directory_path() / ("penumbra_" + std::to_string(::getpid()) + "_" + name)) {}
    ~TemporaryFile() {
        std::error_code ignored;
        std::filesystem::remove(path, ignored);
    }
};

// Makes a tube around y with radius 0.1, from y = 0 to 2: `rings` rings of `sides` vertices.
inline Mesh tube(std::size_t rings, std::size_t sides) {
    Mesh mesh;
    for (std::size_t r = 0; r < rings; ++r)
        for (std::size_t s = 0; s < sides; ++s) {
            const double a = 2 * std::numbers::pi * double(s) / double(sides);
            mesh.rest_positions.push_back(
                {float(0.1 * std::cos(a)), float(2.0 * double(r) / double(rings - 1)), float(0.1 * std::sin(a))});
            mesh.source_vertex.push_back(std::uint32_t(mesh.source_vertex.size()));
        }
    const auto at = [&](std::size_t ring, std::size_t side) { return std::uint32_t(ring * sides + side % sides); };
    for (std::size_t r = 0; r + 1 < rings; ++r)
        for (std::size_t s = 0; s < sides; ++s) {
            mesh.triangles.push_back({at(r, s), at(r + 1, s), at(r, s + 1)});
            mesh.triangles.push_back({at(r + 1, s), at(r + 1, s + 1), at(r, s + 1)});
        }
    return mesh;
}

// Makes a skin of four bones along the tube. Each vertex follows the two nearest bones with a sharp falloff.
inline Skin chainSkin(const Mesh& mesh) {
    Skin skin;
    skin.joint_names = {"hip", "spine", "neck", "head"};
    skin.parents = {-1, 0, 1, 2};
    skin.influences = 2;
    for (Vec3 p : mesh.rest_positions) {
        const float along = std::min(std::max(p.y * 2, 0.f), 3.999f);  // bone k owns [k, k + 1)
        const int own = int(along);
        const float inside = along - float(own) - 0.5f;  // [-0.5, 0.5)
        const int other = inside < 0 ? std::max(own - 1, 0) : std::min(own + 1, 3);
        const float w = other == own ? 0.f : std::max(0.f, 0.5f - 4 * (0.5f - std::abs(inside)));
        skin.joints.insert(skin.joints.end(), {std::uint16_t(own), std::uint16_t(w > 0 ? other : 0)});
        skin.weights.insert(skin.weights.end(), {1 - w, w});
    }
    return skin;
}

inline Mat3 rotationAbout(Vec3 axis, float angle) {
    const Vec3 u = normalized(axis);
    const float c = std::cos(angle), s = std::sin(angle), t = 1 - c;
    return {{c + t * u.x * u.x, t * u.x * u.y - s * u.z, t * u.x * u.z + s * u.y,  //
             t * u.x * u.y + s * u.z, c + t * u.y * u.y, t * u.y * u.z - s * u.x,  //
             t * u.x * u.z - s * u.y, t * u.y * u.z + s * u.x, c + t * u.z * u.z}};
}

inline Affine affine(const Mat3& r, Vec3 t) {
    return {{r.m[0], r.m[1], r.m[2], t.x, r.m[3], r.m[4], r.m[5], t.y, r.m[6], r.m[7], r.m[8], t.z}};
}
inline Affine compose(const Affine& a, const Affine& b) {
    return affine(a.linear() * b.linear(), a.point(b.translation()));
}

// Swings the joints at y = 0, 0.5, 1, 1.5 smoothly. Fills the bones and the pose of frame f.
inline void swing(std::size_t f, const Affine& world, VisibilityFrame& frame) {
    Affine parent = world;
    for (int j = 0; j < 4; ++j) {
        const float t = float(f), k = float(j);
        const Vec3 turn{0.5f * std::sin(0.37f * t + k) + 0.2f * std::cos(1.1f * t * (k + 1)),
                        0.4f * std::cos(0.23f * t * (k + 1)), 0.4f * std::sin(0.51f * t + 2 * k)};
        const Mat3 r = rotationAbout(turn, length(turn));
        const Vec3 pivot{0, 0.5f * k, 0};
        parent = compose(parent, affine(r, pivot - r * pivot));
        frame.bones.push_back(parent);
        frame.pose.insert(frame.pose.end(), {turn.x, turn.y, turn.z});
    }
}

struct Options {
    std::size_t rings = 24, sides = 8, frames_per_clip = 30, clips = 3;
    Convention convention{BelowHorizon::kMirrored, 3};
    std::size_t clusters = 4;
    Affine world;  // applied to the whole character, visibility included
    double noise = 0;
    bool blocked = false;  // no vertex ever sees anything: moments of exactly zero
};

inline VisibilityHeader makeHeader(const Options& options) {
    VisibilityHeader header;
    header.order = options.convention.order;
    header.rays = 1;
    header.mesh = tube(options.rings, options.sides);
    header.skin = chainSkin(header.mesh);
    header.rest_normals = vertexNormals(header.mesh.triangles, header.mesh.rest_positions);
    for (std::size_t c = 0; c < options.clips; ++c) {
        header.frames.clip_names.push_back("clip" + std::to_string(c));
        for (std::size_t f = 0; f < options.frames_per_clip; ++f) {
            header.frames.clip.push_back(std::uint16_t(c));
            header.frames.time.push_back(double(f) / 3);
        }
    }
    header.pose_size = 12;
    header.provenance = {"test", "0", "{}", {}};
    return header;
}

// Returns the numbers of a vertex. Each is a fixed random linear function of the positions of the other bones, added to
// numbers with E = 1/2. They are small enough to stay physical: 0 < E < 1.
constexpr double kNumberSize = 0.05;
inline std::vector<float> coefficientsOf(std::size_t vertex, const Convention& convention,
                                         std::span<const double> raw) {
    std::mt19937 random{std::mt19937::result_type(vertex)};
    std::normal_distribution<double> normal;
    std::vector<float> coefficients(std::size_t(convention.size()));
    ambientWeights(convention, coefficients);
    double norm2 = 0;
    for (float w : coefficients) norm2 += double(w) * w;
    for (float& number : coefficients) {
        double sum = normal(random);
        for (std::size_t c = 0; c < raw.size(); ++c)
            if (c % 12 < 3) sum += normal(random) * raw[c];
        number = float(number * 0.5 / norm2 + kNumberSize * sum);
    }
    return coefficients;
}

// Returns local-frame moments that give these numbers. The odd moments of D are free and set to zero.
inline std::vector<float> momentsFrom(const Convention& convention, std::span<const float> coefficients) {
    std::vector<float> moments(std::size_t(coefficientCount(convention.order)));
    std::vector<double> below(moments.size());
    belowHorizonCoefficients(convention.order, below);
    const std::vector<int> indices = convention.indices();
    for (std::size_t i = 0; i < indices.size(); ++i) {
        const auto at = std::size_t(indices[i]);
        moments[at] = convention.below == BelowHorizon::kMirrored ? coefficients[i] / 2
                      : convention.below == BelowHorizon::kOpen   ? float(coefficients[i] - below[at])
                                                                  : coefficients[i];
    }
    return moments;
}

inline void writeCharacter(const std::filesystem::path& path, const Options& options) {
    const VisibilityHeader header = makeHeader(options);
    const VertexClusters clusters = clusterVertices(header.mesh, *header.skin, options.clusters, 1);
    const std::vector<Vec3> tangents = restTangents(header.mesh, header.rest_normals, clusters, 1);
    const FeatureRecipe recipe{FeatureKind::kRelativeBones,
                               boxDiagonal(header.mesh.rest_positions),
                               jointCenters(header.mesh, *header.skin),
                               {},
                               12};
    VisibilityWriter writer(path, header, Precision::kFloat32);
    std::mt19937 random{1};
    std::normal_distribution<double> normal;
    for (std::size_t f = 0; f < header.frames.frameCount(); ++f) {
        VisibilityFrame frame;
        swing(f, options.world, frame);
        skinVertices(header.mesh, *header.skin, header.rest_normals, frame.bones, frame.positions, frame.normals);
        std::vector<Mat3> rotations;
        for (const Affine& bone : frame.bones) rotations.push_back(nearestRotation(bone.linear()));
        std::vector<double> raw(recipe.count());
        for (std::size_t v = 0; v < header.mesh.vertexCount(); ++v) {
            const int joint = clusters.joint[clusters.cluster_of_vertex[v]];
            rawFeatures(recipe, joint, frame.bones, rotations, frame.pose, raw);
            std::vector<float> coefficients = coefficientsOf(v, options.convention, raw);
            for (float& x : coefficients) x += float(kNumberSize * options.noise * normal(random));
            const std::vector<float> local = momentsFrom(options.convention, coefficients);
            const Vec3 t = carriedTangent(frame.normals[v], rotations[std::size_t(joint)], tangents[v]);
            std::vector<float> moments(local.size());
            apply(makeShRotation(options.convention.order, localFrame(frame.normals[v], t)), local, moments);
            if (options.blocked) std::fill(moments.begin(), moments.end(), 0.0f);
            frame.coefficients.insert(frame.coefficients.end(), moments.begin(), moments.end());
        }
        writer.writeFrame(frame);
    }
    writer.finish();
}

}  // namespace penumbra::synthetic
