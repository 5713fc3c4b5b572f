// Measures the light that a point gets from the sky and from other surfaces.
//
// Problem: light reaches a point by several reflections. With the outgoing transfer x_q = albedo_q t_q of the surface
// point q that a ray meets first, one more reflection is t'_p = (1 / pi) integral over the hits of cos x_q.
//
// Naive: trace all rays again for each bounce, and look up x at each hit. That costs as much as the first bake each
// time. Keeping all hits instead costs 16 bytes a ray.
//
// Here: the rays of a point see few vertices many times. We add the weights of all hits up by vertex, which gives one
// row of a sparse matrix, so that each bounce is a product of this matrix with the vectors x. A row of 1024 rays has a
// few hundred entries. Section "Light that bounces" of docs/formulas.md derives the terms.
#include "bake/trace/transfer.h"

#include <algorithm>
#include <cassert>

#include "formats/common/twin_triangles.h"

namespace penumbra {

namespace {

// Adds up the weights of one point by vertex.
class RowSum {
public:
    explicit RowSum(std::size_t vertices) : place_(vertices, 0) {}
    void add(std::uint32_t vertex, float weight) {
        if (place_[vertex] == 0) {
            row_.push_back({vertex, 0});
            place_[vertex] = std::uint32_t(row_.size());
        }
        row_[place_[vertex] - 1].weight += weight;
    }
    // Returns the row of the point and starts the next one. Rows are in the order in which rays met the vertices.
    BounceRow take() {
        for (const BounceEntry& entry : row_) place_[entry.vertex] = 0;
        BounceRow exact(row_.begin(), row_.end());
        row_.clear();
        return exact;
    }

private:
    std::vector<std::uint32_t> place_;  // [V] 1 + where the vertex stands in row_; 0: not there. All 0 between points
    BounceRow row_;
};

// Multiplies the weight of each ray by its cosine with the normal.
void weighByCosine(const RayDirections& directions, Vec3 normal, std::span<LaneWeights> rays) {
    for (std::size_t p = 0; p < rays.size(); ++p) {
        const DirectionPacket& d = directions.packets[p];
        for (std::size_t k = 0; k < kLanes; ++k)
            rays[p].lane[k] *= d.x[k] * normal.x + d.y[k] * normal.y + d.z[k] * normal.z;
    }
}

// Makes the row of a point from what its rays hit first. Returns how many hits were backs that reflect nothing.
std::size_t addHits(const MomentTracer& tracer, Vec3 normal, std::span<const FirstHit> hits, RowSum& sum) {
    const Mesh& mesh = *tracer.mesh;
    const auto fronts = std::uint32_t(mesh.frontVertexCount());
    const std::size_t front_triangles = mesh.frontTriangleCount();
    const std::span<const std::uint32_t> twins =
        tracer.blockers ? std::span<const std::uint32_t>(tracer.blockers->twins) : std::span<const std::uint32_t>{};
    const float scale = 4 / float(tracer.directions.count);  // the solid angle of a ray over pi
    std::size_t backs = 0;
    for (const FirstHit& hit : hits) {
        if (hit.triangle >= front_triangles) continue;  // occluders are black
        const bool has_twin = hit.triangle < twins.size() && twins[hit.triangle] != hit.triangle;
        if (hit.back && !mesh.two_sided && !has_twin) {
            ++backs;
            continue;
        }
        const Triangle corner =
            hit.back && has_twin ? twinCorners(mesh, hit.triangle, twins[hit.triangle]) : mesh.triangles[hit.triangle];
        const std::uint32_t side = hit.back && !has_twin ? fronts : 0;
        const DirectionPacket& d = tracer.directions.packets[hit.ray / kLanes];
        const std::size_t k = hit.ray % kLanes;
        const float weight = scale * (d.x[k] * normal.x + d.y[k] * normal.y + d.z[k] * normal.z);
        sum.add(corner[0] + side, weight * (1 - hit.u - hit.v));
        sum.add(corner[1] + side, weight * hit.u);
        sum.add(corner[2] + side, weight * hit.v);
    }
    return backs;
}

}  // namespace

RayCounts traceTransfer(const MomentTracer& tracer, std::span<const Vec3> positions, std::span<const Vec3> normals,
                        const TransferOutput& out, std::size_t first_vertex) {
    const RayDirections& directions = tracer.directions;
    const auto size = std::size_t(coefficientCount(directions.order));
    assert(positions.size() == normals.size() && out.direct.size() == positions.size() * size);
    assert(out.rows.empty() || out.rows.size() == positions.size());
    std::vector<LaneWeights> rays(directions.packets.size());
    std::vector<FirstHit> hits;
    RowSum sum(out.rows.empty() ? 0 : tracer.mesh->vertexCount());
    RayCounts counts;
    for (std::size_t v = 0; v < positions.size(); ++v) {
        const std::span<float> direct = out.direct.subspan(v * size, size);
        const RayStart start = startOfVertex(tracer, positions[v], normals[v], first_vertex + v);
        // 1. A point that touches another surface gets no light.
        if (start.closed) {
            std::fill(direct.begin(), direct.end(), 0.0f);
            continue;
        }
        // 2. The rays that escape, weighted by their cosine, give the direct transfer.
        counts.traced += aboveHorizon(directions, normals[v], tracer.floor, rays);
        if (out.rows.empty()) {
            tracer.scene.removeOccluded(start.position, directions, rays);
        } else {
            hits.clear();
            tracer.scene.removeOccluded(start.position, directions, rays, hits);
            counts.hits += hits.size();
        }
        weighByCosine(directions, normals[v], rays);
        accumulateMoments(directions, rays, direct);
        // 3. The others tell which vertices the point gets light from.
        if (out.rows.empty()) continue;
        counts.backs += addHits(tracer, normals[v], hits, sum);
        out.rows[v] = sum.take();
    }
    return counts;
}

void bounce(std::span<const BounceRow> rows, std::span<const float> outgoing, std::size_t size, std::span<float> out) {
    assert(out.size() == rows.size() * size);
    std::fill(out.begin(), out.end(), 0.0f);
    for (std::size_t p = 0; p < rows.size(); ++p) {
        float* sum = out.data() + p * size;
        for (const BounceEntry& entry : rows[p]) {
            const float* x = outgoing.data() + entry.vertex * size;
            for (std::size_t i = 0; i < size; ++i) sum[i] += entry.weight * x[i];
        }
    }
}

}  // namespace penumbra
