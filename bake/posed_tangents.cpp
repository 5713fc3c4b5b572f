#include "bake/posed_tangents.h"

#include "formats/errors.h"
#include "sh/tangent.h"

namespace penumbra {

PosedTangents posedTangents(const Model& model, const Mesh& mesh, const VisibilityFrame& frame,
                            const std::string& name) {
    if (model.mesh.rest_positions != mesh.rest_positions || model.mesh.triangles != mesh.triangles)
        throw InvalidInput(name + ": /mesh is not the mesh of the frames");
    if (model.skin.jointCount() != frame.bones.size())
        throw InvalidInput(name + ": /skin has " + std::to_string(model.skin.jointCount()) +
                           " joints, the frames have " + std::to_string(frame.bones.size()));
    std::vector<Mat3> rotations;
    for (const Affine& bone : frame.bones) rotations.push_back(nearestRotation(bone.linear()));
    PosedTangents posed{{}, model.cluster_of_vertex};
    for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
        const ClusterModel& cluster = model.clusters[model.cluster_of_vertex[v]];
        posed.tangents.push_back(
            tangentOf(frame.normals[v], rotations[std::size_t(cluster.joint)] * model.rest_tangents[v]));
    }
    return posed;
}

}  // namespace penumbra
