#include "fit/blockers/surface_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>

namespace penumbra {

namespace {

// Returns the joint that moves a point most. `share` has the barycentric coordinates of the point.
std::uint16_t strongestJoint(const Skin& skin, const Triangle& corners, const std::array<double, 3>& share) {
    std::map<std::uint16_t, double> weights;
    const std::size_t influences = std::size_t(skin.influences);
    for (std::size_t corner = 0; corner < 3; ++corner)
        for (std::size_t k = 0; k < influences; ++k) {
            const std::size_t at = corners[corner] * influences + k;
            weights[skin.joints[at]] += share[corner] * skin.weights[at];
        }
    return std::max_element(weights.begin(), weights.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; })
        ->first;
}

double areaOf(const Mesh& mesh, const Triangle& t) {
    const Vec3d a = toDouble(mesh.rest_positions[t[0]]);
    return 0.5 * length(cross(toDouble(mesh.rest_positions[t[1]]) - a, toDouble(mesh.rest_positions[t[2]]) - a));
}

}  // namespace

// The triangles lie in a row, each as long as its area. The row is cut into `count` pieces of one length, and each
// piece has a point at a random place. Large triangles so get as many points as they should, and not only on average.
SurfaceSamples sampleSurface(const Mesh& mesh, const Skin& skin, int count, std::uint64_t seed) {
    const std::span<const Triangle> triangles = mesh.frontTriangles();
    double area = 0;
    for (const Triangle& t : triangles) area += areaOf(mesh, t);
    SurfaceSamples samples;
    if (!(area > 0)) return samples;
    std::mt19937_64 random(seed);
    const auto next = [&] { return double(random() >> 11) * 0x1p-53; };
    std::size_t triangle = 0;
    double begin = 0, end = areaOf(mesh, triangles[0]);
    for (int i = 0; i < count; ++i) {
        const double place = area * (i + next()) / count;
        while (place >= end && triangle + 1 < triangles.size()) {
            begin = end;
            end += areaOf(mesh, triangles[++triangle]);
        }
        const Triangle& t = triangles[triangle];
        const double root = std::sqrt(end > begin ? std::clamp((place - begin) / (end - begin), 0.0, 1.0) : 0.0);
        const double turn = next();
        const std::array<double, 3> share{1 - root, root * (1 - turn), root * turn};
        Vec3d point;
        for (std::size_t c = 0; c < 3; ++c) point += share[c] * toDouble(mesh.rest_positions[t[c]]);
        samples.points.push_back(point);
        samples.joint.push_back(strongestJoint(skin, t, share));
    }
    return samples;
}

SurfaceSamples sampleVertices(const Mesh& mesh, const Skin& skin) {
    std::vector<bool> used(mesh.frontVertexCount());
    for (const Triangle& t : mesh.frontTriangles())
        for (const std::uint32_t v : t) used[v] = true;
    SurfaceSamples samples;
    for (std::uint32_t v = 0; v < used.size(); ++v) {
        if (!used[v]) continue;
        samples.points.push_back(toDouble(mesh.rest_positions[v]));
        samples.joint.push_back(strongestJoint(skin, {v, v, v}, {1, 0, 0}));
    }
    return samples;
}

}  // namespace penumbra
