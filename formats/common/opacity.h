#pragma once
// How many rays the triangles of a surface stop, where they do not stop all: an opacity micromap (Gruen, Benthin and
// Woop 2020, "Sub-triangle opacity masks for faster ray tracing of transparent objects").
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace penumbra {

constexpr int kMaxOpacityPieces = 64;        // along an edge of a triangle
constexpr std::uint8_t kStopsAll = 255;      // a piece that stops all rays
constexpr std::size_t kUnlisted = SIZE_MAX;  // Opacity::find() of a triangle that is opaque

// A triangle with n pieces along each edge is cut into n^2 equal ones. Their values stand by rows of constant u, from
// u = 0 on; a row has the pieces by v, and the one that points up stands before the one that points down beside it.
struct Opacity {
    std::vector<std::uint32_t> triangles;  // [A] ascending: those that let some rays through
    std::vector<std::uint8_t> pieces;      // [A] n of each, 1..kMaxOpacityPieces
    std::vector<std::uint32_t> first;      // [A] where its n^2 values begin; triangles may share them
    std::vector<std::uint8_t> values;      // share of the rays that a piece stops, in 255ths

    bool empty() const { return triangles.empty(); }
    bool operator==(const Opacity&) const = default;

    // Returns the place of a triangle in `triangles`, or kUnlisted.
    std::size_t find(std::uint32_t triangle) const {
        const auto at = std::lower_bound(triangles.begin(), triangles.end(), triangle);
        return at == triangles.end() || *at != triangle ? kUnlisted : std::size_t(at - triangles.begin());
    }
    std::span<const std::uint8_t> valuesOf(std::size_t place) const {
        const auto n = std::size_t(pieces[place]);
        return std::span(values).subspan(first[place], n * n);
    }
};

// Returns the number of the piece that holds the point (1-u-v) a + u b + v c of a triangle's corners.
inline std::uint32_t opacityPiece(std::uint32_t n, float u, float v) {
    const float x = std::clamp(u, 0.0f, 1.0f) * float(n), y = std::clamp(v, 0.0f, 1.0f) * float(n);
    const std::uint32_t row = std::min(std::uint32_t(x), n - 1), column = std::min(std::uint32_t(y), n - 1 - row);
    const bool points_down = column + 1 < n - row && (x - float(row)) + (y - float(column)) > 1;
    return n * n - (n - row) * (n - row) + 2 * column + (points_down ? 1 : 0);
}

// Returns the mean share of rays that each of the triangles [0, triangles) stops, in 255ths; empty: all are opaque.
std::vector<std::uint8_t> meanOpacity(const Opacity& opacity, std::size_t triangles);

// Appends the opacity of another mesh, whose triangles count from `first_triangle` on.
void appendOpacity(const Opacity& more, std::size_t first_triangle, Opacity& opacity);

// Returns that of the same triangles where those that `turned` [T] marks are {a, c, b} instead of {a, b, c}.
Opacity turnedOpacity(const Opacity& opacity, const std::vector<bool>& turned);

// Returns that of some triangles of the same mesh. `triangles` is ascending, and its places are the new numbers.
Opacity opacityOf(const Opacity& opacity, std::span<const std::uint32_t> triangles);

}  // namespace penumbra
