// Tells the two sides of thin surfaces apart.
//
// Problem: a surface without thickness has two sides that see different things. Files make the second side in three
// ways: a second layer of triangles that face the other way, at the same place or with the same vertices; or a
// material that is drawn on both sides.
//
// Naive: giving every triangle of a double-sided material a back doubles most characters, since exporters set the flag
// everywhere.
//
// Here: layers of the file have points of their own, since their normals are opposite (rig_normals.h). Double-sided
// surfaces get backs unless their inside is hidden: by reciprocity a point of a cavity sees on average the share (area
// of the holes) / (area of the surface) of the outside, and below kHidden nothing of it can be told from black. The
// area of a hole is that of the vector area of its rim, 1/2 sum of p x q over the rim's edges, which is 0 for cracks
// between vertices that are not welded.
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <unordered_map>

#include "formats/common/disjoint_sets.h"
#include "formats/common/twin_triangles.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {

constexpr double kHidden = 0.02;  // share of a surface's area: smaller holes show nothing of its inside

// Numbers of places: points with the same coordinates have one number.
std::vector<std::uint32_t> placesOfPoints(const std::vector<Vec3>& positions) {
    std::map<std::array<float, 3>, std::uint32_t> number;
    std::vector<std::uint32_t> places;
    for (const Vec3 p : positions)
        places.push_back(
            number.try_emplace({p.x + 0.0f, p.y + 0.0f, p.z + 0.0f}, std::uint32_t(number.size())).first->second);
    return places;
}

Vec3d doubleArea(const std::vector<Vec3>& positions, const Triangle& t) {
    const Vec3d a = toDouble(positions[t[0]]);
    return cross(toDouble(positions[t[1]]) - a, toDouble(positions[t[2]]) - a);
}

// Returns the double-sided triangles of a rig, by the part that their vertices are of.
std::vector<bool> doubleSidedTriangles(const Rig& rig) {
    std::vector<bool> out;
    for (const Triangle& corners : rig.source_corners) {
        const auto behind =
            std::upper_bound(rig.part_colors.begin(), rig.part_colors.end(), std::size_t(corners[0]),
                             [](std::size_t v, const ColoredPart& part) { return v < part.first_vertex; });
        out.push_back(behind != rig.part_colors.begin() && std::prev(behind)->color.material.double_sided);
    }
    return out;
}

// A connected surface: its area, and the holes in it.
struct Surface {
    double double_area = 0, double_holes = 0;
    bool hidden() const { return double_holes < kHidden * double_area; }
};

// The sum of a rim's points, weighted by length.
struct RimMiddle {
    Vec3d sum;
    double length = 1e-300;
};

// Returns the surface of each place, by the name of the group that the place is in.
std::map<std::uint32_t, Surface> surfacesOf(const Mesh& mesh, const std::vector<std::uint32_t>& places,
                                            DisjointSets& groups) {
    std::map<std::array<std::uint32_t, 2>, int> uses;
    std::map<std::uint32_t, Surface> surfaces;
    const auto eachEdge = [&](const auto& visit) {
        for (const Triangle& t : mesh.triangles)
            for (std::size_t k = 0; k < 3; ++k) visit(t[k], t[(k + 1) % 3]);
    };
    const auto key = [&](std::uint32_t a, std::uint32_t b) {
        return std::array<std::uint32_t, 2>{std::min(places[a], places[b]), std::max(places[a], places[b])};
    };
    eachEdge([&](std::uint32_t a, std::uint32_t b) { groups.join(places[a], places[b]), ++uses[key(a, b)]; });
    for (const Triangle& t : mesh.triangles)
        surfaces[groups.of(places[t[0]])].double_area += length(doubleArea(mesh.rest_positions, t));
    // The edges of one triangle alone are rims. Those that hang together are the rim of one hole.
    DisjointSets rims(mesh.vertexCount());
    eachEdge([&](std::uint32_t a, std::uint32_t b) {
        if (uses[key(a, b)] == 1) rims.join(places[a], places[b]);
    });
    // A hole is as large as the fan from the middle of its rim. The area of the vector of a rim would not do: the two
    // ends of a slit tube have one rim, and their vectors cancel.
    std::map<std::uint32_t, RimMiddle> middles;
    const auto eachRimEdge = [&](const auto& visit) {
        eachEdge([&](std::uint32_t a, std::uint32_t b) {
            if (uses[key(a, b)] == 1)
                visit(rims.of(places[a]), toDouble(mesh.rest_positions[a]), toDouble(mesh.rest_positions[b]));
        });
    };
    eachRimEdge([&](std::uint32_t rim, Vec3d a, Vec3d b) {
        const double span = length(b - a);
        middles[rim].sum += (a + b) * (0.5 * span);
        middles[rim].length += span;
    });
    eachRimEdge([&](std::uint32_t rim, Vec3d a, Vec3d b) {
        const Vec3d middle = middles[rim].sum * (1 / middles[rim].length);
        surfaces[groups.of(rim)].double_holes += length(cross(a - middle, b - middle));
    });
    return surfaces;
}

// Appends the back of a point and returns its number.
std::uint32_t appendBackOf(std::uint32_t point, Rig& rig) {
    Mesh& mesh = rig.mesh;
    const std::size_t k = std::size_t(rig.skin.influences);
    mesh.rest_positions.push_back(mesh.rest_positions[point]);
    if (!mesh.slot_of_vertex.empty()) mesh.slot_of_vertex.push_back(mesh.slot_of_vertex[point]);
    for (std::size_t i = point * k; i < (point + 1) * k; ++i) {
        rig.skin.joints.push_back(rig.skin.joints[i]);
        rig.skin.weights.push_back(rig.skin.weights[i]);
    }
    rig.rest_normals.push_back(-rig.rest_normals[point]);
    return std::uint32_t(mesh.vertexCount() - 1);
}

}  // namespace

void addBacks(Rig& rig) {
    const std::vector<bool> double_sided = doubleSidedTriangles(rig);
    if (std::find(double_sided.begin(), double_sided.end(), true) == double_sided.end()) return;
    const std::vector<std::uint32_t> places = placesOfPoints(rig.mesh.rest_positions);
    const std::vector<std::uint32_t> twins = twinTriangles(rig.mesh, rig.skin);
    DisjointSets groups(places.size());
    const std::map<std::uint32_t, Surface> surfaces = surfacesOf(rig.mesh, places, groups);
    const std::size_t fronts = rig.mesh.vertexCount();
    std::vector<std::uint32_t> front_of_point(fronts);
    std::iota(front_of_point.begin(), front_of_point.end(), 0u);
    std::unordered_map<std::uint32_t, std::uint32_t> back_of_point;
    const auto backOf = [&](std::uint32_t point) {
        const auto [back, is_new] = back_of_point.try_emplace(point, 0);
        if (is_new) back->second = appendBackOf(point, rig);
        if (is_new) front_of_point.push_back(point);
        return back->second;
    };
    for (std::size_t t = 0; t < double_sided.size(); ++t) {
        const Triangle corner = rig.mesh.triangles[t], source = rig.source_corners[t];
        if (!double_sided[t] || (!twins.empty() && twins[t] != t)) continue;
        if (surfaces.at(groups.of(places[corner[0]])).hidden()) continue;
        const std::uint32_t a = backOf(corner[0]), b = backOf(corner[1]), c = backOf(corner[2]);
        rig.mesh.triangles.push_back({a, c, b});
        rig.source_corners.push_back({source[0], source[2], source[1]});
    }
    // Backs move with their fronts.
    if (front_of_point.size() == fronts || rig.mesh.morphs.empty()) return;
    MorphTargets& morphs = rig.mesh.morphs;
    morphs = selectVertices(morphs, front_of_point);
    for (std::size_t r = 0; r < morphs.vertices.size(); ++r)
        if (morphs.vertices[r] >= fronts) morphs.normals[r] = -morphs.normals[r];
}

}  // namespace penumbra
