#pragma once
#include "formats/stage/model_file.h"
#include "pack/sections/asset_writer.h"

namespace penumbra {

// The parts and gains of vertices in the order of the asset.
struct VertexParts {
    std::vector<std::uint16_t> part_of_vertex;
    std::vector<std::uint8_t> near_gains;  // rows of the vertices of clusters
};

// Writes what makes a model a composed one. `residual` are the clusters of the residual, already written; there may be
// none. Throws InvalidInput where the fields do not have the shapes of formats/common/part_fields.h, or more points
// along an axis than an asset can hold.
Offset<fbs::Composition> writeComposition(FlatBufferBuilder& builder, const Composition& composition,
                                          const VertexParts& vertices,
                                          const std::vector<Offset<fbs::Cluster>>& residual);

}  // namespace penumbra
