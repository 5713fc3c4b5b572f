#pragma once
// From a bake's model-frame moments to the numbers of a convention in the vertices' local frames, frame by frame.
#include <functional>
#include <span>
#include <vector>

#include "fit/matrix.h"
#include "formats/visibility_file.h"
#include "sh/visibility_convention.h"

namespace penumbra {

// The pose of every frame, and what follows from it.
struct PoseTable {
    std::size_t joints = 0, pose_size = 0;
    std::vector<Affine> bones;    // [F, J]
    std::vector<Mat3> rotations;  // [F, J] nearestRotation of the bones' linear parts
    std::vector<float> pose;      // [F, P]

    std::size_t frameCount() const { return joints ? bones.size() / joints : 0; }
    std::span<const Affine> bonesOf(std::size_t f) const { return std::span(bones).subspan(f * joints, joints); }
    std::span<const Mat3> rotationsOf(std::size_t f) const { return std::span(rotations).subspan(f * joints, joints); }
    std::span<const float> poseOf(std::size_t f) const { return std::span(pose).subspan(f * pose_size, pose_size); }
};
PoseTable readPoses(const VisibilityReader& reader, int threads);

// Where each vertex' local frame comes from.
struct LocalFrames {
    const std::vector<Vec3>* rest_tangents = nullptr;               // [V]
    const std::vector<std::uint32_t>* cluster_of_vertex = nullptr;  // [V]
    std::span<const int> joint_of_cluster;
};

// Numbers of the asked clusters in all frames: result[i] is [F, Vc n] with the vertices as in vertices_of_cluster[i].
// One pass over the file in vertex ranges, reading only ranges that hold a vertex of these clusters; beside the result
// it needs about 32 MB.
struct ClusterNumbersRequest {
    Convention convention;
    LocalFrames frames;
    std::span<const std::vector<std::uint32_t>> vertices_of_cluster;
    int threads = 0;
    std::function<void(std::size_t)> vertices_done;  // how many more of the asked vertices are there; may be empty
};
std::vector<MatrixF> readClusterNumbers(const VisibilityReader& reader, const PoseTable& poses,
                                        const ClusterNumbersRequest& request);

}  // namespace penumbra
