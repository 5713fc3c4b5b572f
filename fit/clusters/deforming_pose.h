#pragma once
// From a frame's positions, angles and inputs to what a model sees of it (formats/stage/model_file.h): bones and pose.
// The run time repeats it with the same functions of sh/.
#include <span>
#include <vector>

#include "formats/stage/model_file.h"

namespace penumbra {

// Joints, one for each three columns NAME.x, NAME.y, NAME.z in this order (a point) and for each other column; the
// first is `first_joint`. Offsets and scales as yet 0 and 1.
std::vector<InputJoint> inputJoints(const std::vector<std::string>& names, std::size_t first_joint);
// Their names: NAME of a point, the column's of a number.
std::vector<std::string> inputJointNames(const std::vector<std::string>& names, const std::vector<InputJoint>& joints);

// Bones of the first `parts` joints of a deforming mesh with the front positions [Vs].
std::vector<Affine> partBones(const Mesh& mesh, const Skin& skin, std::size_t parts, std::span<const Vec3> positions);
// Appends those of the input joints; inputs [X], joint_centers [J].
void appendInputBones(std::span<const InputJoint> joints, std::span<const Vec3> joint_centers,
                      std::span<const float> inputs, std::vector<Affine>& bones);

// basis (angles - mean), each angle turned to within pi of its mean first; basis [N, E].
std::vector<float> reducedAngles(std::span<const float> mean, std::span<const float> basis,
                                 std::span<const float> angles);

}  // namespace penumbra
