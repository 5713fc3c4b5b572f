#pragma once
// Surfaces around the characters. It uses no GL.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"
#include "player/frame/orbit_camera.h"
#include "player/frame/shape.h"

namespace penumbra {

// Chequered tiles of a square grid of vertices, with a vertex for every tile that touches it, so that tiles have edges.
struct GroundTiles {
    std::vector<std::uint32_t> vertices;   // indices in the grid
    std::vector<float> shades;             // for each of these, the factor of its tile
    std::vector<std::uint32_t> triangles;  // indices into `vertices`
};
constexpr std::array<float, 2> kTileShades = {1, 0.8f};
constexpr std::uint32_t kGroundTiles = 24;  // along a side, or as many squares as there are
// `side` >= 2 vertices along a side of the grid, row after row.
GroundTiles groundTiles(std::uint32_t side);

}  // namespace penumbra
