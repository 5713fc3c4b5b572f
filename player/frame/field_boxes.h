#pragma once
// Makes the boxes of a composed asset's fields, and the spheres that an asset casts by, lines that can be drawn. It
// uses no GL.
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"
#include "player/frame/shape.h"

namespace penumbra {

// An edge of a box, or a piece of a circle, in the model frame.
struct BoxEdge {
    Vec3 from, to;
    std::size_t part = 0;
    bool fine = true;  // true: the fine box; false: the coarse one
};

// Returns the 12 edges of the fine and of the coarse box of some parts, moved by the part's bone as the field is.
std::vector<BoxEdge> fieldBoxEdges(const CompositionView& composition, std::span<const Affine> bones,
                                   std::span<const std::size_t> parts);

// Returns three circles of each sphere, around the axes of the model frame. `part` is the joint.
std::vector<BoxEdge> sphereEdges(const BlockersView& blockers, std::span<const Affine> bones);

// Makes each edge a ribbon that faces the eye and looks as wide anywhere, wider for the fine boxes. Its values have x =
// the part, as Channel::kParts takes it. The same number of edges gives the same triangles.
Shape edgeRibbons(std::span<const BoxEdge> edges, Vec3 eye);

}  // namespace penumbra
