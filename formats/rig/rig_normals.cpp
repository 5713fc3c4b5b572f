// Splits places into shading points by the normals that meet there.
//
// Problem: at a hard edge a file has one vertex for each side, at the same place. Their visibility differs as their
// hemispheres do, so one shading point for both is wrong on both sides. At a seam of texture coordinates a file has
// several vertices, too, and there one point is right.
//
// Naive: one point for each vertex of the file. Seams then cost twice and rounding makes them visible; a file without
// normals has no hard edges at all, however many vertices it has.
//
// Here: normals decide. The file's are taken where it has them and where they lie on the side that the triangles face;
// otherwise the vertex' own triangles tell. The normals of one place are joined from the nearest pair on, as
// pointsOfVertices() says (agglomerative clustering with centroid linkage). Two cases need a look at single corners:
// `--crease`, which makes edges where a file has none, and sheets of two layers that share their vertices.
#include "formats/rig/rig_normals.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "formats/rig/rig_corners.h"

namespace penumbra {

namespace {

// Normals farther apart than this are two sides of a sheet, even where the file has no normals.
constexpr double kOppositeSides = 150;
constexpr double kSameNormal = 1 - 1.52e-6;  // cosine of 0.1 degrees
constexpr double kUnitRounding = 1e-6;       // squared lengths of unit vectors of floats are this near to 1
constexpr double kCosineRounding = 1e-6;
// More different normals at one place are joined by a faster rule, so that no file takes forever.
constexpr std::size_t kMaxJoined = 24;

// Keeps the bits of a vector that has length 1 already, so that what is written comes back the same.
Vec3 unitOf(Vec3 n) {
    const Vec3d d = toDouble(n);
    return std::abs(dot(d, d) - 1) <= kUnitRounding ? n : toFloat(normalized(d));
}

bool isZero(Vec3 n) { return dot(n, n) == 0; }

// Returns the sum of the normals of each vertex' triangles, by their areas. `index` gives the row of a corner.
template <class Index>
std::vector<Vec3d> areaSums(const std::vector<Vec3>& positions, const SplitVertices& split, std::size_t rows,
                            const Index& index) {
    std::vector<Vec3d> sums(rows);
    for (const Triangle& t : split.triangles) {
        const Vec3d a = toDouble(positions[split.original[t[0]]]), b = toDouble(positions[split.original[t[1]]]),
                    c = toDouble(positions[split.original[t[2]]]);
        const Vec3d twice_area = cross(b - a, c - a);
        for (const std::uint32_t v : t) sums[index(v)] += twice_area;
    }
    return sums;
}

// A normal that the winding contradicts is turned round where that brings it to the triangles' side by at least 30
// degrees: the file has its normals inside out. Otherwise it counts as none.
constexpr double kTurnedRound = 0.5;
constexpr double kOtherLayer = -0.9;

// Chooses the normal of each vertex.
void chooseNormals(const SourceVertices& vertices, std::span<const std::uint32_t> place_of_vertex,
                   SplitVertices& split) {
    const std::size_t count = split.original.size();
    const auto place = [&](std::uint32_t v) { return place_of_vertex[split.original[v]]; };
    const std::vector<Vec3d> own = areaSums(vertices.positions, split, count, [](std::uint32_t v) { return v; });
    std::vector<Vec3d> of_place;
    if (!vertices.normals.empty()) of_place = areaSums(vertices.positions, split, place_of_vertex.size(), place);
    for (std::uint32_t v = 0; v < count; ++v) {
        const Vec3d computed = normalized(own[v]);
        Vec3 chosen = vertices.normals.empty() ? Vec3{} : vertices.normals[split.original[v]];
        // 1. Near a crumpled or smoothed place the triangles of a vertex may face away from a right normal, so the
        // whole place has a say, unless the two are opposite: those are the layers of a sheet.
        const double side = dot(toDouble(chosen), computed);
        if (side < 0 && (side < kOtherLayer || dot(toDouble(chosen), of_place[place(v)]) <= 1e-6 * length(own[v]))) {
            split.against_winding.push_back(split.original[v]);
            chosen = -side >= kTurnedRound ? -chosen : Vec3{};
        }
        // 2. What has no normal takes that of its triangles.
        split.from_file.push_back(!isZero(chosen));
        split.normals.push_back(isZero(chosen) ? toFloat(computed) : chosen);
    }
    std::sort(split.against_winding.begin(), split.against_winding.end());
    split.against_winding.erase(std::unique(split.against_winding.begin(), split.against_winding.end()),
                                split.against_winding.end());
}

}  // namespace

SplitVertices splitVertices(const SourceVertices& vertices, std::span<const std::uint32_t> place_of_vertex,
                            const RigOptions& options) {
    SplitVertices split;
    split.original.resize(vertices.positions.size());
    std::iota(split.original.begin(), split.original.end(), 0u);
    split.triangles = vertices.triangles;
    split.group.assign(split.original.size(), 0);
    splitCorners(vertices, place_of_vertex, options, split);
    chooseNormals(vertices, place_of_vertex, split);
    return split;
}

namespace {

// Vertices of one place whose normals have been joined.
struct Joined {
    Vec3d sum;                            // sum of their normals
    std::vector<std::uint32_t> vertices;  // ascending
};

double cosineOf(const Joined& a, const Joined& b) { return dot(normalized(a.sum), normalized(b.sum)); }

// Joins the nearest two, again and again, while they agree.
void joinNearest(std::vector<Joined>& parts, double least_cosine) {
    while (parts.size() > 1) {
        std::size_t first = 0, second = 0;
        double nearest = least_cosine;
        for (std::size_t i = 0; i < parts.size(); ++i)
            for (std::size_t k = i + 1; k < parts.size(); ++k)
                if (const double cosine = cosineOf(parts[i], parts[k]); cosine > nearest) {
                    nearest = cosine;
                    first = i;
                    second = k;
                }
        if (second == 0) return;
        parts[first].sum += parts[second].sum;
        std::vector<std::uint32_t>& to = parts[first].vertices;
        to.insert(to.end(), parts[second].vertices.begin(), parts[second].vertices.end());
        parts.erase(parts.begin() + std::ptrdiff_t(second));
    }
}

// The faster rule: a vertex joins the first that it agrees with.
void joinFirst(std::vector<Joined>& parts, double least_cosine) {
    std::vector<Joined> out;
    for (Joined& part : parts) {
        const auto agrees = [&](const Joined& other) { return cosineOf(part, other) > least_cosine; };
        const auto found = std::find_if(out.begin(), out.end(), agrees);
        if (found == out.end())
            out.push_back(std::move(part));
        else
            found->vertices.insert(found->vertices.end(), part.vertices.begin(), part.vertices.end());
    }
    parts = std::move(out);
}

// Returns the vertices of one place and group, joined. Equal normals are one from the start; a vertex without a normal
// goes with the first.
std::vector<Joined> joinVertices(const SplitVertices& split, std::span<const std::uint32_t> of_place,
                                 double split_angle) {
    std::vector<Joined> parts;
    std::map<std::array<float, 3>, std::size_t> part_of_normal;
    std::vector<std::uint32_t> lost;
    bool from_file = false;
    for (const std::uint32_t v : of_place) {
        const Vec3 n = split.normals[v];
        from_file = from_file || split.from_file[v];
        if (isZero(n)) {
            lost.push_back(v);
            continue;
        }
        const auto [at, fresh] = part_of_normal.try_emplace({n.x, n.y, n.z}, parts.size());
        if (fresh) parts.emplace_back();
        parts[at->second].sum += toDouble(n);
        parts[at->second].vertices.push_back(v);
    }
    const double degrees = from_file ? split_angle : kOppositeSides;
    const double least_cosine = std::cos(degrees * std::numbers::pi / 180) - kCosineRounding;
    if (parts.size() > kMaxJoined) joinFirst(parts, least_cosine);
    if (parts.size() <= kMaxJoined) joinNearest(parts, least_cosine);
    if (parts.empty()) parts.emplace_back();
    parts[0].vertices.insert(parts[0].vertices.end(), lost.begin(), lost.end());
    return parts;
}

}  // namespace

std::vector<std::uint32_t> pointsOfVertices(const SplitVertices& split, std::span<const std::uint32_t> place_of_vertex,
                                            double split_angle) {
    const std::size_t count = split.original.size();
    // 1. The vertices by place and group, in their own order.
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](std::uint32_t v) { return std::pair(place_of_vertex[split.original[v]], split.group[v]); };
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    // 2. What is joined takes the number of its first vertex.
    std::vector<std::uint32_t> first(count);
    for (std::size_t begin = 0, end = 0; begin < count; begin = end) {
        while (end < count && key(order[end]) == key(order[begin])) ++end;
        if (end == begin + 1) {
            first[order[begin]] = order[begin];
            continue;
        }
        for (const Joined& part : joinVertices(split, std::span(order).subspan(begin, end - begin), split_angle)) {
            const std::uint32_t least = *std::min_element(part.vertices.begin(), part.vertices.end());
            for (const std::uint32_t v : part.vertices) first[v] = least;
        }
    }
    // 3. Points count up.
    std::vector<std::uint32_t> point(count);
    std::uint32_t points = 0;
    for (std::uint32_t v = 0; v < count; ++v) point[v] = first[v] == v ? points++ : point[first[v]];
    return point;
}

std::vector<Vec3> restNormals(const SplitVertices& split, std::span<const std::uint32_t> point_of_vertex,
                              const Mesh& mesh) {
    std::vector<Vec3> normals = vertexNormals(mesh.triangles, mesh.rest_positions);
    // 1. The sum of the file's normals, and whether all of them are one.
    struct OfFile {
        Vec3d sum;
        Vec3 first;
        bool one = true;
    };
    std::vector<OfFile> of_file(normals.size());
    for (std::size_t v = 0; v < split.original.size(); ++v) {
        if (!split.from_file[v]) continue;
        OfFile& sums = of_file[point_of_vertex[v]];
        if (isZero(sums.first)) sums.first = split.normals[v];
        sums.one = sums.one && sums.first == split.normals[v];
        sums.sum += toDouble(split.normals[v]);
    }
    // 2. Their mean, unless the computed normal says the same.
    for (std::size_t p = 0; p < normals.size(); ++p) {
        const Vec3d mean = normalized(of_file[p].sum);
        if (mean == Vec3d{} || dot(mean, toDouble(normals[p])) >= kSameNormal) continue;
        normals[p] = of_file[p].one ? of_file[p].first : toFloat(mean);
    }
    return normals;
}

// --- What the file says
// -----------------------------------------------------------------------------------------------

namespace {

std::string countOf(std::size_t some, std::size_t all) { return std::to_string(some) + " of " + std::to_string(all); }

}  // namespace

void takeNormals(std::vector<Vec3> normals, RigSource& source, SourcePart& part) {
    std::size_t bad = 0;
    for (Vec3& n : normals) {
        const float square = dot(n, n);
        const bool good = std::isfinite(square) && square > 1e-20f;
        n = good ? unitOf(n) : Vec3{};
        if (!good) ++bad;
    }
    if (bad > 0)
        source.notes.push_back({source.file.string(), source.nodes[std::size_t(part.node)].name, "NORMAL",
                                countOf(bad, normals.size()) +
                                    " normals are zero or not finite; the triangles' normals take their place"});
    part.normals = std::move(normals);
}

void noteAgainstWinding(const SourceVertices& vertices, std::span<const std::size_t> against_winding,
                        RigSource& source) {
    for (std::size_t p = 0; p < vertices.part_colors.size(); ++p) {
        const ColoredPart& part = vertices.part_colors[p];
        const auto begin = std::lower_bound(against_winding.begin(), against_winding.end(), part.first_vertex);
        const auto end = std::lower_bound(begin, against_winding.end(), part.first_vertex + part.vertices);
        if (begin == end) continue;
        source.notes.push_back({source.file.string(), source.nodes[std::size_t(source.parts[p].node)].name, "NORMAL",
                                countOf(std::size_t(end - begin), part.vertices) +
                                    " normals point into the side that the triangles' winding calls inside; the "
                                    "winding decides"});
    }
}

}  // namespace penumbra
