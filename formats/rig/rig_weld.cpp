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

// Packs rows of K influences, padded with joint 0 of weight 0.
void packInfluences(const std::vector<std::vector<Influence>>& influences, SourceVertices& out) {
    for (const auto& list : influences) out.influences = std::max(out.influences, int(list.size()));
    const std::size_t k = std::size_t(out.influences);
    out.joints.assign(influences.size() * k, 0);
    out.weights.assign(influences.size() * k, 0);
    for (std::size_t v = 0; v < influences.size(); ++v)
        for (std::size_t i = 0; i < influences[v].size(); ++i) {
            out.joints[v * k + i] = std::uint16_t(influences[v][i].joint);
            out.weights[v * k + i] = float(influences[v][i].weight);
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
    std::vector<std::vector<Influence>> influences;
    for (std::size_t p = 0; p < source.parts.size(); ++p) {
        const SourcePart& part = source.parts[p];
        const std::uint32_t first = std::uint32_t(out.positions.size());
        const std::uint16_t slot = slotOf(source, part, out.slots);
        out.slot_of_vertex.resize(out.positions.size() + part.positions.size(), slot);
        out.used.resize(out.slot_of_vertex.size());
        for (const Triangle& t : part.triangles)
            for (const std::uint32_t v : t) out.used[first + v] = true;
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

    void add(Vec3d p, std::uint32_t point) { points_of_cell_[keyOf(p)].push_back(point); }

    template <class Accept>  // the first added point that `accept` takes, or none
    std::uint32_t find(Vec3d p, const Accept& accept) const {
        std::uint32_t best = kNone;
        const Vec3d reach{radius_, radius_, radius_};
        const Key low = keyOf(p - reach), high = keyOf(p + reach);
        for (auto x = low[0]; x <= high[0]; ++x)
            for (auto y = low[1]; y <= high[1]; ++y)
                for (auto z = low[2]; z <= high[2]; ++z) {
                    const auto cell = points_of_cell_.find({x, y, z});
                    if (cell == points_of_cell_.end()) continue;
                    for (const std::uint32_t point : cell->second)
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
    std::unordered_map<Key, std::vector<std::uint32_t>, Hash> points_of_cell_;
};
}  // namespace

bool hasArea(const std::vector<Vec3>& positions, const Triangle& t) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return false;
    const Vec3d a = toDouble(positions[t[0]]), b = toDouble(positions[t[1]]), c = toDouble(positions[t[2]]);
    const double longest = std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)});
    return length(cross(b - a, c - a)) > kNoArea * longest;
}

namespace {

constexpr std::uint16_t kNoSlot = UINT16_MAX;

// Welds one vertex after the other.
class Welder {
public:
    Welder(const SourceVertices& vertices, Mesh& mesh, Skin& skin, Welded& out)
        : vertices_(vertices),
          mesh_(mesh),
          skin_(skin),
          out_(out),
          radius_(kWeldDistance * boxDiagonal(vertices.positions)),
          grid_(radius_, 64 * radius_) {}

    // The vertex joins the first shading point that fits, or becomes a new one.
    void add(std::size_t v) {
        std::uint32_t point = find(v, true);
        if (point == PointGrid::kNone) point = newPoint(v);
        // A vertex that no triangle of its part uses takes any point, and its own has the slot of whoever comes next.
        if (isUsed(v) && slot_of_point_[point] == kNoSlot) slot_of_point_[point] = slotOfVertex(v);
        mesh_.source_vertex.push_back(point);
    }

    void finish() {
        for (std::size_t p = 0; p < slot_of_point_.size() && !vertices_.slots.empty(); ++p)
            mesh_.slot_of_vertex.push_back(slot_of_point_[p] == kNoSlot ? vertices_.slot_of_vertex[source_of_point_[p]]
                                                                        : slot_of_point_[p]);
    }

private:
    bool isUsed(std::size_t v) const { return vertices_.used.empty() || vertices_.used[v]; }
    std::uint16_t slotOfVertex(std::size_t v) const {
        return vertices_.slots.empty() ? std::uint16_t(0) : vertices_.slot_of_vertex[v];
    }
    std::uint8_t sideOf(std::size_t v) const { return vertices_.side.empty() ? std::uint8_t(0) : vertices_.side[v]; }

    std::uint32_t find(std::size_t v, bool of_slot) const {
        const Vec3d p = toDouble(vertices_.positions[v]);
        return grid_.find(p, [&](std::uint32_t other) {
            const Vec3d d = toDouble(mesh_.rest_positions[other]) - p;
            return dot(d, d) <= radius_ * radius_ && sideOf(v) == sideOf(source_of_point_[other]) &&
                   (!of_slot || !isUsed(v) || slot_of_point_[other] == kNoSlot ||
                    slot_of_point_[other] == slotOfVertex(v)) &&
                   sameWeights(vertices_, v, source_of_point_[other]);
        });
    }

    std::uint32_t newPoint(std::size_t v) {
        const auto point = std::uint32_t(source_of_point_.size());
        const std::uint32_t twin = find(v, false);
        const std::size_t k = std::size_t(vertices_.influences),
                          from = twin == PointGrid::kNone ? v : source_of_point_[twin];
        out_.twin_of_point.push_back(twin == PointGrid::kNone ? point : out_.twin_of_point[twin]);
        source_of_point_.push_back(v);
        slot_of_point_.push_back(kNoSlot);
        // Points that differ in their slot alone stand at the very same place, so that no ray passes between them.
        mesh_.rest_positions.push_back(vertices_.positions[from]);
        for (std::size_t i = from * k; i < (from + 1) * k; ++i) {
            skin_.joints.push_back(vertices_.joints[i]);
            skin_.weights.push_back(vertices_.weights[i]);
        }
        grid_.add(toDouble(mesh_.rest_positions.back()), point);
        return point;
    }

    const SourceVertices& vertices_;
    Mesh& mesh_;
    Skin& skin_;
    Welded& out_;
    double radius_;
    PointGrid grid_;
    std::vector<std::size_t> source_of_point_;
    std::vector<std::uint16_t> slot_of_point_;
};

}  // namespace

Welded weldVertices(const SourceVertices& vertices, Mesh& mesh, Skin& skin) {
    Welded out;
    mesh = {};
    mesh.slots = vertices.slots;
    skin.influences = vertices.influences;
    Welder welder(vertices, mesh, skin, out);
    for (std::size_t v = 0; v < vertices.positions.size(); ++v) welder.add(v);
    welder.finish();
    // Triangles follow their corners. Those that welding has made a line are dropped.
    for (const Triangle& t : vertices.triangles) {
        const Triangle welded{mesh.source_vertex[t[0]], mesh.source_vertex[t[1]], mesh.source_vertex[t[2]]};
        if (!hasArea(mesh.rest_positions, welded)) continue;
        mesh.triangles.push_back(welded);
        out.source_corners.push_back(t);
    }
    return out;
}

}  // namespace penumbra
