#pragma once
// Moments of both sides of thin sheets, and their closed forms.
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "bake/trace/moments.h"
#include "tests/bake/shapes.h"
#include "tests/difference.h"

namespace penumbra::sheets {

inline constexpr int kOrder = 5;
inline constexpr std::size_t kSize = 25;

struct Sheet {
    Mesh mesh;  // two-sided
    std::vector<Vec3> positions, normals;
};

inline Sheet sheetOf(const shapes::Shape& shape) {
    Mesh mesh;
    mesh.triangles = shape.triangles;
    mesh.rest_positions = shape.positions;
    Sheet sheet{withBacks(mesh), shape.positions, vertexNormals(shape.triangles, shape.positions)};
    appendBackPositions(sheet.positions);
    appendBackNormals(sheet.normals);
    return sheet;
}

// Moments of fronts, then of backs.
inline std::vector<float> momentsOf(const shapes::Shape& shape, const shapes::Shape& occluder, int rays = 1024,
                                    Floor floor = Floor::kNone) {
    const Sheet sheet = sheetOf(shape);
    Blockers blockers;
    blockers.add(shape.triangles, shape.positions);
    blockers.add(occluder.triangles, occluder.positions);
    const SceneScale scale = sceneScale(shape.positions, boxDiagonal(shape.positions));
    std::vector<Vec3> scaled(shape.positions);
    scaled.insert(scaled.end(), occluder.positions.begin(), occluder.positions.end());
    for (Vec3& p : scaled) p = scale.apply(p);
    const OcclusionScene scene(scaled, blockers.triangles, Queries::kFiltered);
    const RayDirections directions = makeRayDirections(rays, 1, kOrder);
    MomentTracer tracer{scene, directions, scale, 1e-4f, floor};
    tracer.blockers = &blockers;
    tracer.mesh = &sheet.mesh;
    tracer.vertices = sheet.positions;
    std::vector<float> b(sheet.positions.size() * kSize);
    traceMoments(tracer, sheet.positions, sheet.normals, {b});
    return b;
}

inline std::span<const float> at(const std::vector<float>& b, std::size_t v) {
    return std::span(b).subspan(v * kSize, kSize);
}

// Returns the moments of a hemisphere of which a cap of half-angle `blocked` around the normal is blocked (0: all is
// open). They are zonal about the normal: b_l is 2 pi sqrt((2l+1)/4pi) times the integral of P_l from 0 to
// cos(blocked), and that integral is (P_(l+1) - P_(l-1)) / (2l+1) between the two ends.
inline std::vector<double> capMoments(Vec3d normal, double blocked) {
    const double top = std::cos(blocked);
    const auto integral = [&](unsigned l) {
        if (l == 0) return top;
        const auto at = [&](double x) { return (std::legendre(l + 1, x) - std::legendre(l - 1, x)) / (2 * l + 1); };
        return at(top) - at(0);
    };
    std::vector<double> y(kSize), b(kSize);
    evalBasis(kOrder, normal, y);
    for (unsigned l = 0; l < unsigned(kOrder); ++l)
        for (unsigned i = l * l; i < (l + 1) * (l + 1); ++i) b[i] = 2 * std::numbers::pi * integral(l) * y[i];
    return b;
}

inline double size(std::span<const float> b) {
    double sum = 0;
    for (const float x : b) sum += double(x) * x;
    return std::sqrt(sum);
}

// Distance of `b` from the closed form in units of the open hemisphere's.
inline double errorOf(std::span<const float> b, const std::vector<double>& expected) {
    double open = 0;
    for (const double x : capMoments({0, 1, 0}, 0)) open += x * x;
    return distanceBetween(b, expected) / std::sqrt(open);
}

// A grid of side x side vertices of size 2 about the y axis at height `height`, fronts up.
inline shapes::Shape grid(int side, double height) {
    shapes::Shape s;
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j)
            s.positions.push_back(toFloat({2.0 * i / (side - 1) - 1, height, 2.0 * j / (side - 1) - 1}));
    const auto corner = [&](int i, int j) { return std::uint32_t(i * side + j); };
    for (int i = 0; i + 1 < side; ++i)
        for (int j = 0; j + 1 < side; ++j) {
            s.triangles.push_back({corner(i, j), corner(i, j + 1), corner(i + 1, j)});
            s.triangles.push_back({corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)});
        }
    return s;
}

}  // namespace penumbra::sheets
