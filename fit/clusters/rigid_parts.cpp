// Finds the near-rigid parts of a deforming mesh.
//
// Problem: a mesh without a skeleton moves, and the model of the pose needs bones. Some parts of the mesh move almost
// rigidly; which ones, and how many, is not known.
//
// Naive: cut the surface into patches of equal size. Patches then lie across folds, and no bone describes how they
// move.
//
// Here: triangles whose rotations agree over all frames form a part (James and Twigg 2005). Mean-shift finds such
// groups without knowing their number; merging and cutting then bring the parts to the number that is asked for. The
// steps are numbered in rigid_parts.h. See docs/formulas.md, section 4.

#include "fit/clusters/rigid_parts.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "fit/clusters/mean_shift.h"
#include "fit/clusters/triangle_motion.h"
#include "fit/numerics/pca.h"
#include "formats/common/parallel_for.h"

namespace penumbra {

namespace {

constexpr std::size_t kMaxPoints = 2000;  // number of triangles that climb in the mean-shift

// A set of triangles and the moments of their motions (triangle_motion.h).
struct Piece {
    std::vector<std::uint32_t> triangles;
    std::vector<double> sum;  // [D] sum of their motions
    double squares = 0;       // sum of their motions' squared lengths

    double count() const { return double(triangles.size()); }
    // Returns the sum of squared distances from the mean motion.
    double spread() const {
        double s = squares;
        for (double x : sum) s -= x * x / count();
        return std::max(s, 0.0);
    }
};

Piece makePiece(const MatrixF& motions, std::vector<std::uint32_t> triangles) {
    Piece piece{std::move(triangles), std::vector<double>(motions.columns), 0};
    for (std::uint32_t t : piece.triangles)
        for (std::size_t d = 0; d < motions.columns; ++d) {
            piece.sum[d] += motions(t, d);
            piece.squares += double(motions(t, d)) * motions(t, d);
        }
    return piece;
}

// Returns the squared distance between the mean motions of two pieces.
double squaredDistance(const Piece& a, const Piece& b) {
    double sum = 0;
    for (std::size_t d = 0; d < a.sum.size(); ++d) {
        const double x = a.sum[d] / a.count() - b.sum[d] / b.count();
        sum += x * x;
    }
    return sum;
}

// Returns what joining two pieces adds to the sum of squared distances from the mean motion.
double wardCost(const Piece& a, const Piece& b) {
    return a.count() * b.count() / (a.count() + b.count()) * squaredDistance(a, b);
}

// Returns all pairs of triangles that share an edge, whatever its direction. Each pair comes once for each shared edge.
std::vector<std::array<std::uint32_t, 2>> neighbourTriangles(std::span<const Triangle> triangles) {
    std::vector<std::array<std::uint32_t, 3>> edges;  // two vertices a < b, triangle
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (std::size_t i = 0; i < 3; ++i) {
            const auto [a, b] = std::minmax(triangles[t][i], triangles[t][(i + 1) % 3]);
            edges.push_back({a, b, std::uint32_t(t)});
        }
    std::sort(edges.begin(), edges.end());
    std::vector<std::array<std::uint32_t, 2>> pairs;
    for (std::size_t i = 1; i < edges.size(); ++i)
        if (edges[i][0] == edges[i - 1][0] && edges[i][1] == edges[i - 1][1] && edges[i][2] != edges[i - 1][2])
            pairs.push_back({edges[i - 1][2], edges[i][2]});
    return pairs;
}

// Returns the mode of each triangle.
std::vector<std::uint32_t> modesOf(const MatrixF& motions, int threads) {
    // 1. A sample of the triangles finds the modes.
    const std::vector<std::size_t> sample = evenlySpread(motions.rows, kMaxPoints);
    MatrixF points(sample.size(), motions.columns);
    for (std::size_t r = 0; r < sample.size(); ++r)
        std::copy_n(motions.row(sample[r]).begin(), motions.columns, points.row(r).begin());
    const std::vector<double> counts(points.rows, 1.0);
    const std::vector<std::uint32_t> label = meanShift(points, counts, kPartBandwidth, threads);
    // 2. Every triangle takes the mode of the nearest triangle of the sample.
    std::vector<std::uint32_t> out(motions.rows);
    constexpr std::size_t kBlock = 256;
    parallelFor((out.size() + kBlock - 1) / kBlock, threads, [&](std::size_t block) {
        for (std::size_t t = block * kBlock; t < std::min((block + 1) * kBlock, out.size()); ++t) {
            float least = std::numeric_limits<float>::infinity();
            for (std::size_t r = 0; r < points.rows; ++r) {
                float d2 = 0;
                for (std::size_t d = 0; d < points.columns; ++d) {
                    const float x = points(r, d) - motions(t, d);
                    d2 += x * x;
                }
                if (d2 < least) least = d2, out[t] = label[r];
            }
        }
    });
    return out;
}

// Returns the root of t in a union-find forest and shortens the path to it.
std::uint32_t rootOf(std::vector<std::uint32_t>& parent, std::uint32_t t) {
    while (parent[t] != t) t = parent[t] = parent[parent[t]];
    return t;
}

// Returns the connected sets of triangles that have one label.
std::vector<Piece> connectedPieces(const MatrixF& motions, const std::vector<std::uint32_t>& label,
                                   const std::vector<std::array<std::uint32_t, 2>>& pairs) {
    // 1. Unite neighbours of one label; the triangle with the smallest number is the root.
    std::vector<std::uint32_t> parent(label.size());
    std::iota(parent.begin(), parent.end(), 0);
    for (auto [a, b] : pairs)
        if (label[a] == label[b]) {
            const std::uint32_t x = rootOf(parent, a), y = rootOf(parent, b);
            parent[std::max(x, y)] = std::min(x, y);
        }
    // 2. Collect the triangles of each root.
    std::map<std::uint32_t, std::vector<std::uint32_t>> members;  // triangles by their root
    for (std::uint32_t t = 0; t < label.size(); ++t) members[rootOf(parent, t)].push_back(t);
    std::vector<Piece> pieces;
    for (auto& [first, triangles] : members) pieces.push_back(makePiece(motions, std::move(triangles)));
    return pieces;
}

// Pieces, and which of them touch. A piece that has joined another is left without triangles.
struct PieceGraph {
    std::vector<Piece> pieces;
    std::vector<std::set<std::uint32_t>> neighbours;

    // Joins `source` to `target`, with its triangles, moments and neighbours.
    void unite(std::uint32_t target, std::uint32_t source) {
        Piece& into = pieces[target];
        Piece& from = pieces[source];
        into.triangles.insert(into.triangles.end(), from.triangles.begin(), from.triangles.end());
        for (std::size_t d = 0; d < into.sum.size(); ++d) into.sum[d] += from.sum[d];
        into.squares += from.squares;
        for (std::uint32_t p : neighbours[source]) {
            neighbours[p].erase(source);
            if (p != target) neighbours[p].insert(target), neighbours[target].insert(p);
        }
        neighbours[source].clear();
        from.triangles.clear();
    }
};

PieceGraph makeGraph(std::vector<Piece> pieces, const std::vector<std::array<std::uint32_t, 2>>& pairs,
                     std::size_t triangles) {
    PieceGraph graph{std::move(pieces), {}};
    std::vector<std::uint32_t> piece_of(triangles);
    for (std::size_t p = 0; p < graph.pieces.size(); ++p)
        for (std::uint32_t t : graph.pieces[p].triangles) piece_of[t] = std::uint32_t(p);
    graph.neighbours.resize(graph.pieces.size());
    for (auto [a, b] : pairs)
        if (piece_of[a] != piece_of[b]) {
            graph.neighbours[piece_of[a]].insert(piece_of[b]);
            graph.neighbours[piece_of[b]].insert(piece_of[a]);
        }
    return graph;
}

// Joins pieces of fewer than `least` triangles to the neighbour that moves most like them, the smallest first. A piece
// that touches nothing stays as it is.
void joinTiny(PieceGraph& graph, std::size_t least) {
    std::set<std::pair<std::size_t, std::uint32_t>> tiny;  // size, piece
    const auto enter = [&](std::uint32_t p) {
        if (graph.pieces[p].triangles.size() < least) tiny.insert({graph.pieces[p].triangles.size(), p});
    };
    for (std::uint32_t p = 0; p < graph.pieces.size(); ++p) enter(p);
    while (!tiny.empty()) {
        const std::uint32_t piece = tiny.begin()->second;
        tiny.erase(tiny.begin());
        double best = std::numeric_limits<double>::infinity();
        std::uint32_t nearest = piece;
        for (std::uint32_t p : graph.neighbours[piece])
            if (const double d2 = squaredDistance(graph.pieces[p], graph.pieces[piece]); d2 < best)
                best = d2, nearest = p;
        if (nearest == piece) continue;
        tiny.erase({graph.pieces[nearest].triangles.size(), nearest});
        graph.unite(nearest, piece);
        enter(nearest);
    }
}

// Returns the pieces that are left, in ascending order.
std::vector<std::uint32_t> piecesLeft(const PieceGraph& graph) {
    std::vector<std::uint32_t> left;
    for (std::uint32_t p = 0; p < graph.pieces.size(); ++p)
        if (!graph.pieces[p].triangles.empty()) left.push_back(p);
    return left;
}

// Returns the pair whose union costs least: among neighbours or, when no pieces touch, among all.
std::pair<std::uint32_t, std::uint32_t> cheapestPair(const PieceGraph& graph, const std::vector<std::uint32_t>& left) {
    std::pair<std::uint32_t, std::uint32_t> cheapest{left[0], left[1]};
    double best = std::numeric_limits<double>::infinity();
    const auto offer = [&](std::uint32_t a, std::uint32_t b) {
        if (a >= b) return;
        if (const double cost = wardCost(graph.pieces[a], graph.pieces[b]); cost < best) best = cost, cheapest = {a, b};
    };
    for (std::uint32_t a : left)
        for (std::uint32_t b : graph.neighbours[a]) offer(a, b);
    if (best == std::numeric_limits<double>::infinity())
        for (std::uint32_t a : left)
            for (std::uint32_t b : left) offer(a, b);
    return cheapest;
}

std::vector<Piece> mergedDownTo(PieceGraph graph, std::size_t count) {
    std::vector<std::uint32_t> left = piecesLeft(graph);
    for (; left.size() > count; left = piecesLeft(graph)) {
        const auto [target, source] = cheapestPair(graph, left);
        graph.unite(target, source);
    }
    std::vector<Piece> pieces;
    for (std::uint32_t p : left) pieces.push_back(std::move(graph.pieces[p]));
    return pieces;
}

// Cuts a piece at the median along a principal axis of its triangles' centers. Axis 0 is the longest.
std::array<Piece, 2> halvesOf(const Piece& piece, const DeformingFrames& mesh, const MatrixF& motions,
                              std::size_t which_axis) {
    std::vector<std::uint32_t> order = piece.triangles;
    std::vector<Vec3> centers;
    const auto center = [&](std::uint32_t t) {
        const Triangle& c = mesh.triangles[t];
        return toFloat((toDouble(mesh.rest[c[0]]) + toDouble(mesh.rest[c[1]]) + toDouble(mesh.rest[c[2]])) / 3.0);
    };
    for (std::uint32_t t : order) centers.push_back(center(t));
    const Vec3d axis = principalAxes(centers)[which_axis];
    const auto along = [&](std::uint32_t t) { return dot(toDouble(center(t)), axis); };
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return std::pair(along(a), a) < std::pair(along(b), b); });
    const auto middle = order.begin() + std::ptrdiff_t(order.size() / 2);
    return {makePiece(motions, {order.begin(), middle}), makePiece(motions, {middle, order.end()})};
}

void cutPiece(std::vector<Piece>& pieces, std::size_t which, const DeformingFrames& mesh, const MatrixF& motions) {
    auto [first, second] = halvesOf(pieces[which], mesh, motions, 0);
    pieces[which] = std::move(first);
    pieces.push_back(std::move(second));
}

// Tells whether a piece bends. Noise turns every triangle, but it changes the mean motion of a half only a little; the
// means of two halves differ only where there is a bend between them.
bool bends(const Piece& piece, const DeformingFrames& mesh, const MatrixF& motions) {
    for (std::size_t axis : {0, 1}) {
        const auto [first, second] = halvesOf(piece, mesh, motions, axis);
        if (squaredDistance(first, second) > kPartBandwidth * kPartBandwidth / 16) return true;
    }
    return false;
}

// Cuts the piece with the largest sum of squared distances, again and again, until there are `count` pieces.
void cutUpTo(std::vector<Piece>& pieces, std::size_t count, const DeformingFrames& mesh, const MatrixF& motions) {
    while (pieces.size() < count) {
        const auto key = [](const Piece& p) {
            return p.triangles.size() < 2 ? std::pair(-1.0, 0.0) : std::pair(p.spread(), p.count());
        };
        const auto most = std::max_element(pieces.begin(), pieces.end(),
                                           [&](const Piece& a, const Piece& b) { return key(a) < key(b); });
        if (most->triangles.size() < 2) return;
        cutPiece(pieces, std::size_t(most - pieces.begin()), mesh, motions);
    }
}

// Cuts the largest piece that bends, again and again, until all pieces are small or there are enough.
void cutLarge(std::vector<Piece>& pieces, const DeformingFrames& mesh, const MatrixF& motions) {
    const double per_vertex = double(mesh.triangles.size()) / double(std::max<std::size_t>(mesh.rest.size(), 1));
    const double most = per_vertex * double(kAutoPartVertices);
    std::vector<std::size_t> large;  // pieces that are still to be looked at
    const auto smaller = [&](std::size_t a, std::size_t b) {
        return std::pair(pieces[a].count(), b) < std::pair(pieces[b].count(), a);
    };
    for (std::size_t p = 0; p < pieces.size(); ++p)
        if (pieces[p].count() > most) large.push_back(p);
    while (pieces.size() < kMaxAutoParts && !large.empty()) {
        const auto largest = std::max_element(large.begin(), large.end(), smaller);
        const std::size_t p = *largest;
        large.erase(largest);
        if (!bends(pieces[p], mesh, motions)) continue;
        cutPiece(pieces, p, mesh, motions);
        for (std::size_t half : {p, pieces.size() - 1})
            if (pieces[half].count() > most) large.push_back(half);
    }
}

// Returns the piece of each vertex: the one with most of the area at rest around it, or the first of equals.
std::vector<std::uint32_t> piecesOfVertices(const DeformingFrames& mesh, const std::vector<std::uint32_t>& piece_of) {
    std::vector<std::map<std::uint32_t, double>> area(mesh.rest.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto [a, b, c] = mesh.triangles[t];
        const Vec3d p = toDouble(mesh.rest[a]);
        const double size = length(cross(toDouble(mesh.rest[b]) - p, toDouble(mesh.rest[c]) - p));
        for (std::uint32_t v : mesh.triangles[t]) area[v][piece_of[t]] += size;
    }
    std::vector<std::uint32_t> out(mesh.rest.size(), 0);  // a vertex without triangles gets 0
    for (std::size_t v = 0; v < out.size(); ++v) {
        double most = -1;
        for (auto [piece, size] : area[v])
            if (size > most) most = size, out[v] = piece;
    }
    return out;
}

// Numbers the pieces that have a vertex, in the order of their first vertex. Triangles of other pieces go with their
// first corner.
RigidParts numberParts(const DeformingFrames& mesh, const std::vector<Piece>& pieces) {
    std::vector<std::uint32_t> piece_of(mesh.triangles.size());
    for (std::size_t p = 0; p < pieces.size(); ++p)
        for (std::uint32_t t : pieces[p].triangles) piece_of[t] = std::uint32_t(p);
    RigidParts parts;
    std::vector<int> name(std::max<std::size_t>(pieces.size(), 1), -1);
    for (std::uint32_t piece : piecesOfVertices(mesh, piece_of)) {
        if (name[piece] < 0) name[piece] = int(parts.count++);
        parts.part_of_vertex.push_back(std::uint16_t(name[piece]));
    }
    for (std::size_t t = 0; t < piece_of.size(); ++t)
        parts.part_of_triangle.push_back(name[piece_of[t]] < 0 ? parts.part_of_vertex[mesh.triangles[t][0]]
                                                               : std::uint16_t(name[piece_of[t]]));
    return parts;
}

}  // namespace

RigidParts findRigidParts(const DeformingFrames& mesh, std::size_t count, int threads) {
    assert(!mesh.frames.empty() && count <= 65535);
    if (mesh.triangles.empty()) return numberParts(mesh, {});
    // Steps 1 and 2: motions, modes, connected pieces, and no tiny ones.
    const MatrixF motions = triangleMotions(mesh, threads);
    const std::vector<std::array<std::uint32_t, 2>> pairs = neighbourTriangles(mesh.triangles);
    PieceGraph graph =
        makeGraph(connectedPieces(motions, modesOf(motions, threads), pairs), pairs, mesh.triangles.size());
    joinTiny(graph, mesh.triangles.size() / 200);
    // Steps 3 and 4: merge, then cut.
    std::vector<Piece> pieces = mergedDownTo(std::move(graph), count ? count : kMaxAutoParts);
    if (count)
        cutUpTo(pieces, count, mesh, motions);
    else
        cutLarge(pieces, mesh, motions);
    // Step 5.
    return numberParts(mesh, pieces);
}

}  // namespace penumbra
