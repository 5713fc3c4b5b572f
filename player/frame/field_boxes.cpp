#include "player/frame/field_boxes.h"

#include <cmath>
#include <numbers>

namespace penumbra {

namespace {

// Half the width of a ribbon, in distances from the eye: with a field of view of 40 degrees, 512 rows are 0.0014 each.
constexpr float kFineWidth = 0.0014f, kCoarseWidth = 0.0006f;

}  // namespace

std::vector<BoxEdge> fieldBoxEdges(const CompositionView& composition, std::span<const Affine> bones,
                                   std::span<const std::size_t> parts) {
    std::vector<BoxEdge> edges;
    for (const std::size_t p : parts) {
        const PartField& field = composition.parts[p].field;
        const Affine bone = field.joint == kStillJoint ? Affine{} : bones[field.joint];
        for (std::size_t b = 0; b < field.boxes.size(); ++b) {
            // Bit i of a corner tells whether it lies at the high end of axis i.
            const auto corner = [&](unsigned c) {
                const FieldBox& box = field.boxes[b];
                return bone.point(
                    {c & 1 ? box.high.x : box.low.x, c & 2 ? box.high.y : box.low.y, c & 4 ? box.high.z : box.low.z});
            };
            for (unsigned c = 0; c < 8; ++c)
                for (const unsigned axis : {1u, 2u, 4u})
                    if (!(c & axis)) edges.push_back({corner(c), corner(c | axis), p, b == 0});
        }
    }
    return edges;
}

std::vector<BoxEdge> sphereEdges(const BlockersView& blockers, std::span<const Affine> bones) {
    constexpr int kPieces = 32;  // pieces of a circle
    std::vector<BoxEdge> edges;
    for (std::size_t s = 0; s < blockers.spheres.size(); ++s) {
        const CasterSphere sphere = movedBy(bones[blockers.joints[s]], blockers.spheres[s]);
        for (int axis = 0; axis < 3; ++axis)
            for (int piece = 0; piece < kPieces; ++piece) {
                const auto at = [&](int i) {
                    const double angle = 2 * std::numbers::pi * i / kPieces;
                    Vec3 p = sphere.center;
                    p[(axis + 1) % 3] += sphere.radius * float(std::cos(angle));
                    p[(axis + 2) % 3] += sphere.radius * float(std::sin(angle));
                    return p;
                };
                edges.push_back({at(piece), at(piece + 1), blockers.joints[s], false});
            }
    }
    return edges;
}

Shape edgeRibbons(std::span<const BoxEdge> edges, Vec3 eye) {
    Shape ribbons;
    for (const BoxEdge& edge : edges) {
        const auto first = std::uint32_t(ribbons.positions.size());
        const Vec3 across = cross(edge.to - edge.from, edge.from - eye);
        const float size = length(across);
        const Vec3 side = size > 0 ? across / size : Vec3{};
        for (const Vec3& end : {edge.from, edge.to}) {
            const Vec3 half = side * ((edge.fine ? kFineWidth : kCoarseWidth) * length(end - eye));
            ribbons.positions.push_back(end - half);
            ribbons.positions.push_back(end + half);
        }
        ribbons.values.insert(ribbons.values.end(), 4, {float(edge.part), 0, 0});
        ribbons.triangles.insert(ribbons.triangles.end(),
                                 {first, first + 1, first + 2, first + 1, first + 3, first + 2});
    }
    return ribbons;
}

}  // namespace penumbra
