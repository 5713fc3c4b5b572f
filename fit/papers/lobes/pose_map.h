#pragma once
// Linear maps from the joint angles of a pose, as a file of lobes has them.
#include <span>
#include <vector>

#include "fit/clusters/pose_table.h"
#include "fit/numerics/matrix.h"

namespace penumbra {

// The principal components of the joint angles of training frames.
struct PoseComponents {
    std::vector<float> mean;   // [P]
    std::vector<float> basis;  // [I, P]

    std::size_t count() const { return mean.empty() ? 0 : basis.size() / mean.size(); }
    std::vector<double> of(std::span<const float> pose) const;  // [I]
};
// Keeps `share` of the variance, in (0, 1].
PoseComponents poseComponents(const PoseTable& poses, std::span<const std::size_t> train, double share);
// Returns the components of all frames, [F, I].
Matrix componentsOfFrames(const PoseComponents& components, const PoseTable& poses);

// Fits a map from the inputs of the training frames to their outputs, [I + 1, K], by ridge regression. Its last row is
// the bias. Both matrices have all frames.
std::vector<float> fitPoseMap(const Matrix& inputs, const Matrix& outputs, std::span<const std::size_t> train);
// Writes (inputs, 1) map.
void applyPoseMap(std::span<const float> map, std::span<const double> inputs, std::span<double> out);

}  // namespace penumbra
