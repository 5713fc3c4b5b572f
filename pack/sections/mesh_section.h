#pragma once
// Brings the vertices of a model to the order of an asset.
#include "formats/stage/model_file.h"
#include "pack/sections/asset_writer.h"
#include "pack/sections/composition_section.h"

namespace penumbra {

// Returns the vertices of the model in the order of its clusters.
MeshSection meshSection(const Model& model);
// Does the same for a model of chosen points (model.drawn): first the points, then all other vertices of the drawn mesh
// in its order, which follow points. shading_point counts the vertices of the drawn mesh. Throws Unsupported for a
// deforming model.
MeshSection denseSection(const Model& model);

// Returns the part of each vertex of a section of a composed model, and nothing for others. A vertex that follows
// points has the part of the one that it has most of, and no gains. Throws InvalidInput if the model does not have one
// part and one row of gains a vertex.
VertexParts partsOf(const Model& model, const MeshSection& section);

}  // namespace penumbra
