#include "bake/reference/posed_tangents.h"

#include "formats/common/errors.h"
#include "sh/rigid_fit.h"
#include "sh/tangent.h"

namespace penumbra {

namespace {

// Returns one bone for each near-rigid part of a deforming mesh, in the order of the fit.
std::vector<Affine> fittedBones(const Model& model, const VisibilityFrame& frame) {
    const std::size_t fronts = model.mesh.frontVertexCount();
    std::vector<PartSums> sums(model.skin.jointCount());
    std::vector<Affine> bones(sums.size());
    partMotions(std::span(model.mesh.rest_positions).first(fronts), std::span(model.skin.joints).first(fronts),
                std::span(frame.positions).first(fronts), sums, bones);
    return bones;
}

}  // namespace

PosedTangents posedTangents(const Model& model, const Mesh& mesh, const VisibilityFrame& frame,
                            const std::string& name) {
    if (model.mesh.rest_positions != mesh.rest_positions || model.mesh.triangles != mesh.triangles)
        throw InvalidInput(name + ": /mesh is not the mesh of the frames");
    const std::vector<Affine> bones = model.deforming ? fittedBones(model, frame) : frame.bones;
    const std::size_t joints = model.skin.jointCount() - (model.deforming ? 0 : model.input_joints.size());
    if (joints != bones.size())
        throw InvalidInput(name + ": /skin has " + std::to_string(joints) + " joints, the frames have " +
                           std::to_string(bones.size()));
    std::vector<Mat3> rotations;
    for (const Affine& bone : bones) rotations.push_back(nearestRotation(bone.linear()));
    PosedTangents posed{{}, model.cluster_of_vertex};
    for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
        const ClusterModel& cluster = model.clusters[model.cluster_of_vertex[v]];
        posed.tangents.push_back(
            tangentOf(frame.normals[v], rotations[std::size_t(cluster.joint)] * model.rest_tangents[v]));
    }
    return posed;
}

}  // namespace penumbra
