#pragma once
// Casts on vertices of a grid, tile by tile, with anchors.
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "runtime/cast/cast_shadow.h"

namespace penumbra {

struct CastGrid {
    std::uint32_t rows = 0, columns = 0;
    CastReceivers vertices;     // [rows, columns]
    std::span<float> mirrored;  // [rows, columns, kFarCoefficients] what is visible past the casters
};

class CastTiles {
public:
    // The grid and the casters outlive this object, and neither moves.
    CastTiles(const CastShadow& cast, const CastGrid& grid, int threads);
    ~CastTiles();

    // Writes what all casters leave visible at `wanted` vertices, as CastShadow::evaluate() does, but sums what is far
    // and hides little at every fourth vertex of every fourth row alone (CastShadow::sumAnchors()). Anchors are
    // evaluated once, when first a vertex of their tile is wanted. What a vertex gets depends on the four around it.
    void castOn(std::span<const std::uint32_t> wanted);

private:
    struct Tile;
    const CastShadow& cast_;
    const CastGrid& grid_;
    int threads_;
    std::uint32_t tiles_a_row_;
    std::vector<std::unique_ptr<Tile>> tiles_;  // row by row
};

}  // namespace penumbra
