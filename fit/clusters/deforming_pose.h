#pragma once
// Turns a frame's positions, angles and inputs into what a model sees of it: bones and a pose
// (formats/stage/model_file.h). The run time does the same with the same functions of sh/.
#include <span>
#include <vector>

#include "formats/stage/model_file.h"

namespace penumbra {

// Returns the joints that stand for inputs: one for each three columns NAME.x, NAME.y, NAME.z in this order (a point)
// and one for each other column. The first has the number `first_joint`. Offsets are 0 and scales 1 until the caller
// sets them.
std::vector<InputJoint> inputJoints(const std::vector<std::string>& names, std::size_t first_joint);
// Returns the names of these joints: NAME for a point, the column's name for a number.
std::vector<std::string> inputJointNames(const std::vector<std::string>& names, const std::vector<InputJoint>& joints);

// Returns the bones of the first `parts` joints of a deforming mesh whose fronts are at `positions` [Vs].
std::vector<Affine> partBones(const Mesh& mesh, const Skin& skin, std::size_t parts, std::span<const Vec3> positions);
// Appends the bones of the input joints; `inputs` is [X], `joint_centers` is [J].
void appendInputBones(std::span<const InputJoint> joints, std::span<const Vec3> joint_centers,
                      std::span<const float> inputs, std::vector<Affine>& bones);

// Returns basis (angles - mean), [N], where each angle is first turned to within pi of its mean. `basis` is [N, E].
std::vector<float> reducedAngles(std::span<const float> mean, std::span<const float> basis,
                                 std::span<const float> angles);

}  // namespace penumbra
