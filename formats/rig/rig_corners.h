#pragma once
// Splits vertices by their corners: at the edges of `--crease`, and between the two layers of a sheet.
#include "formats/rig/rig_normals.h"

namespace penumbra {

// Adds to `split` a vertex for each further group of corners of a vertex, and sets `group` where `--crease` makes
// edges. Corners of one place are of one group where they are neighbours across an edge and their triangles' normals
// differ by at most the angle. Places with normals of the file, and all without `--crease`, are split only where a
// triangle has its own reverse at the same place, which makes two layers of one sheet.
void splitCorners(const SourceVertices& vertices, std::span<const std::uint32_t> place_of_vertex,
                  const RigOptions& options, SplitVertices& split);

}  // namespace penumbra
