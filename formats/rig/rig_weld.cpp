// Welds vertices to shading points.
//
// Problem: exporters split a vertex where its normal or texture coordinates change. Visibility does not depend on
// these, so vertices with the same rest position and the same skin weights should be one shading point, which is
// baked once.
//
// Naive: compare every vertex with every other, which takes the square of their number; or hash their bytes, which
// misses neighbours that differ by rounding.
//
// Here: a grid of cubes finds the points near a vertex. Cubes are 64 times as large as the distance that counts as
// equal, so that a look-up visits one cube nearly always. The first point that fits takes the vertex, in the order of
// the file, so that the result depends on nothing else. formats/README.md describes the mesh; docs/formulas.md
// derives nothing here.
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <unordered_map>

#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

constexpr int kMaxInfluences = 8;
constexpr double kWeldDistance = 1e-6;  // in diagonals of the rest mesh
constexpr double kNoArea = 1e-12;       // rounding of collinear float positions stays below this
constexpr float kWeldWeight = 1e-5f;    // largest difference of two weights that count as equal

namespace {
struct Influence {
    int joint;
    double weight;
};

// Returns the influences of one vertex: largest first, at most kMaxInfluences, with the sum 1.
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
    if (!(sum > 1e-6) || !std::isfinite(sum)) failAtNode(source, part.node, where + " has no skin weight");
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

std::uint16_t slotOf(const RigSource& source, const SourcePart& part, std::vector<std::string>& slots) {
    const std::string name = source.nodes[std::size_t(part.node)].name + "/" + part.material;
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
    for (std::size_t p = 0; p < source.parts.size(); ++p) {
        const SourcePart& part = source.parts[p];
        const std::uint32_t first = std::uint32_t(out.positions.size());
        const std::uint16_t slot = slotOf(source, part, out.slots);
        out.slot_of_vertex.resize(out.positions.size() + part.positions.size(), slot);
        out.part_colors.push_back({part.color, slot, first, part.positions.size(), part.triangles});
        for (std::size_t v = 0; v < part.positions.size(); ++v) {
            out.positions.push_back(placedPosition(source, part, table.placement_of_part[p], v));
            influences.push_back(part.skin < 0
                                     ? std::vector<Influence>{{table.joint_of_part[p], 1.0}}
                                     : influencesOf(source, part, table.joint_of_skin[std::size_t(part.skin)], v));
        }
        const bool mirrored_part = determinant(table.placement_of_part[p]) < 0;
        for (const Triangle& t : part.triangles) {
            const bool mirrored = mirrors[std::size_t(influences[first + t[0]][0].joint)] != mirrored_part;
            out.triangles.push_back({first + t[0], first + t[mirrored ? 2 : 1], first + t[mirrored ? 1 : 2]});
        }
    }
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

// Holds points in cubes of side `cell`. A look-up visits the cubes that the ball around a point reaches, which mostly
// is one.
class PointGrid {
public:
    PointGrid(double radius, double cell) : radius_(radius), cell_(cell) {}

    // Points are numbered from 0 and come in order.
    void add(Vec3d p, std::uint32_t point) {
        std::uint32_t& last = last_of_cell_.try_emplace(keyOf(p), kNone).first->second;
        before_.push_back(last);
        last = point;
    }

    template <class Accept>  // the first added point that `accept` takes, or none
    std::uint32_t find(Vec3d p, const Accept& accept) const {
        std::uint32_t best = kNone;
        const Vec3d reach{radius_, radius_, radius_};
        const Key low = keyOf(p - reach), high = keyOf(p + reach);
        for (auto x = low[0]; x <= high[0]; ++x)
            for (auto y = low[1]; y <= high[1]; ++y)
                for (auto z = low[2]; z <= high[2]; ++z) {
                    const auto cell = last_of_cell_.find({x, y, z});
                    if (cell == last_of_cell_.end()) continue;
                    for (std::uint32_t point = cell->second; point != kNone; point = before_[point])
                        if (point < best && accept(point)) best = point;
                }
        return best;
    }

    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

private:
    using Key = std::array<std::int64_t, 3>;
    struct Hash {
        std::size_t operator()(const Key& k) const {
            return std::size_t(k[0]) * 73856093u ^ std::size_t(k[1]) * 19349663u ^ std::size_t(k[2]) * 83492791u;
        }
    };
    Key keyOf(Vec3d p) const {
        const auto index = [&](double v) { return std::int64_t(std::floor(v / cell_)); };
        return {index(p.x), index(p.y), index(p.z)};
    }

    double radius_, cell_;
    std::unordered_map<Key, std::uint32_t, Hash> last_of_cell_;
    std::vector<std::uint32_t> before_;  // [points] the point before it in its cube, or kNone
};
}  // namespace

bool hasArea(const std::vector<Vec3>& positions, const Triangle& t) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return false;
    const Vec3d a = toDouble(positions[t[0]]), b = toDouble(positions[t[1]]), c = toDouble(positions[t[2]]);
    const double longest = std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)});
    return length(cross(b - a, c - a)) > kNoArea * longest;
}

void weldVertices(const SourceVertices& vertices, Mesh& mesh, Skin& skin) {
    const double radius = kWeldDistance * boxDiagonal(vertices.positions);
    PointGrid grid(radius, 64 * radius);
    const std::size_t k = std::size_t(vertices.influences);
    std::vector<std::size_t> source_of_point;
    mesh = {};
    mesh.slots = vertices.slots;
    skin.influences = vertices.influences;
    // 1. Each vertex joins the first shading point that is near and has the same weights, or becomes a new one.
    for (std::size_t v = 0; v < vertices.positions.size(); ++v) {
        const Vec3d p = toDouble(vertices.positions[v]);
        std::uint32_t point = grid.find(p, [&](std::uint32_t other) {
            const Vec3d d = toDouble(mesh.rest_positions[other]) - p;
            return dot(d, d) <= radius * radius && sameWeights(vertices, v, source_of_point[other]);
        });
        if (point == PointGrid::kNone) {
            point = std::uint32_t(source_of_point.size());
            source_of_point.push_back(v);
            if (!vertices.slots.empty()) mesh.slot_of_vertex.push_back(vertices.slot_of_vertex[v]);
            mesh.rest_positions.push_back(vertices.positions[v]);
            for (std::size_t i = v * k; i < (v + 1) * k; ++i) {
                skin.joints.push_back(vertices.joints[i]);
                skin.weights.push_back(vertices.weights[i]);
            }
            grid.add(p, point);
        }
        mesh.source_vertex.push_back(point);
    }
    // 2. Triangles follow their corners. Those that welding has made a line are dropped.
    for (const Triangle& t : vertices.triangles) {
        const Triangle welded{mesh.source_vertex[t[0]], mesh.source_vertex[t[1]], mesh.source_vertex[t[2]]};
        if (hasArea(mesh.rest_positions, welded)) mesh.triangles.push_back(welded);
    }
}

}  // namespace penumbra
