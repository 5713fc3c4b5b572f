#pragma once
// Meshes for tests of the sun's map.
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "runtime/sun/sun_map.h"

namespace penumbra::player_test {

struct SunMesh {
    std::vector<Vec3> positions;
    std::vector<std::uint32_t> triangles;
    operator SunCaster() const { return {positions, triangles}; }
};

inline SunMesh sunBox(Vec3 low, Vec3 high) {
    SunMesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.positions.push_back({i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
    mesh.triangles = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                      2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    return mesh;
}

// A square of side 2 half around the origin, with this normal.
inline SunMesh sunSquare(Vec3 normal, float half) {
    const Vec3 n = normalized(normal);
    const Vec3 a = normalized(cross(std::abs(n.x) < 0.7f ? Vec3{1, 0, 0} : Vec3{0, 1, 0}, n)), b = cross(n, a);
    return {{(a + b) * -half, (a - b) * half, (a + b) * half, (b - a) * half}, {0, 1, 2, 0, 2, 3}};
}

// A unit sphere; its positions are its normals.
inline SunMesh sunSphere(int rings) {
    SunMesh mesh;
    const int around = 2 * rings;
    for (int i = 0; i <= rings; ++i)
        for (int j = 0; j <= around; ++j) {
            const double theta = std::numbers::pi * i / rings, phi = 2 * std::numbers::pi * j / around;
            mesh.positions.push_back(
                toFloat(Vec3d{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)}));
        }
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < around; ++j) {
            const auto at = std::uint32_t(i * (around + 1) + j), below = at + std::uint32_t(around) + 1;
            mesh.triangles.insert(mesh.triangles.end(), {at, below, at + 1, at + 1, below, below + 1});
        }
    return mesh;
}

// A square ground around the origin with points^2 heights.
inline SunMesh sunGround(
    float side, int points, const std::function<float(float, float)>& height = [](float, float) { return 0.0f; }) {
    SunMesh mesh;
    const auto at = [&](int i) { return side * (float(i) / float(points - 1) - 0.5f); };
    for (int r = 0; r < points; ++r)
        for (int c = 0; c < points; ++c) mesh.positions.push_back({at(c), at(r), height(at(c), at(r))});
    for (int r = 0; r + 1 < points; ++r)
        for (int c = 0; c + 1 < points; ++c) {
            const auto a = std::uint32_t(r * points + c), b = a + std::uint32_t(points);
            mesh.triangles.insert(mesh.triangles.end(), {a, a + 1, b, b, a + 1, b + 1});
        }
    return mesh;
}

inline SunMap sunMapOf(std::span<const SunCaster> casters, Vec3 direction, float radius, int size = kSunMapSize) {
    SunMap map;
    map.begin(fitSunFrame(casters, direction, radius, size));
    map.draw(casters);
    return map;
}

inline SunNest sunNestOf(const SunCasters& casters, Vec3 direction, float radius, int size = kSunMapSize) {
    SunNest nest;
    fitSunNest(casters, direction, radius, size, nest);
    return nest;
}

}  // namespace penumbra::player_test
