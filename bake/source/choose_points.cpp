// Chooses points by collapsing edges.
//
// Problem: a scan has hundreds of thousands of vertices, but visibility is smooth over most of its surface. Few points
// are to stand for all, denser where the surface bends, on both sides of hard edges, and spread over flat parts too,
// where other limbs cast.
//
// Naive: take every k-th vertex, or the farthest from those taken. Neither knows the shape, and what is left has no
// triangles to interpolate in.
//
// Here: half-edge collapses in the order of a quadric error. What is left is a triangle mesh of vertices that were
// there before, so that points are exact where they are, and interpolation is barycentric and has no seams.
#include "bake/source/choose_points.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <queue>

#include "sh/bounding_box.h"

namespace penumbra {

namespace {

constexpr double kSpread = 0.02;    // weight of the distance from vertices beside that from planes
constexpr double kMinCosine = 0.2;  // between the normals of a triangle before and after a collapse
constexpr std::uint32_t kGone = UINT32_MAX;

// A quadratic function of a point: x^T A x + 2 b x + c, with A symmetric.
struct Quadric {
    std::array<double, 10> q{};  // xx xy xz yy yz zz, b, c

    // Adds weight * (n . x + d)^2.
    void addPlane(Vec3d n, double d, double weight) {
        const std::array<double, 10> terms{n.x * n.x, n.x * n.y, n.x * n.z, n.y * n.y, n.y * n.z,
                                           n.z * n.z, n.x * d,   n.y * d,   n.z * d,   d * d};
        for (std::size_t i = 0; i < terms.size(); ++i) q[i] += weight * terms[i];
    }
    // Adds weight * |x - p|^2.
    void addPoint(Vec3d p, double weight) {
        for (const std::size_t i : {0u, 3u, 5u}) q[i] += weight;
        q[6] -= weight * p.x;
        q[7] -= weight * p.y;
        q[8] -= weight * p.z;
        q[9] += weight * dot(p, p);
    }
    void add(const Quadric& other) {
        for (std::size_t i = 0; i < q.size(); ++i) q[i] += other.q[i];
    }
    double at(Vec3d x) const {
        return q[0] * x.x * x.x + q[3] * x.y * x.y + q[5] * x.z * x.z +
               2 * (q[1] * x.x * x.y + q[2] * x.x * x.z + q[4] * x.y * x.z + q[6] * x.x + q[7] * x.y + q[8] * x.z) +
               q[9];
    }
};

struct Collapse {
    double cost = 0;
    std::uint32_t from = 0, onto = 0;
    std::uint32_t stamp_from = 0, stamp_onto = 0;  // stamps of both ends when the cost was computed

    bool operator<(const Collapse& other) const {  // the queue gives the greatest first
        if (cost != other.cost) return cost > other.cost;
        return std::pair(from, onto) > std::pair(other.from, other.onto);
    }
};

class Collapser {
public:
    explicit Collapser(const Mesh& mesh);
    void run(std::size_t count);
    ChosenPoints result() const;

private:
    std::vector<Vec3d> position_;                     // about the centre of the box
    std::vector<Triangle> triangles_;                 // [0] is kGone where one is gone
    std::vector<std::vector<std::uint32_t>> around_;  // triangles of each vertex
    std::vector<Quadric> quadric_;
    std::vector<std::uint32_t> stamp_;  // kGone: the vertex is gone
    std::vector<bool> locked_, rim_;    // on an edge of more than two triangles; on one of one triangle
    std::priority_queue<Collapse> queue_;
    std::size_t left_ = 0;

    std::vector<std::uint32_t> ringOf(std::uint32_t v) const;
    std::vector<std::uint32_t> facesOf(std::uint32_t a, std::uint32_t b) const;
    void addFaces();
    void findRims();
    void push(std::uint32_t from, std::uint32_t onto);
    bool allowed(std::uint32_t from, std::uint32_t onto) const;
    bool turnsOver(std::uint32_t from, std::uint32_t onto) const;
    void collapse(std::uint32_t from, std::uint32_t onto);
};

Collapser::Collapser(const Mesh& mesh)
    : triangles_(mesh.triangles),
      around_(mesh.vertexCount()),
      quadric_(mesh.vertexCount()),
      stamp_(mesh.vertexCount(), kGone),
      locked_(mesh.vertexCount()),
      rim_(mesh.vertexCount()) {
    const BoundingBox box = boundsOf(mesh.rest_positions);
    const Vec3d middle = (toDouble(box.low) + toDouble(box.high)) * 0.5;
    for (const Vec3 p : mesh.rest_positions) position_.push_back(toDouble(p) - middle);
    addFaces();
    findRims();
    for (std::uint32_t v = 0; v < around_.size(); ++v)
        for (const std::uint32_t w : ringOf(v)) push(v, w);
}

void Collapser::addFaces() {
    std::vector<double> area(position_.size());
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
        const auto [a, b, c] = triangles_[t];
        const Vec3d across = cross(position_[b] - position_[a], position_[c] - position_[a]);
        const Vec3d normal = normalized(across);
        const double weight = length(across) / 6;  // a third of the area
        for (const std::uint32_t v : triangles_[t]) {
            around_[v].push_back(t);
            quadric_[v].addPlane(normal, -dot(normal, position_[a]), weight);
            area[v] += weight;
            if (stamp_[v] == kGone) ++left_;
            stamp_[v] = 0;
        }
    }
    for (std::size_t v = 0; v < area.size(); ++v) quadric_[v].addPoint(position_[v], kSpread * area[v]);
}

// Finds the boundaries. A plane upright on each keeps them where they are.
void Collapser::findRims() {
    for (std::uint32_t v = 0; v < around_.size(); ++v) {
        int rims = 0;
        for (const std::uint32_t w : ringOf(v)) {
            const std::vector<std::uint32_t> faces = facesOf(v, w);
            if (faces.size() > 2) locked_[v] = true;
            if (faces.size() != 1) continue;
            rim_[v] = true;
            if (++rims > 2) locked_[v] = true;  // sheets that meet in one vertex
            const auto [a, b, c] = triangles_[faces[0]];
            const Vec3d across = cross(position_[b] - position_[a], position_[c] - position_[a]);
            const Vec3d edge = position_[w] - position_[v], upright = normalized(cross(across, edge));
            quadric_[v].addPlane(upright, -dot(upright, position_[v]), dot(edge, edge));
        }
    }
}

std::vector<std::uint32_t> Collapser::ringOf(std::uint32_t v) const {
    std::vector<std::uint32_t> ring;
    for (const std::uint32_t t : around_[v])
        for (const std::uint32_t w : triangles_[t])
            if (w != v) ring.push_back(w);
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    return ring;
}

std::vector<std::uint32_t> Collapser::facesOf(std::uint32_t a, std::uint32_t b) const {
    std::vector<std::uint32_t> faces;
    for (const std::uint32_t t : around_[a])
        if (std::find(triangles_[t].begin(), triangles_[t].end(), b) != triangles_[t].end()) faces.push_back(t);
    return faces;
}

void Collapser::push(std::uint32_t from, std::uint32_t onto) {
    if (locked_[from]) return;
    const double cost =
        std::max(0.0, quadric_[from].at(position_[onto])) + std::max(0.0, quadric_[onto].at(position_[onto]));
    queue_.push({cost, from, onto, stamp_[from], stamp_[onto]});
}

bool Collapser::turnsOver(std::uint32_t from, std::uint32_t onto) const {
    for (const std::uint32_t t : around_[from]) {
        Triangle moved = triangles_[t];
        if (std::find(moved.begin(), moved.end(), onto) != moved.end()) continue;
        const auto normalOf = [&](const Triangle& x) {
            return normalized(cross(position_[x[1]] - position_[x[0]], position_[x[2]] - position_[x[0]]));
        };
        const Vec3d before = normalOf(moved);
        std::replace(moved.begin(), moved.end(), from, onto);
        if (!(dot(before, normalOf(moved)) >= kMinCosine)) return true;
    }
    return false;
}

// The surface must stay what it is: the two vertices have no neighbours in common but across their faces, and a vertex
// of a boundary moves along it only.
bool Collapser::allowed(std::uint32_t from, std::uint32_t onto) const {
    const std::vector<std::uint32_t> faces = facesOf(from, onto);
    if (faces.empty() || faces.size() > 2 || (rim_[from] && faces.size() != 1)) return false;
    const std::vector<std::uint32_t> a = ringOf(from), b = ringOf(onto);
    if (a.size() <= 3 && b.size() <= 3) return false;  // a tetrahedron, or a triangle alone
    std::vector<std::uint32_t> both;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
    return both.size() == faces.size() && !turnsOver(from, onto);
}

void Collapser::collapse(std::uint32_t from, std::uint32_t onto) {
    for (const std::uint32_t t : facesOf(from, onto)) {
        for (const std::uint32_t v : triangles_[t]) std::erase(around_[v], t);
        triangles_[t][0] = kGone;
    }
    for (const std::uint32_t t : around_[from]) {
        std::replace(triangles_[t].begin(), triangles_[t].end(), from, onto);
        around_[onto].push_back(t);
    }
    around_[from] = {};
    quadric_[onto].add(quadric_[from]);
    stamp_[from] = kGone;
    ++stamp_[onto];
    --left_;
    for (const std::uint32_t w : ringOf(onto)) {
        push(w, onto);
        push(onto, w);
    }
}

void Collapser::run(std::size_t count) {
    while (left_ > count && !queue_.empty()) {
        const Collapse next = queue_.top();
        queue_.pop();
        const bool fresh = stamp_[next.from] == next.stamp_from && stamp_[next.onto] == next.stamp_onto;
        if (fresh && allowed(next.from, next.onto)) collapse(next.from, next.onto);
    }
}

ChosenPoints Collapser::result() const {
    ChosenPoints out;
    std::vector<std::uint32_t> point(stamp_.size());
    for (std::uint32_t v = 0; v < stamp_.size(); ++v) {
        if (stamp_[v] == kGone) continue;
        point[v] = std::uint32_t(out.vertices.size());
        out.vertices.push_back(v);
    }
    for (const Triangle& t : triangles_)
        if (t[0] != kGone) out.triangles.push_back({point[t[0]], point[t[1]], point[t[2]]});
    return out;
}

}  // namespace

ChosenPoints choosePoints(const Mesh& mesh, std::size_t count) {
    assert(!mesh.two_sided);
    Collapser collapser(mesh);
    collapser.run(count);
    return collapser.result();
}

}  // namespace penumbra
