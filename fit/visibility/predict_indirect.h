#pragma once
// Predicts the indirect transfer of a pose.
#include <span>
#include <vector>

#include "formats/stage/model_file.h"

namespace penumbra {

// Returns the indirect transfer of bands 0..2 in one pose, [V, 3, kIndirectCoefficients] in the model frame, as bakes
// have it. The model must have light that bounces. Takes the bones [J] and the pose [P] that the model sees, and the
// normals [V].
std::vector<float> predictIndirect(const Model& model, std::span<const Affine> bones, std::span<const float> pose,
                                   std::span<const Vec3> normals, int threads);

}  // namespace penumbra
