// Splits vertices where their own corners do not belong together.
//
// Problem: a vertex may stand for several sides of the surface. A file without normals uses one vertex on both sides
// of a sharp edge, and some files use one for both layers of a sheet, whose triangles are the same ones turned round.
//
// Naive: compare the triangle of each corner with a mean normal. Where a ridge bends slowly, corners then change sides
// from place to place, and the edge frays.
//
// Here: edges decide. Two corners of a place belong together where they share an edge, run through it in opposite
// directions and turn by no more than the angle; what is connected in this way is a group (the smoothing groups of
// modelling programs).
#include "formats/rig/rig_corners.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

namespace penumbra {

namespace {

constexpr double kBetweenLayers = 150;    // degrees: corners that turn by more lie on two layers
constexpr std::size_t kMaxPartners = 64;  // partners of a corner at one edge, so that no file takes forever

// One corner of a triangle.
struct Corner {
    std::uint32_t place, triangle, at;
};

Triangle placesOf(const Triangle& t, std::span<const std::uint32_t> place_of_vertex) {
    return {place_of_vertex[t[0]], place_of_vertex[t[1]], place_of_vertex[t[2]]};
}

// Marks the places of triangles that stand in the file both ways round.
std::vector<bool> placesOfLayers(const std::vector<Triangle>& triangles,
                                 std::span<const std::uint32_t> place_of_vertex) {
    struct Turned {
        Triangle places;  // ascending
        bool odd;         // whether sorting them turned the triangle round
        auto operator<=>(const Turned&) const = default;
    };
    std::vector<Turned> all;
    all.reserve(triangles.size());
    for (const Triangle& t : triangles) {
        Triangle p = placesOf(t, place_of_vertex);
        bool odd = false;
        for (const auto& [i, k] : {std::pair(0, 1), std::pair(1, 2), std::pair(0, 1)})
            if (p[std::size_t(i)] > p[std::size_t(k)]) {
                std::swap(p[std::size_t(i)], p[std::size_t(k)]);
                odd = !odd;
            }
        if (p[0] != p[1] && p[1] != p[2]) all.push_back({p, odd});
    }
    std::sort(all.begin(), all.end());
    std::vector<bool> marked(place_of_vertex.size());
    for (std::size_t i = 1; i < all.size(); ++i)
        if (all[i].places == all[i - 1].places && all[i].odd != all[i - 1].odd)
            for (const std::uint32_t place : all[i].places) marked[place] = true;
    return marked;
}

std::vector<Vec3d> normalsOf(const std::vector<Triangle>& triangles, const std::vector<Vec3>& positions) {
    std::vector<Vec3d> normals;
    for (const Triangle& t : triangles) {
        const Vec3d a = toDouble(positions[t[0]]), b = toDouble(positions[t[1]]), c = toDouble(positions[t[2]]);
        normals.push_back(normalized(cross(b - a, c - a)));
    }
    return normals;
}

// Inputs that all places share.
struct CornerJob {
    const SourceVertices& vertices;
    std::span<const std::uint32_t> place_of_vertex;
    const std::vector<Vec3d>& normals;  // normals of the triangles
    double least_cosine;
};

// Returns the group of each corner of one place, numbered by their first corner.
std::vector<std::uint32_t> groupsOf(const CornerJob& job, std::span<const Corner> corners) {
    std::vector<std::uint32_t> parent(corners.size());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](std::uint32_t c) {
        while (parent[c] != c) c = parent[c] = parent[parent[c]];
        return c;
    };
    // 1. The edges of the place: to whom they lead, whether the corner leaves by them, and the corner.
    std::vector<std::array<std::uint32_t, 3>> edges;
    for (std::uint32_t c = 0; c < corners.size(); ++c) {
        const Triangle& t = job.vertices.triangles[corners[c].triangle];
        edges.push_back({job.place_of_vertex[t[(corners[c].at + 1) % 3]], 0, c});
        edges.push_back({job.place_of_vertex[t[(corners[c].at + 2) % 3]], 1, c});
    }
    std::sort(edges.begin(), edges.end());
    // 2. Join what leaves with what arrives.
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        while (end < edges.size() && edges[end][0] == edges[begin][0]) ++end;
        const auto arriving = std::find_if(edges.begin() + std::ptrdiff_t(begin), edges.begin() + std::ptrdiff_t(end),
                                           [](const auto& e) { return e[1] == 1; });
        const std::size_t middle = std::size_t(arriving - edges.begin());
        for (std::size_t i = begin; i < middle; ++i)
            for (std::size_t k = middle; k < std::min(end, middle + kMaxPartners); ++k)
                if (dot(job.normals[corners[edges[i][2]].triangle], job.normals[corners[edges[k][2]].triangle]) >=
                    job.least_cosine) {
                    const std::uint32_t a = root(edges[i][2]), b = root(edges[k][2]);
                    parent[std::max(a, b)] = std::min(a, b);
                }
    }
    for (std::uint32_t c = 0; c < corners.size(); ++c) parent[c] = root(c);
    return parent;
}

// Gives each further group of a vertex a vertex of its own.
void splitPlace(std::span<const Corner> corners, std::span<const std::uint32_t> groups, bool keeps_groups,
                SplitVertices& split) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> vertex_of;  // file's vertex and group to ours
    std::set<std::uint32_t> seen;
    for (std::size_t c = 0; c < corners.size(); ++c) {
        std::uint32_t& corner = split.triangles[corners[c].triangle][corners[c].at];
        const auto [at, fresh] = vertex_of.try_emplace({corner, groups[c]}, corner);
        if (fresh) {
            if (!seen.insert(corner).second) {
                at->second = std::uint32_t(split.original.size());
                split.original.push_back(corner);
                split.group.push_back(0);
            }
            if (keeps_groups) split.group[at->second] = groups[c];
        }
        corner = at->second;
    }
}

}  // namespace

void splitCorners(const SourceVertices& vertices, std::span<const std::uint32_t> place_of_vertex,
                  const RigOptions& options, SplitVertices& split) {
    // 1. Which places to look at, and which of these have edges by angle.
    std::vector<bool> wanted = placesOfLayers(vertices.triangles, place_of_vertex), creased(wanted.size());
    if (options.crease)
        for (std::size_t v = 0; v < place_of_vertex.size(); ++v) creased[place_of_vertex[v]] = true;
    if (options.crease && !vertices.normals.empty())
        for (std::size_t v = 0; v < place_of_vertex.size(); ++v)
            if (dot(vertices.normals[v], vertices.normals[v]) > 0) creased[place_of_vertex[v]] = false;
    std::vector<Corner> corners;
    for (std::uint32_t t = 0; t < vertices.triangles.size(); ++t)
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t place = place_of_vertex[vertices.triangles[t][k]];
            if (wanted[place] || creased[place]) corners.push_back({place, t, k});
        }
    if (corners.empty()) return;
    std::stable_sort(corners.begin(), corners.end(),
                     [](const Corner& a, const Corner& b) { return a.place < b.place; });
    // 2. Each of them.
    const std::vector<Vec3d> normals = normalsOf(vertices.triangles, vertices.positions);
    for (std::size_t begin = 0, end = 0; begin < corners.size(); begin = end) {
        while (end < corners.size() && corners[end].place == corners[begin].place) ++end;
        const std::span<const Corner> here(corners.data() + begin, end - begin);
        const bool by_angle = creased[here[0].place];
        const double degrees = by_angle ? std::min(*options.crease, kBetweenLayers) : kBetweenLayers;
        const CornerJob job{vertices, place_of_vertex, normals, std::cos(degrees * std::numbers::pi / 180) - 1e-6};
        splitPlace(here, groupsOf(job, here), by_angle, split);
    }
}

}  // namespace penumbra
