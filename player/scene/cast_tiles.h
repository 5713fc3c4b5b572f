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
    CastTiles();
    ~CastTiles();
    // Forgets what was cast before, and keeps its room. The grid and the casters stay as they are until the next call.
    void begin(const CastShadow& cast, const CastGrid& grid, int threads);

    // Writes what all casters leave visible at `wanted` vertices, as CastShadow::evaluate() does, but sums what is far
    // and hides little at every fourth vertex of every fourth row alone (CastShadow::sumAnchors()). Anchors are
    // evaluated once, when first a vertex of their tile is wanted. What a vertex gets depends on the four around it.
    void castOn(std::span<const std::uint32_t> wanted);

private:
    struct Tile;
    const CastShadow* cast_ = nullptr;
    const CastGrid* grid_ = nullptr;
    int threads_ = 1;
    std::uint32_t tiles_a_row_ = 0;
    std::size_t tile_count_ = 0;
    std::vector<std::unique_ptr<Tile>> tiles_;  // row by row; more than there are where a grid before had more
};

}  // namespace penumbra
