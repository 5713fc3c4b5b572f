#pragma once
#include "formats/stage/model_file.h"
#include "pack/sections/asset_writer.h"

namespace penumbra {

// Writes what makes a model a composed one. `part_of_vertex` is in the order of the asset. `residual`
// are the clusters of the residual, already written; there may be none. Throws InvalidInput where the fields do not
// have the shapes of formats/common/part_fields.h, or more points along an axis than an asset can hold.
Offset<fbs::Composition> writeComposition(FlatBufferBuilder& builder, const Composition& composition,
                                          std::span<const std::uint16_t> part_of_vertex,
                                          const std::vector<Offset<fbs::Cluster>>& residual);

}  // namespace penumbra
