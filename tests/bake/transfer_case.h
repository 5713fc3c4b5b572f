#pragma once
// Bakes of diffuse transfer of a shape in one pose.
#include <span>
#include <vector>

#include "bake/visibility/bake_transfer.h"
#include "tests/bake/shapes.h"

namespace penumbra::transfers {

// A shape in one pose, what it does with light, and the options of its bake.
struct TransferCase {
    shapes::Shape shape;
    std::vector<Vec3> normals;  // [V] of the fronts
    SurfaceColors colors;       // [V], with backs where two_sided
    bool two_sided = false;
    int order = 4, rays = 1024, bounces = 3;
    float bias = 1e-4f;
};

// The result of baking a case, one row per vertex.
struct Transfer {
    std::size_t n2 = 0;
    std::vector<float> direct, indirect;
    std::vector<float> hit_shares;

    std::span<const float> directOf(std::size_t v) const { return std::span(direct).subspan(v * n2, n2); }
    std::span<const float> indirectOf(std::size_t v, std::size_t channel) const {
        return std::span(indirect).subspan((3 * v + channel) * n2, n2);
    }
    std::vector<double> sumOf(std::size_t v, std::size_t channel) const {
        std::vector<double> sum(directOf(v).begin(), directOf(v).end());
        for (std::size_t i = 0; i < n2; ++i) sum[i] += double(indirectOf(v, channel)[i]);
        return sum;
    }
};

inline SurfaceColors sameAlbedo(std::size_t vertices, Vec3 albedo) { return {std::vector<Vec3>(vertices, albedo)}; }

inline Transfer bakeCase(const TransferCase& of, int threads = 2) {
    VisibilityHeader header;
    header.order = of.order;
    header.quantity = kDiffuseTransfer;
    header.bounces = of.bounces;
    header.colors = of.colors;
    header.mesh.triangles = of.shape.triangles;
    header.mesh.rest_positions = of.shape.positions;
    VisibilityFrame frame{of.shape.positions, of.normals, {}, {}, {}};
    const SceneScale scale = sceneScale(of.shape.positions, boxDiagonal(of.shape.positions));
    std::vector<Vec3> scaled;
    for (Vec3 p : of.shape.positions) scaled.push_back(scale.apply(p));
    const OcclusionScene scene(scaled, of.shape.triangles);
    if (of.two_sided) {
        header.mesh = withBacks(header.mesh);
        appendBackPositions(frame.positions);
        appendBackNormals(frame.normals);
    }
    frame.coefficients.resize(frame.positions.size() * header.coefficientCount());
    frame.indirect.resize(frame.positions.size() * header.indirectCount());
    const RayDirections directions = makeRayDirections(of.rays, 1, of.order);
    MomentTracer tracer{scene, directions, scale, of.bias};
    tracer.mesh = &header.mesh;
    FrameBounces bounces(header);
    bounces.add(traceTransfer(tracer, frame.positions, frame.normals, {frame.coefficients, bounces.rows}, 0));
    if (header.hasBounces()) addBounces(header, bounces, threads, frame);
    return {header.coefficientCount(), frame.coefficients, frame.indirect, frame.hit_shares};
}

}  // namespace penumbra::transfers
