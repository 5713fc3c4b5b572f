// Matches the vertices of a .glb with the points of a bake or an asset.
//
// Problem: the artist's file may be the one that was baked, the same with another order of its vertices, or another
// character. An occlusion on the wrong vertices looks like dirt, and is noticed late.
//
// Naive: trust the numbers of vertices, which are often equal by chance or a little off.
//
// Here: numbers count only where every vertex also rests where its point does. Else each vertex looks for points that
// rest within a ten-thousandth of the diagonal, and takes the one whose normal and material agree best.
#include "pack/export/export_rows.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "formats/common/errors.h"
#include "formats/rig/point_grid.h"

namespace penumbra {

namespace {

constexpr double kSamePlace = 1e-4;                           // diagonals of the source at rest
constexpr double kFarthestLevel = 0.02, kMaxFarLevel = 0.01;  // same limits as for levels of detail in assets
                                                              // (lod_mesh.h)

void takePoint(ExportRows& rows, std::size_t row, std::uint32_t point) {
    rows.points.corners[row] = {point, point, point};
    rows.points.weights[row] = {1, 0, 0};
}

void resizeRows(ExportRows& rows, std::size_t count) {
    rows.points.corners.resize(count);
    rows.points.weights.resize(count);
}

// Tells whether row r of both is at one place and on one side of a hard edge, for all rows.
bool sameRows(const OcclusionSource& source, const Rig& rig, double near) {
    constexpr float kSameSide = 0.9f;  // cosine
    const Mesh& mesh = source.mesh();
    if (mesh.source_vertex.size() != rig.mesh.source_vertex.size()) return false;
    for (std::size_t r = 0; r < mesh.source_vertex.size(); ++r) {
        const std::uint32_t a = mesh.source_vertex[r], b = rig.mesh.source_vertex[r];
        if (!(double(length(mesh.rest_positions[a] - rig.mesh.rest_positions[b])) <= near)) return false;
        if (!(dot(source.restNormals()[a], rig.rest_normals[b]) > kSameSide)) return false;
    }
    return true;
}

// Points of the fronts of a source, to be found by their places.
class PlaceFinder {
public:
    PlaceFinder(const OcclusionSource& source, const Rig& rig, double near)
        : source_(source), rig_(rig), near_(near), grid_(near, 64 * near) {
        is_front_.resize(source.mesh().vertexCount());
        for (const std::uint32_t point : source.mesh().source_vertex) is_front_[point] = true;
        for (std::uint32_t p = 0; p < is_front_.size(); ++p) grid_.add(toDouble(source.mesh().rest_positions[p]), p);
    }

    // Returns the best point for a point of the rig, or PointGrid::kNone.
    std::uint32_t find(std::uint32_t of_rig) const {
        const Mesh& mesh = source_.mesh();
        const Vec3d place = toDouble(rig_.mesh.rest_positions[of_rig]);
        std::uint32_t best = PointGrid::kNone;
        double best_score = -10;
        (void)grid_.find(place, [&](std::uint32_t p) {
            if (!is_front_[p] || !(length(toDouble(mesh.rest_positions[p]) - place) <= near_)) return false;
            const double score = scoreOf(p, of_rig);
            if (score > best_score || (score == best_score && p < best)) {
                best_score = score;
                best = p;
            }
            return false;  // go on: all that are near are looked at
        });
        return best;
    }

private:
    const OcclusionSource& source_;
    const Rig& rig_;
    double near_;
    PointGrid grid_;
    std::vector<bool> is_front_;

    // The cosine between the normals, and 1 more where the slots have one name.
    double scoreOf(std::uint32_t point, std::uint32_t of_rig) const {
        const auto slot = [](const Mesh& mesh, std::uint32_t v) {
            return mesh.slot_of_vertex.empty() ? std::string() : mesh.slots[mesh.slot_of_vertex[v]];
        };
        const double normals = double(dot(source_.restNormals()[point], rig_.rest_normals[of_rig]));
        return normals + (slot(source_.mesh(), point) == slot(rig_.mesh, of_rig) ? 1 : 0);
    }
};

std::string slotOfPart(const Rig& rig, std::size_t part) {
    const std::size_t slot = rig.part_colors[part].slot;
    return slot < rig.mesh.slots.size() ? rig.mesh.slots[slot] : "default";
}

void matchPart(const PlaceFinder& finder, const Rig& rig, std::size_t part, ExportRows& rows) {
    const ColoredPart& of = rig.part_colors[part];
    std::size_t missing = 0, first = 0;
    for (std::size_t r = of.first_vertex; r < of.first_vertex + of.vertices; ++r) {
        const std::uint32_t point = finder.find(rig.mesh.source_vertex[r]);
        if (point != PointGrid::kNone)
            takePoint(rows, r, point);
        else if (missing++ == 0)
            first = r - of.first_vertex;
    }
    if (missing == of.vertices) {
        rows.left_out.push_back(slotOfPart(rig, part));
    } else if (missing > 0) {
        const Vec3 p = rig.mesh.rest_positions[rig.mesh.source_vertex[of.first_vertex + first]];
        char place[80];
        std::snprintf(place, sizeof place, "(%.4g, %.4g, %.4g)", double(p.x), double(p.y), double(p.z));
        throw InvalidInput("'" + slotOfPart(rig, part) + "': " + std::to_string(missing) + " of " +
                           std::to_string(of.vertices) + " vertices rest where the source has none, the first at " +
                           place + ": it is another character, another rest pose or another level of detail");
    } else {
        rows.parts.push_back(part);
        rows.by_place += of.vertices;
    }
}

void allParts(const Rig& rig, ExportRows& rows) {
    for (std::size_t p = 0; p < rig.part_colors.size(); ++p) rows.parts.push_back(p);
}

ExportRows matchLevel(const OcclusionSource& source, const Rig& rig, int threads) {
    ExportRows rows;
    PointDistances distances;
    const PointTable of_points =
        nearestPoints({source.mesh(), source.restNormals()}, {rig.mesh, rig.rest_normals}, nullptr, threads, distances);
    const double diagonal = boxDiagonal(source.mesh().rest_positions);
    std::size_t far = 0;
    for (const float d : distances.distance) {
        far += !(double(d) <= kFarthestLevel * diagonal);
        if (std::isfinite(d)) rows.max_distance = std::max(rows.max_distance, double(d) / diagonal);
    }
    if (double(far) > kMaxFarLevel * double(distances.distance.size()))
        throw InvalidInput(std::to_string(far) + " of " + std::to_string(distances.distance.size()) +
                           " points are farther than 0.02 diagonals from the surface of the source, or look the other "
                           "way: it is not a level of detail of that character");
    for (const std::uint32_t point : rig.mesh.source_vertex) {
        rows.points.corners.push_back(of_points.corners[point]);
        rows.points.weights.push_back(of_points.weights[point]);
    }
    allParts(rig, rows);
    return rows;
}

}  // namespace

ExportRows ownRows(const OcclusionSource& source) {
    ExportRows rows;
    resizeRows(rows, source.mesh().source_vertex.size());
    for (std::size_t r = 0; r < rows.count(); ++r) takePoint(rows, r, source.mesh().source_vertex[r]);
    return rows;
}

ExportRows matchRows(const OcclusionSource& source, const Rig& rig, ExportMesh mesh, int threads) {
    if (mesh == ExportMesh::kLevel) return matchLevel(source, rig, threads);
    const double near = kSamePlace * boxDiagonal(source.mesh().rest_positions);
    if (sameRows(source, rig, near)) {
        ExportRows rows = ownRows(source);
        allParts(rig, rows);
        return rows;
    }
    ExportRows rows;
    resizeRows(rows, rig.mesh.source_vertex.size());
    const PlaceFinder finder(source, rig, near);
    for (std::size_t p = 0; p < rig.part_colors.size(); ++p) matchPart(finder, rig, p, rows);
    if (rows.parts.empty())
        throw InvalidInput("none of its vertices rests where the source has one: it is another character");
    return rows;
}

}  // namespace penumbra
