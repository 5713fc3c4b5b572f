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

CastReceivers blockOf(const CastReceivers& receivers, std::size_t first, std::size_t count) {
    return {receivers.positions.subspan(first, count), receivers.normals.subspan(first, count),
            receivers.tangents.subspan(first, count)};
}

}  // namespace

void CastAnchors::Values::keepNear(std::size_t anchors, std::size_t found) {
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

// Adds up the parts, as many at a time as the kernel takes.
void CastShadow::sumFields(const CastReceivers& anchors, float spacing, std::span<const std::uint16_t> parts,
                           std::span<float> values) const {
    const std::size_t wide = anchorStride(parts.size());
    std::array<float, kMaxReceivers * anchorStride(kMaxAnchorParts)> some;
    for (std::size_t part = 0; part < parts.size(); part += kMaxAnchorParts) {
        const std::size_t count = std::min(kMaxAnchorParts, parts.size() - part), stride = anchorStride(count);
        const FarScene scene{tables_.data(), posed_.data(), parts.data() + part, count, spacing};
        for (std::size_t first = 0; first < anchors.positions.size(); first += kMaxReceivers) {
            const std::size_t n = std::min(kMaxReceivers, anchors.positions.size() - first);
            const Vec3* normals = anchors.normals.data() + first;
            fastestFarPath().anchors(*constants_, scene, {anchors.positions.data() + first, normals, normals, n},
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

void CastShadow::sumAnchors(const CastReceivers& anchors, const CasterSphere& around, float spacing,
                            CasterChoice choice, CastAnchors& out) const {
    thread_local Found found;
    const std::size_t count = anchors.positions.size();
    out.choice = choice;
    out.near_parts.clear();
    out.near_spheres.clear();
    findParts(around, choice, found);
    out.has_fields = !found.parts.empty();
    out.has_spheres = !found.spheres.empty();
    out.sums = count > 0 && exponential_.isDefault() && (out.has_fields || out.has_spheres);
    if (!out.sums) return;
    if (out.has_fields) {
        out.fields.all.assign(count * anchorStride(found.parts.size()), 0.0f);
        sumFields(anchors, spacing, found.parts, out.fields.all);
        out.fields.keepNear(count, found.parts.size());
        for (const std::size_t i : out.fields.near) out.near_parts.push_back(found.parts[i]);
    }
    if (out.has_spheres) {
        out.spheres.all.resize(count * anchorStride(found.spheres.size()));
        castAnchors(found.spheres, anchors.positions, spacing, kSphereFade, out.spheres.all);
        out.spheres.keepNear(count, found.spheres.size());
        for (const std::size_t i : out.spheres.near) out.near_spheres.push_back(found.spheres[i]);
    }
    out.sums = std::max(out.near_parts.size(), out.near_spheres.size()) <= kMaxNearParts;
}

std::size_t CastShadow::evaluateAt(const CastAnchors& anchors, const CastReceivers& vertices,
                                   const std::uint16_t* anchor, const float* weight, std::span<float> out) const {
    const std::size_t count = vertices.positions.size();
    assert(out.size() == count * kFarCoefficients);
    if (!anchors.sums) return evaluate(vertices, anchors.choice, out);
    std::array<float, kMaxReceivers * kFarCoefficients> by_spheres;
    for (std::size_t first = 0; first < count; first += kMaxReceivers) {
        const std::size_t n = std::min(kMaxReceivers, count - first), at = first * kAnchorsOfReceiver;
        const CastReceivers block = blockOf(vertices, first, n);
        const std::span<float> rows = out.subspan(first * kFarCoefficients, n * kFarCoefficients);
        if (anchors.has_fields)
            castFields(block, anchors.near_parts, anchors.fields.view(anchor + at, weight + at), rows);
        if (anchors.has_spheres) {
            const std::span<float> factor = anchors.has_fields ? std::span(by_spheres).first(rows.size()) : rows;
            castMirrored(anchors.near_spheres, anchors.spheres.view(anchor + at, weight + at),
                         {block.positions, block.normals, block.tangents}, kSphereFade, factor);
            if (anchors.has_fields) multiplyBySpheres(factor, rows);
        }
        finish(rows);
    }
    return count;
}

std::size_t CastShadow::evaluateRun(const CastRun& run, CasterChoice choice, std::span<float> out) const {
    if (run.vertices.positions.empty()) return 0;
    thread_local CastAnchors anchors;
    CasterSphere around = sphereAround(run.vertices.positions);
    for (const Vec3 p : run.anchors.positions) around.radius = std::max(around.radius, length(p - around.center));
    sumAnchors(run.anchors, around, run.spacing, choice, anchors);
    return evaluateAt(anchors, run.vertices, run.anchor, run.weight, out);
}

}  // namespace penumbra
