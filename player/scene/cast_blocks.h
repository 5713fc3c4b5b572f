#pragma once
// Casts on a ground whose points stand row by row: on few of them where what the casters hide varies slowly.
//
// Problem: a ground of 128 x 128 vertices looks up 31 parts at each, 19 ms of one core, while its visibility varies
// slowly but for a hand's breadth around each foot.
//
// Naive: evaluate all vertices.
//
// Here: blocks of 4 x 4 squares are evaluated at their corners and in the middle. Where the corners are alike and the
// middle is what they say, the vertices between are interpolated. Numbers are in the frame of each vertex; these may be
// mixed where the frames between the corners are what the corners say, too. All vertices of the other blocks are
// evaluated. Neighbouring blocks share their edge's vertices, so nothing cracks.
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "player/scene/cast_tiles.h"

namespace penumbra {

// The first number of a vertex that sees no caster. Its others are 0.
inline const float kOpenSight = 2 * float(std::sqrt(std::numbers::pi));

// Squares between the vertices low..high of rows (0) and columns (1).
struct CastBlock {
    std::uint32_t low[2], high[2];
    bool wanted = true;
    // What castOnBlocks() finds: whether the vertices between are interpolated, and whether anybody is seen.
    bool smooth = false, seen = false;

    std::uint32_t middle(int axis) const { return (low[axis] + high[axis]) / 2; }
};
constexpr std::uint32_t kCastBlock = 4;  // squares a side
// The blocks of a grid, row by row. A grid of one row or column has blocks without squares.
std::vector<CastBlock> castBlocks(std::uint32_t rows, std::uint32_t columns);

// How far vectors are apart, as V over the sphere.
float castRowsApart(std::span<const float, kFarCoefficients> a, std::span<const float, kFarCoefficients> b);
// Numbers of a vertex between the corners of a block.
std::array<float, kFarCoefficients> betweenCorners(const CastGrid& grid, const CastBlock& block, std::uint32_t row,
                                                   std::uint32_t column);

// Writes what all casters leave visible at the vertices of the wanted blocks, those at their far edges included.
// Returns how many were evaluated. In wanted blocks that see nobody only corners and the middle are written.
std::size_t castOnBlocks(const CastShadow& cast, const CastGrid& grid, std::span<CastBlock> blocks, int threads);

}  // namespace penumbra
