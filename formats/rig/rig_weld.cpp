// Welds vertices to shading points.
//
// Problem: exporters split a vertex where its normal or texture coordinates change. Visibility does not depend on
// texture coordinates, so vertices with the same rest position, the same skin weights and nearly the same normal
// should be one shading point, which is baked once.
//
// Naive: compare every vertex with every other, which takes the square of their number; or hash their bytes, which
// misses neighbours that differ by rounding.
//
// Here: a grid of cubes finds the points near a vertex. Cubes are 64 times as large as the distance that counts as
// equal, so that a look-up visits one cube nearly always. The first place that fits takes the vertex, in the order of
// the file, so that the result depends on nothing else. Then the normals of each place tell how many points it has
// (rig_normals.h). formats/README.md describes the mesh; docs/formulas.md derives nothing here.
#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "formats/common/errors.h"
#include "formats/common/mesh_places.h"
#include "formats/rig/point_grid.h"
#include "formats/rig/rig_normals.h"

namespace penumbra {

constexpr double kWeldDistance = 1e-6;  // in diagonals of the rest mesh
constexpr double kNoArea = 1e-12;       // rounding of collinear float positions stays below this
constexpr float kWeldWeight = 1e-5f;    // largest difference of two weights that count as equal

namespace {
struct Influence {
    int joint;
    double weight;
};

// Returns the joint of the skin's root, whose node comes first in the file.
int rootJoint(const SourceSkin& skin, const std::vector<int>& joint_of_skin) {
    const auto root = std::min_element(skin.nodes.begin(), skin.nodes.end());
    return joint_of_skin.at(std::size_t(root - skin.nodes.begin()));
}

// Returns the influences of one vertex: largest first, at most kMaxInfluences, with the sum 1. A vertex without weights
// moves with the root (rig_influences.cpp tells how many do).
std::vector<Influence> influencesOf(const RigSource& source, const SourcePart& part,
                                    const std::vector<int>& joint_of_skin, std::size_t vertex) {
    const std::string where = "vertex " + std::to_string(vertex);
    std::vector<Influence> list;
    for (std::size_t k = vertex * std::size_t(part.influences); k < (vertex + 1) * std::size_t(part.influences); ++k) {
        const double weight = part.weights[k];
        if (!std::isfinite(weight) || weight < 0) failAtNode(source, part.node, where + " has an invalid skin weight");
        if (weight == 0) continue;
        if (part.joints[k] >= joint_of_skin.size())
            failAtNode(source, part.node,
                       where + " names joint " + std::to_string(part.joints[k]) + " of " +
                           std::to_string(joint_of_skin.size()));
        const int joint = joint_of_skin[part.joints[k]];
        const auto same = std::find_if(list.begin(), list.end(), [&](Influence i) { return i.joint == joint; });
        if (same == list.end())
            list.push_back({joint, weight});
        else
            same->weight += weight;
    }
    std::sort(list.begin(), list.end(),
              [](Influence a, Influence b) { return a.weight != b.weight ? a.weight > b.weight : a.joint < b.joint; });
    if (list.size() > kMaxInfluences) list.resize(kMaxInfluences);
    double sum = 0;
    for (const Influence& i : list) sum += i.weight;
    if (!std::isfinite(sum)) failAtNode(source, part.node, where + " has an invalid skin weight");
    if (!(sum > kNoWeight)) return {{rootJoint(source.skins[std::size_t(part.skin)], joint_of_skin), 1.0}};
    for (Influence& i : list) i.weight /= sum;
    std::erase_if(list, [](Influence i) { return float(i.weight) == 0; });
    return list;
}

// Tells which joints mirror at rest. Triangles must keep their outside: where positions are mirrored (negative
// determinant of skinning matrix x placement), winding is turned too.
std::vector<bool> mirroringJoints(const RigSource& source, const JointTable& table) {
    const std::vector<Matrix> globals = restGlobals(source.nodes);
    std::vector<bool> mirrors;
    for (std::size_t j = 0; j < table.nodes.size(); ++j)
        mirrors.push_back(determinant(multiply(globals[std::size_t(table.nodes[j])], table.inverse_bind[j])) < 0);
    return mirrors;
}

Vec3 placedPosition(const RigSource& source, const SourcePart& part, const Matrix& placement, std::size_t v) {
    const Vec3 p = toFloat(transformPoint(placement, toDouble(part.positions[v])));
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
        failAtNode(source, part.node, "vertex " + std::to_string(v) + " is not at a finite place");
    return p;
}

// The influences of all vertices, row after row. A list for each vertex would take four times as much.
class InfluenceRows {
public:
    struct Stored {
        int joint;
        float weight;
    };
    void push_back(const std::vector<Influence>& list) {
        for (const Influence& i : list) all_.push_back({i.joint, float(i.weight)});
        end_.push_back(all_.size());
    }
    std::size_t size() const { return end_.size(); }
    std::span<const Stored> operator[](std::size_t v) const {
        const std::size_t begin = v > 0 ? end_[v - 1] : 0;
        return std::span(all_).subspan(begin, end_[v] - begin);
    }

private:
    std::vector<Stored> all_;
    std::vector<std::size_t> end_;
};

// Brings the normals of a part, which has some, to the space of the rest positions: by the inverse transpose of its
// placement (the cofactor, without its length), and with the side that stays outside, as the winding below.
void placeNormals(const SourcePart& part, const Matrix& placement, const std::vector<bool>& turned,
                  std::vector<Vec3>& normals) {
    const Vec3d x{placement[0], placement[1], placement[2]}, y{placement[4], placement[5], placement[6]},
        z{placement[8], placement[9], placement[10]};
    const bool same = x == Vec3d{1, 0, 0} && y == Vec3d{0, 1, 0} && z == Vec3d{0, 0, 1};
    for (std::size_t v = 0; v < part.normals.size(); ++v) {
        const Vec3d n = toDouble(part.normals[v]);
        const Vec3 placed =
            same ? part.normals[v]
                 : toFloat(normalized(Vec3d{dot(cross(y, z), n), dot(cross(z, x), n), dot(cross(x, y), n)}));
        normals.push_back(turned[v] ? -placed : placed);
    }
}

// Packs rows of K influences, padded with joint 0 of weight 0.
void packInfluences(const InfluenceRows& influences, SourceVertices& out) {
    for (std::size_t v = 0; v < influences.size(); ++v)
        out.influences = std::max(out.influences, int(influences[v].size()));
    const std::size_t k = std::size_t(out.influences);
    out.joints.assign(influences.size() * k, 0);
    out.weights.assign(influences.size() * k, 0);
    for (std::size_t v = 0; v < influences.size(); ++v)
        for (std::size_t i = 0; i < influences[v].size(); ++i) {
            out.joints[v * k + i] = std::uint16_t(influences[v][i].joint);
            out.weights[v * k + i] = influences[v][i].weight;
        }
}

}  // namespace

namespace {

// Returns the name of a node that draws something: "arm#2" for the second of this name.
std::string partNodeName(const RigSource& source, int node) {
    const std::string& name = source.nodes[std::size_t(node)].name;
    int turn = 1;
    for (int n = 0; n < node; ++n)
        if (source.nodes[std::size_t(n)].name == name)
            turn += std::any_of(source.parts.begin(), source.parts.end(),
                                [&](const SourcePart& part) { return part.node == n; });
    return turn == 1 ? name : name + "#" + std::to_string(turn);
}

}  // namespace

std::uint16_t slotOf(const RigSource& source, const SourcePart& part, std::vector<std::string>& slots) {
    const std::string name = partNodeName(source, part.node) + "/" + part.material;
    const auto found = std::find(slots.begin(), slots.end(), name);
    if (found != slots.end()) return std::uint16_t(found - slots.begin());
    if (slots.size() == 65535) throw Unsupported(source.file.string() + ": more than 65535 parts");
    slots.push_back(name);
    return std::uint16_t(slots.size() - 1);
}

SourceVertices gatherVertices(const RigSource& source, const JointTable& table) {
    const std::vector<bool> mirrors = mirroringJoints(source, table);
    SourceVertices out;
    InfluenceRows influences;
    out.morphs = planMorphs(source);
    for (std::size_t p = 0; p < source.parts.size(); ++p) {
        const SourcePart& part = source.parts[p];
        const std::uint32_t first = std::uint32_t(out.positions.size());
        const std::uint16_t slot = slotOf(source, part, out.slots);
        out.slot_of_vertex.resize(out.positions.size() + part.positions.size(), slot);
        out.part_colors.push_back({part.color, slot, first, part.positions.size(), part.triangles, part.gltf,
                                   multiply(table.placement_of_part[p], part.instance), part.look});
        for (std::size_t v = 0; v < part.positions.size(); ++v) {
            out.positions.push_back(placedPosition(source, part, table.placement_of_part[p], v));
            influences.push_back(part.skin < 0
                                     ? std::vector<Influence>{{table.joint_of_part[p], 1.0}}
                                     : influencesOf(source, part, table.joint_of_skin[std::size_t(part.skin)], v));
        }
        const bool mirrored_part = determinant(table.placement_of_part[p]) < 0;
        std::vector<bool> turned;
        for (std::size_t v = first; v < influences.size(); ++v)
            turned.push_back(mirrors[std::size_t(influences[v][0].joint)] != mirrored_part);
        for (const Triangle& t : part.triangles) {
            const bool mirrored = turned[t[0]];
            out.triangles.push_back({first + t[0], first + t[mirrored ? 2 : 1], first + t[mirrored ? 1 : 2]});
        }
        appendMorphs(part, table.placement_of_part[p], out.morphs);
        if (part.normals.empty()) continue;
        out.normals.resize(first);
        placeNormals(part, table.placement_of_part[p], turned, out.normals);
    }
    if (!out.normals.empty()) out.normals.resize(out.positions.size());
    packInfluences(influences, out);
    return out;
}

namespace {

float weightOf(const SourceVertices& vertices, std::size_t v, std::uint16_t joint) {
    const std::size_t first = v * std::size_t(vertices.influences);
    for (std::size_t k = first; k < first + std::size_t(vertices.influences); ++k)
        if (vertices.joints[k] == joint && vertices.weights[k] > 0) return vertices.weights[k];
    return 0;
}

// Compares weights both ways, since either vertex may have a joint that the other lacks.
bool sameWeights(const SourceVertices& vertices, std::size_t a, std::size_t b) {
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)}) {
        const std::size_t first = from * std::size_t(vertices.influences);
        for (std::size_t k = first; k < first + std::size_t(vertices.influences); ++k) {
            const float weight = vertices.weights[k];
            if (weight > 0 && std::abs(weight - weightOf(vertices, to, vertices.joints[k])) > kWeldWeight) return false;
        }
    }
    return true;
}

}  // namespace

bool hasArea(const std::vector<Vec3>& positions, const Triangle& t) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return false;
    const Vec3d a = toDouble(positions[t[0]]), b = toDouble(positions[t[1]]), c = toDouble(positions[t[2]]);
    const double longest = std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)});
    return length(cross(b - a, c - a)) > kNoArea * longest;
}

namespace {

// Returns for each vertex the number of its place: the first one that is near and has the same weights, or a new one.
std::vector<std::uint32_t> placesOfVertices(const SourceVertices& vertices) {
    const double radius = kWeldDistance * characterDiagonal(vertices.triangles, vertices.positions);
    PointGrid grid(radius, 64 * radius);
    std::vector<std::size_t> first_of_place;
    std::vector<std::uint32_t> place_of_vertex;
    for (std::size_t v = 0; v < vertices.positions.size(); ++v) {
        const Vec3d p = toDouble(vertices.positions[v]);
        std::uint32_t place = grid.find(p, [&](std::uint32_t other) {
            const Vec3d d = toDouble(vertices.positions[first_of_place[other]]) - p;
            return dot(d, d) <= radius * radius && sameWeights(vertices, v, first_of_place[other]) &&
                   sameMorphs(vertices.morphs, v, first_of_place[other], radius);
        });
        if (place == PointGrid::kNone) {
            place = std::uint32_t(first_of_place.size());
            first_of_place.push_back(v);
            grid.add(p, place);
        }
        place_of_vertex.push_back(place);
    }
    return place_of_vertex;
}

// Appends a shading point: the row of its slot from its own vertex, all else from the first vertex of its place.
void appendPoint(const SourceVertices& vertices, std::size_t vertex, std::size_t first_of_place, Mesh& mesh,
                 Skin& skin) {
    const std::size_t k = std::size_t(vertices.influences);
    if (!vertices.slots.empty()) mesh.slot_of_vertex.push_back(vertices.slot_of_vertex[vertex]);
    mesh.rest_positions.push_back(vertices.positions[first_of_place]);
    for (std::size_t i = first_of_place * k; i < (first_of_place + 1) * k; ++i) {
        skin.joints.push_back(vertices.joints[i]);
        skin.weights.push_back(vertices.weights[i]);
    }
}

// The result of welding for the vertices of a SplitVertices. The surface is smooth over vertices with the same `joint`.
// These vertices share one `point` for each slot.
struct PointIndices {
    std::vector<std::uint32_t> joint, point;  // [N]
    std::vector<bool> used;                   // [N] by a triangle; without triangles all are
};

// Parts the points of joined vertices by their slots.
PointIndices numberPoints(const SourceVertices& vertices, const SplitVertices& split,
                          std::vector<std::uint32_t> joint) {
    PointIndices out{std::move(joint), {}, std::vector<bool>(split.original.size(), split.triangles.empty())};
    // Nearly all joints have one slot. A tree of all would take much memory.
    std::vector<std::uint32_t> first_point(out.joint.size(), PointGrid::kNone);
    std::vector<std::uint16_t> first_slot(out.joint.size());
    std::map<std::pair<std::uint32_t, std::uint16_t>, std::uint32_t> others;
    std::uint32_t count = 0;
    for (std::size_t v = 0; v < out.joint.size(); ++v) {
        const std::uint32_t of = out.joint[v];
        const std::uint16_t slot =
            vertices.slots.empty() ? std::uint16_t(0) : vertices.slot_of_vertex[split.original[v]];
        std::uint32_t& first = first_point[of];
        if (first == PointGrid::kNone) {
            first = count++;
            first_slot[of] = slot;
        }
        if (first_slot[of] == slot) {
            out.point.push_back(first);
            continue;
        }
        const auto [found, is_new] = others.try_emplace({of, slot}, count);
        if (is_new) ++count;
        out.point.push_back(found->second);
    }
    for (const Triangle& t : split.triangles)
        for (const std::uint32_t corner : t) out.used[corner] = true;
    return out;
}

// Leaves out the points that no triangle uses: exporters leave vertices behind, and primitives that share a pool of
// vertices have those of the others. Such a vertex gets the first point that it is joined with, or else the first of
// its place, or else that of the vertex before it. Without triangles every point stays.
void dropUnused(const SplitVertices& split, std::span<const std::uint32_t> place_of_vertex, PointIndices& numbers) {
    const std::size_t vertices = numbers.point.size();
    std::vector<std::uint32_t> new_point(vertices, PointGrid::kNone), of_joint = new_point, at_place = new_point;
    std::uint32_t count = 0, last = 0;
    for (std::size_t v = 0; v < vertices; ++v) {
        if (!numbers.used[v]) continue;
        std::uint32_t& point = new_point[numbers.point[v]];
        if (point == PointGrid::kNone) point = count++;
        for (std::uint32_t* first : {&of_joint[numbers.joint[v]], &at_place[place_of_vertex[split.original[v]]]})
            if (*first == PointGrid::kNone) *first = point;
    }
    for (std::size_t v = 0; v < vertices; ++v) {
        std::uint32_t point = new_point[numbers.point[v]];
        if (point == PointGrid::kNone) point = of_joint[numbers.joint[v]];
        if (point == PointGrid::kNone) point = at_place[place_of_vertex[split.original[v]]];
        last = numbers.point[v] = point == PointGrid::kNone ? last : point;
    }
}

// Returns the rest normals [V]: points that differ in their slot alone have one.
std::vector<Vec3> smoothNormals(SplitVertices split, const PointIndices& numbers, const Mesh& mesh) {
    std::vector<std::uint32_t> of_joint(numbers.joint.size(), PointGrid::kNone), first(mesh.vertexCount());
    for (std::size_t v = 0; v < numbers.joint.size(); ++v) {
        if (!numbers.used[v]) continue;
        std::uint32_t& point = of_joint[numbers.joint[v]];
        if (point == PointGrid::kNone) point = numbers.point[v];
        first[numbers.point[v]] = point;
    }
    // A vertex that no triangle uses has no say in the normal of the point that it was given.
    for (std::size_t v = 0; v < numbers.used.size(); ++v) split.from_file[v] = split.from_file[v] && numbers.used[v];
    bool one_slot = true;
    for (std::uint32_t p = 0; p < first.size(); ++p) one_slot = one_slot && first[p] == p;
    if (one_slot) return restNormals(split, numbers.point, mesh);
    Mesh joined;
    joined.rest_positions = mesh.rest_positions;
    joined.triangles = trianglesOfPlaces(mesh.triangles, first);
    std::vector<std::uint32_t> point_of_vertex;
    for (const std::uint32_t point : numbers.point) point_of_vertex.push_back(first[point]);
    std::vector<Vec3> normals = restNormals(split, point_of_vertex, joined);
    for (std::size_t p = 0; p < normals.size(); ++p) normals[p] = normals[first[p]];
    return normals;
}

// Frees what the points have copies of, which in a scan is as much as the points.
void release(SourceVertices& vertices) {
    giveBack(vertices.positions);
    giveBack(vertices.normals);
    giveBack(vertices.joints);
    giveBack(vertices.weights);
    giveBack(vertices.triangles);
}

}  // namespace

WeldedPoints weldVertices(SourceVertices& vertices, const RigOptions& options, Mesh& mesh, Skin& skin) {
    mesh = {};
    mesh.slots = vertices.slots;
    skin.influences = vertices.influences;
    // 1. Places, and the points of each.
    const std::vector<std::uint32_t> place_of_vertex = placesOfVertices(vertices);
    std::vector<std::size_t> first_of_place;
    for (std::size_t v = 0; v < place_of_vertex.size(); ++v)
        if (place_of_vertex[v] == first_of_place.size()) first_of_place.push_back(v);
    SplitVertices split = splitVertices(vertices, place_of_vertex, options);
    PointIndices numbers = numberPoints(vertices, split, pointsOfVertices(split, place_of_vertex, options.split_angle));
    dropUnused(split, place_of_vertex, numbers);
    const std::vector<std::uint32_t>& points = numbers.point;
    WeldedPoints out;
    for (std::size_t v = 0; v < points.size(); ++v) {
        if (!numbers.used[v] || points[v] != mesh.vertexCount()) continue;
        out.vertex_of_point.push_back(split.original[v]);
        out.first_of_place.push_back(first_of_place[place_of_vertex[split.original[v]]]);
        appendPoint(vertices, out.vertex_of_point.back(), out.first_of_place.back(), mesh, skin);
    }
    mesh.source_vertex.assign(points.begin(), points.begin() + std::ptrdiff_t(vertices.positions.size()));
    release(vertices);
    // 2. Triangles follow their corners. Those that welding has made a line are dropped.
    for (const Triangle& t : split.triangles) {
        const Triangle welded{points[t[0]], points[t[1]], points[t[2]]};
        if (!hasArea(mesh.rest_positions, welded)) continue;
        mesh.triangles.push_back(welded);
        out.source_corners.push_back({split.original[t[0]], split.original[t[1]], split.original[t[2]]});
    }
    giveBack(split.triangles);
    out.rest_normals = smoothNormals(split, numbers, mesh);
    out.against_winding = std::move(split.against_winding);
    return out;
}

}  // namespace penumbra
