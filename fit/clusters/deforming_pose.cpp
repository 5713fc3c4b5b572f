#include "fit/clusters/deforming_pose.h"

#include <cassert>

#include "sh/dihedral_angles.h"
#include "sh/rigid_fit.h"

namespace penumbra {

namespace {

// Tells whether columns c, c + 1 and c + 2 are NAME.x, NAME.y and NAME.z.
bool isPoint(const std::vector<std::string>& names, std::size_t c) {
    if (c + 2 >= names.size() || names[c].size() < 3 || !names[c].ends_with(".x")) return false;
    const std::string stem = names[c].substr(0, names[c].size() - 1);
    return names[c + 1] == stem + "y" && names[c + 2] == stem + "z";
}

}  // namespace

std::vector<InputJoint> inputJoints(const std::vector<std::string>& names, std::size_t first_joint) {
    std::vector<InputJoint> joints;
    for (std::size_t c = 0; c < names.size(); c += joints.back().columns)
        joints.push_back(
            {std::uint32_t(first_joint + joints.size()), std::uint32_t(c), isPoint(names, c) ? 3u : 1u, 0, 1});
    return joints;
}

std::vector<std::string> inputJointNames(const std::vector<std::string>& names, const std::vector<InputJoint>& joints) {
    std::vector<std::string> out;
    for (const InputJoint& joint : joints) {
        const std::string& name = names[joint.column];
        out.push_back(joint.absolute() ? name : name.substr(0, name.size() - 2));
    }
    return out;
}

std::vector<Affine> partBones(const Mesh& mesh, const Skin& skin, std::size_t parts, std::span<const Vec3> positions) {
    const std::size_t fronts = mesh.frontVertexCount();
    assert(positions.size() == fronts && skin.influences == 1);
    std::vector<PartSums> sums(parts);
    std::vector<Affine> bones(parts);
    partMotions(std::span(mesh.rest_positions).first(fronts), std::span(skin.joints).first(fronts), positions, sums,
                bones);
    return bones;
}

void appendInputBones(std::span<const InputJoint> joints, std::span<const Vec3> joint_centers,
                      std::span<const float> inputs, std::vector<Affine>& bones) {
    for (const InputJoint& joint : joints) {
        assert(bones.size() == joint.joint);
        const float* x = inputs.data() + joint.column;
        bones.push_back(joint.absolute() ? numberBone(x[0], joint.offset, joint.scale)
                                         : pointBone({x[0], x[1], x[2]}, joint_centers[joint.joint]));
    }
}

std::vector<float> reducedAngles(std::span<const float> mean, std::span<const float> basis,
                                 std::span<const float> angles) {
    assert(mean.size() == angles.size());
    std::vector<float> centered(angles.size()), out;
    // 1. Turn the angles towards their means.
    for (std::size_t e = 0; e < angles.size(); ++e)
        centered[e] = addTurns(angles[e], turnsTowards(mean[e], angles[e])) - mean[e];
    // 2. Project on the rows of the basis.
    for (std::size_t row = 0; row < basis.size(); row += angles.size()) {
        double sum = 0;
        for (std::size_t e = 0; e < angles.size(); ++e) sum += double(basis[row + e]) * double(centered[e]);
        out.push_back(float(sum));
    }
    return out;
}

}  // namespace penumbra
