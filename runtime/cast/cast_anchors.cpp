// Casts on the vertices of a character at anchors.
//
// Problem: a character of 13,000 vertices looks up the 30 parts of every neighbour at each of them, 16 ms a neighbour.
//
// Here: what is far away or small changes little from a vertex to the next. One vertex in 12 is an anchor, which sums
// the logarithms of all such parts and spheres over the whole sphere of directions. The vertices around interpolate the
// sum, and only then comes the horizon of each. What stands near an anchor or hides much of it is left out of the sum,
// and the vertices multiply it in one by one, with a weight that they interpolate as well. So nothing pops.
#include <algorithm>
#include <array>
#include <cassert>

#include "runtime/cast/cast_shadow.h"
#include "sh/far/far_tables.h"

namespace penumbra {

namespace {

// The values of the anchors of a run, and which parts or spheres are near to any of them. It keeps its room.
struct Anchored {
    std::vector<float> all, values;  // [anchors, anchorStride(]of all that is found, and of what is near[)]
    std::vector<std::size_t> near;   // index into what is found

    // Makes `values` of `all`, in which `found` things have columns.
    void keepNear(std::size_t anchors, std::size_t found) {
        const std::size_t wide = anchorStride(found);
        near.clear();
        for (std::size_t i = 0; i < found; ++i)
            for (std::size_t a = 0; a < anchors; ++a) {
                if (!(all[a * wide + kAnchorSums + i] > 0)) continue;
                near.push_back(i);
                break;
            }
        const std::size_t stride = anchorStride(near.size());
        values.assign(anchors * stride, 0.0f);
        for (std::size_t a = 0; a < anchors; ++a) {
            std::copy_n(&all[a * wide], kAnchorSums, &values[a * stride]);
            for (std::size_t i = 0; i < near.size(); ++i)
                values[a * stride + kAnchorSums + i] = all[a * wide + kAnchorSums + near[i]];
        }
    }
    FarAnchors view(const CastRun& run, std::size_t first) const {
        return {values.data(), anchorStride(near.size()), run.anchor + first * kAnchorsOfReceiver,
                run.weight + first * kAnchorsOfReceiver};
    }
};

CastReceivers blockOf(const CastReceivers& receivers, std::size_t first, std::size_t count) {
    return {receivers.positions.subspan(first, count), receivers.normals.subspan(first, count),
            receivers.tangents.subspan(first, count)};
}

}  // namespace

// Adds up the parts, as many at a time as the kernel takes.
void CastShadow::sumFields(const CastRun& run, std::span<const std::uint16_t> parts, std::span<float> values) const {
    const std::size_t wide = anchorStride(parts.size());
    std::array<float, kMaxReceivers * anchorStride(kMaxAnchorParts)> some;
    for (std::size_t part = 0; part < parts.size(); part += kMaxAnchorParts) {
        const std::size_t count = std::min(kMaxAnchorParts, parts.size() - part), stride = anchorStride(count);
        const FarScene scene{tables_.data(), posed_.data(), parts.data() + part, count, run.spacing};
        for (std::size_t first = 0; first < run.anchors.positions.size(); first += kMaxReceivers) {
            const std::size_t n = std::min(kMaxReceivers, run.anchors.positions.size() - first);
            const Vec3* normals = run.anchors.normals.data() + first;
            fastestFarPath().anchors(*constants_, scene, {run.anchors.positions.data() + first, normals, normals, n},
                                     some.data());
            for (std::size_t a = 0; a < n; ++a) {
                const float* from = &some[a * stride];
                float* to = &values[(first + a) * wide];
                for (std::size_t i = 0; i < kAnchorSums; ++i) to[i] += from[i];
                std::copy_n(from + kAnchorSums, count, to + kAnchorSums + part);
            }
        }
    }
}

std::size_t CastShadow::evaluateRun(const CastRun& run, CasterChoice choice, std::span<float> out) const {
    const std::size_t count = run.vertices.positions.size(), anchors = run.anchors.positions.size();
    assert(out.size() == count * kFarNumbers);
    if (anchors == 0 || count == 0 || !exponential_.isDefault()) return evaluate(run.vertices, choice, out);
    thread_local Found found;
    thread_local Anchored fields, spheres;
    thread_local std::vector<std::uint16_t> near_parts;
    thread_local std::vector<CasterSphere> near_spheres;
    CasterSphere around = sphereAround(run.vertices.positions);
    for (const Vec3 p : run.anchors.positions) around.radius = std::max(around.radius, length(p - around.center));
    findParts(around, choice, found);
    const bool has_fields = !found.parts.empty(), has_spheres = !found.spheres.empty();
    if (!has_fields && !has_spheres) return evaluate(run.vertices, choice, out);
    // 1. The anchors.
    if (has_fields) {
        fields.all.assign(anchors * anchorStride(found.parts.size()), 0.0f);
        sumFields(run, found.parts, fields.all);
        fields.keepNear(anchors, found.parts.size());
        near_parts.clear();
        for (const std::size_t i : fields.near) near_parts.push_back(found.parts[i]);
    }
    if (has_spheres) {
        spheres.all.resize(anchors * anchorStride(found.spheres.size()));
        castAnchors(found.spheres, run.anchors.positions, run.spacing, kSphereFade, spheres.all);
        spheres.keepNear(anchors, found.spheres.size());
        near_spheres.clear();
        for (const std::size_t i : spheres.near) near_spheres.push_back(found.spheres[i]);
    }
    if (std::max(has_fields ? near_parts.size() : 0, has_spheres ? near_spheres.size() : 0) > kMaxNearParts)
        return evaluate(run.vertices, choice, out);
    // 2. The vertices.
    std::array<float, kMaxReceivers * kFarNumbers> by_spheres;
    for (std::size_t first = 0; first < count; first += kMaxReceivers) {
        const std::size_t n = std::min(kMaxReceivers, count - first);
        const CastReceivers block = blockOf(run.vertices, first, n);
        const std::span<float> rows = out.subspan(first * kFarNumbers, n * kFarNumbers);
        if (has_fields) castFields(block, near_parts, fields.view(run, first), rows);
        if (has_spheres) {
            const std::span<float> factor = has_fields ? std::span(by_spheres).first(rows.size()) : rows;
            castMirrored(near_spheres, spheres.view(run, first), {block.positions, block.normals, block.tangents},
                         kSphereFade, factor);
            if (has_fields) multiplyBySpheres(factor, rows);
        }
        finish(rows);
    }
    return count;
}

}  // namespace penumbra
