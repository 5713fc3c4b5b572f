#include "player/view/view_pick.h"

#include <cmath>
#include <limits>

namespace penumbra {

namespace {

struct Hit {
    double distance = 0, u = 0, v = 0;  // p = (1 - u - v) a + u b + v c
};

// Intersects as Moeller and Trumbore do ("Fast, minimum storage ray/triangle intersection", 1997). The determinant is
// above 0 where the front is seen.
std::optional<Hit> intersect(Vec3d origin, Vec3d direction, Vec3d a, Vec3d b, Vec3d c, bool fronts) {
    const Vec3d ab = b - a, ac = c - a, p = cross(direction, ac);
    const double determinant = dot(ab, p);
    if (determinant == 0 || (fronts && determinant < 0)) return std::nullopt;
    const Vec3d from_a = origin - a, q = cross(from_a, ab);
    const Hit hit{dot(ac, q) / determinant, dot(from_a, p) / determinant, dot(direction, q) / determinant};
    if (!(hit.u >= 0 && hit.v >= 0 && hit.u + hit.v <= 1 && hit.distance > 0)) return std::nullopt;
    return hit;
}

}  // namespace

std::optional<std::size_t> pickVertex(std::span<const Vec3> positions, const MeshView& mesh, Vec3d origin,
                                      Vec3d direction, double& distance) {
    const std::span<const std::uint32_t> triangles = mesh.triangles;
    std::optional<std::size_t> nearest;
    distance = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
        const auto corner = [&](std::size_t i) { return toDouble(positions[triangles[t + i]]); };
        const std::optional<Hit> hit = intersect(origin, direction, corner(0), corner(1), corner(2), mesh.two_sided);
        if (!hit || hit->distance >= distance) continue;
        distance = hit->distance;
        const double w = 1 - hit->u - hit->v;
        nearest = triangles[t + (w >= hit->u && w >= hit->v ? 0u : hit->u >= hit->v ? 1u : 2u)];
    }
    return nearest;
}

std::optional<PickedVertex> pick(const Scene& scene, const ViewState& state, const Rectangle& picture, double x,
                                 double y) {
    std::optional<PickedVertex> nearest;
    double nearest_distance = std::numeric_limits<double>::infinity();
    for (const Pane& pane : panesOf(state, picture)) {
        const Rectangle& clip = pane.clip;
        if (x < clip.x || y < clip.y || x >= clip.x + clip.width || y >= clip.y + clip.height) continue;
        const Vec3d direction =
            pixelDirection(state.camera, x - pane.area.x, y - pane.area.y, pane.area.width, pane.area.height);
        for (std::size_t i = 0; i < scene.characters.size(); ++i) {
            const Character& character = *scene.characters[i];
            double distance = 0;
            const Mat3d to_model = transposed(toDouble(character.to_scene.linear()));
            const Vec3d from = cameraPosition(state.camera) - toDouble(character.to_scene.translation());
            const auto vertex = pickVertex(character.vertices.positions, character.asset.mesh, to_model * from,
                                           to_model * direction, distance);
            if (!vertex || distance >= nearest_distance) continue;
            nearest_distance = distance;
            nearest = PickedVertex{i, *vertex};
        }
    }
    return nearest;
}

std::optional<Vec3d> pointAtHeight(const ViewState& state, double height, const Rectangle& picture, double x,
                                   double y) {
    constexpr double kFarthest = 20;  // times the camera's distance
    for (const Pane& pane : panesOf(state, picture)) {
        if (x < pane.clip.x || x >= pane.clip.x + pane.clip.width) continue;
        const Vec3d eye = cameraPosition(state.camera),
                    way = pixelDirection(state.camera, x - pane.area.x, y - pane.area.y, pane.area.width,
                                         pane.area.height);
        const double along = (height - eye.y) / way.y;
        if (!(along > 0 && along < kFarthest * state.camera.distance)) return std::nullopt;
        return eye + way * along;
    }
    return std::nullopt;
}

}  // namespace penumbra
