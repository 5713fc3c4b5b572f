#pragma once
// Computes the tangents of a fitted model on a baked frame, so that anisotropic materials lie as the run-time
// evaluator lays them.
#include <string>

#include "formats/stage/model_file.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

// Tangents jump across clusters, so a point of a triangle takes those of its nearest corner's cluster.
struct PosedTangents {
    std::vector<Vec3> tangents;                    // [V], unit, model frame, orthogonal to the frame's normals
    std::vector<std::uint32_t> cluster_of_vertex;  // [V]
};
// Computes what the run-time evaluator has: rest tangents, turned by the rotation of the cluster's joint and
// projected on the tangent plane. The joints of a deforming mesh are its parts, fitted to the frame (sh/rigid_fit.h).
// Throws InvalidInput when the model is of another mesh than `mesh`; `name` starts the message.
PosedTangents posedTangents(const Model& model, const Mesh& mesh, const VisibilityFrame& frame,
                            const std::string& name);

}  // namespace penumbra
