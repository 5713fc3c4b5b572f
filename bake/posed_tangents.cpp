#include "bake/posed_tangents.h"

#include <cmath>

#include "formats/errors.h"

namespace penumbra {

// `wanted` made orthogonal to the unit normal; where nothing is left, the coordinate axis least along the normal.
static Vec3 tangentOf(Vec3 normal, Vec3 wanted) {
    const Vec3 tangent = wanted - normal * dot(normal, wanted);
    if (dot(tangent, tangent) > 1e-12f) return normalized(tangent);
    const Vec3 a{std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)};
    const Vec3 axis = a.x <= a.y && a.x <= a.z ? Vec3{1, 0, 0} : a.y <= a.z ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
    return normalized(axis - normal * dot(normal, axis));
}

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
