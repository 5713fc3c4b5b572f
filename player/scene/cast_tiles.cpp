// Casts on vertices of a grid.
//
// Problem: the vertices of a ground that somebody's shadow reaches look up all 31 parts of a character each.
//
// Naive: evaluate them in the order in which they are wanted. 64 of a row are farther apart than the character is tall,
// so nothing can be left out.
//
// Here: vertices go by tiles, which have anchors on a lattice of every fourth vertex: a part that is far from them is
// looked up there, and only what stands near is looked up at each vertex (runtime/cast/cast_anchors.cpp).
#include "player/scene/cast_tiles.h"

#include <algorithm>
#include <array>

#include "formats/common/parallel_for.h"

namespace penumbra {

namespace {

constexpr std::uint32_t kStep = 4;          // squares from an anchor to the next
constexpr std::uint32_t kTile = 8 * kStep;  // squares a side
// Mean distance of a point of a square from its four corners, as a share of its side.
constexpr float kMeanCornerDistance = 0.765f;
constexpr float kFlat = 1e-3f;  // a tile is flat whose vertices lie so near to its anchors' squares, in their sides

// Where rows, or columns, of the anchors of a tile lie. The last line of the grid is one.
struct TileLines {
    std::array<std::uint32_t, kTile / kStep + 1> at{};
    std::uint32_t count = 0;

    TileLines() = default;
    TileLines(std::uint32_t tile, std::uint32_t size) {
        const std::uint32_t first = tile * kTile, last = std::min(first + kTile, size - 1);
        for (std::uint32_t i = first; i < last; i += kStep) at[count++] = i;
        at[count++] = last;
    }
    std::uint32_t first() const { return at.front(); }
    std::uint32_t last() const { return at[count - 1]; }
    // The line before vertex `i`, the one after it, and how far the vertex is from the first to the second.
    std::uint32_t before(std::uint32_t i) const { return std::min((i - at[0]) / kStep, std::max(count, 2u) - 2); }
    std::uint32_t after(std::uint32_t i) const { return std::min(before(i) + 1, count - 1); }
    float share(std::uint32_t i) const {
        const std::uint32_t low = at[before(i)], high = at[after(i)];
        return high == low ? 0 : float(i - low) / float(high - low);
    }
};

struct Points {
    std::vector<Vec3> positions, normals, tangents;

    void clear() { positions.clear(), normals.clear(), tangents.clear(); }
    void add(const CastReceivers& of, std::uint32_t v) {
        positions.push_back(of.positions[v]);
        normals.push_back(of.normals[v]);
        tangents.push_back(of.tangents[v]);
    }
    CastReceivers view() const { return {positions, normals, tangents}; }
};

// Vertices that are looked up together, and what they see. Each thread has one and keeps its room.
struct Batch {
    Points vertices;
    std::vector<std::uint16_t> anchor;
    std::vector<float> weight, out;

    void clear() { vertices.clear(), anchor.clear(), weight.clear(); }
};

}  // namespace

struct CastTiles::Tile {
    TileLines rows, columns;
    CastAnchors anchors;
    bool has_anchors = false;           // they were asked for; there may be none
    std::vector<std::uint32_t> wanted;  // vertices

    void begin(std::uint32_t row, std::uint32_t column, const CastGrid& grid) {
        rows = TileLines(row, grid.rows);
        columns = TileLines(column, grid.columns);
        anchors.sums = has_anchors = false;
        anchors.choice = {};
    }

    // Without anchors every vertex looks up all for itself: on curved grounds, where what the anchors see is not what
    // lies between them, and where they are farther apart than `widest`.
    void sumAnchors(const CastShadow& cast, const CastGrid& grid, float widest) {
        thread_local Points lattice;
        lattice.clear();
        for (std::uint32_t i = 0; i < rows.count; ++i)
            for (std::uint32_t j = 0; j < columns.count; ++j)
                lattice.add(grid.vertices, rows.at[i] * grid.columns + columns.at[j]);
        const float spacing = kMeanCornerDistance * largestSide(lattice);
        if (spacing > widest || largestBulge(grid) > kFlat * spacing) return;
        cast.sumAnchors(lattice.view(), around(grid), spacing, {}, anchors);
    }

    // All vertices.
    CasterSphere around(const CastGrid& grid) const {
        thread_local std::vector<Vec3> all;
        all.clear();
        for (std::uint32_t i = rows.first(); i <= rows.last(); ++i) {
            const auto row = grid.vertices.positions.begin() + std::ptrdiff_t(std::size_t(i) * grid.columns);
            all.insert(all.end(), row + std::ptrdiff_t(columns.first()), row + std::ptrdiff_t(columns.last()) + 1);
        }
        return sphereAround(all);
    }

    // How far a vertex is from the surface that the anchors around it span, at most. What the anchors see is mixed as
    // if it lay there.
    float largestBulge(const CastGrid& grid) const {
        float off = 0;
        for (std::uint32_t i = rows.first(); i <= rows.last(); ++i)
            for (std::uint32_t j = columns.first(); j <= columns.last(); ++j) {
                const auto at = [&](std::uint32_t r, std::uint32_t c) {
                    return grid.vertices.positions[rows.at[r] * grid.columns + columns.at[c]];
                };
                const std::uint32_t up = rows.before(i), down = rows.after(i), left = columns.before(j),
                                    right = columns.after(j);
                const float x = rows.share(i), z = columns.share(j);
                const Vec3 between = (at(up, left) * (1 - z) + at(up, right) * z) * (1 - x) +
                                     (at(down, left) * (1 - z) + at(down, right) * z) * x;
                off = std::max(off, length(grid.vertices.positions[i * grid.columns + j] - between));
            }
        return off;
    }

    float largestSide(const Points& lattice) const {
        float side = 0;
        for (std::uint32_t i = 0; i < rows.count; ++i)
            for (std::uint32_t j = 0; j < columns.count; ++j) {
                const Vec3* const at = &lattice.positions[i * columns.count + j];
                if (i + 1 < rows.count) side = std::max(side, length(at[columns.count] - *at));
                if (j + 1 < columns.count) side = std::max(side, length(at[1] - *at));
            }
        return side;
    }

    void castOn(const CastShadow& cast, const CastGrid& grid) const {
        thread_local Batch batch;
        batch.clear();
        for (const std::uint32_t v : wanted) add(v / grid.columns, v % grid.columns, batch);
        for (const std::uint32_t v : wanted) batch.vertices.add(grid.vertices, v);
        batch.out.resize(wanted.size() * kFarCoefficients);
        cast.evaluateAt(anchors, batch.vertices.view(), batch.anchor.data(), batch.weight.data(), batch.out);
        for (std::size_t i = 0; i < wanted.size(); ++i)
            std::copy_n(&batch.out[i * kFarCoefficients], kFarCoefficients,
                        &grid.mirrored[wanted[i] * kFarCoefficients]);
    }

    // The anchors of a vertex.
    void add(std::uint32_t row, std::uint32_t column, Batch& batch) const {
        static_assert(kAnchorsOfReceiver == 4);
        const float x = rows.share(row), z = columns.share(column);
        for (const std::uint32_t r : {rows.before(row), rows.after(row)})
            for (const std::uint32_t c : {columns.before(column), columns.after(column)})
                batch.anchor.push_back(std::uint16_t(r * columns.count + c));
        for (const float down : {1 - x, x})
            for (const float right : {1 - z, z}) batch.weight.push_back(down * right);
    }
};

CastTiles::CastTiles() = default;
CastTiles::~CastTiles() = default;

void CastTiles::begin(const CastShadow& cast, const CastGrid& grid, int threads) {
    cast_ = &cast;
    grid_ = &grid;
    threads_ = threads;
    tiles_a_row_ = grid.columns / kTile + 1;
    tile_count_ = std::size_t(grid.rows / kTile + 1) * tiles_a_row_;
    while (tiles_.size() < tile_count_) tiles_.push_back(std::make_unique<Tile>());
    for (std::size_t t = 0; t < tile_count_; ++t)
        tiles_[t]->begin(std::uint32_t(t / tiles_a_row_), std::uint32_t(t % tiles_a_row_), grid);
}

void CastTiles::castOn(std::span<const std::uint32_t> wanted) {
    for (std::size_t t = 0; t < tile_count_; ++t) tiles_[t]->wanted.clear();
    for (const std::uint32_t v : wanted)
        tiles_[v / grid_->columns / kTile * tiles_a_row_ + v % grid_->columns / kTile]->wanted.push_back(v);
    parallelFor(tile_count_, threads_, [&](std::size_t t) {
        Tile& tile = *tiles_[t];
        if (tile.wanted.empty()) return;
        if (!tile.has_anchors) tile.sumAnchors(*cast_, *grid_, cast_->smallestCaster());
        tile.has_anchors = true;
        tile.castOn(*cast_, *grid_);
    });
}

}  // namespace penumbra
