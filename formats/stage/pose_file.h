#pragma once
// x.poses.h5: a list of poses of a rig (HDF5, format "penumbra.poses"; formats/README.md lists every
// dataset). It holds frames of the rig's clips, poses given by joint rotations, which form the clip "sampled", and
// poses given by the transforms of all nodes, which form the clip "mixed".
#include <filesystem>
#include <string>
#include <vector>

#include "formats/common/file_format.h"
#include "formats/common/mesh.h"
#include "formats/common/provenance.h"

namespace penumbra {

constexpr FileFormat kPosesFormat{"penumbra.poses", 1};
constexpr const char* kSampledClip = "sampled";
constexpr const char* kMixedClip = "mixed";
// A node's transform to its parent: translation, unit quaternion x y z w, scale.
constexpr std::size_t kMixedValues = 10;

struct PoseFile {
    // Every clip name is used. In "sampled" the frame at k seconds is row k of `rotations`, and in "mixed" of `mixed`.
    FrameList frames;
    // [F] the order of choice, a permutation of 0..F-1: the frames of rank < N are the best N. Sampled and mixed
    // poses come last.
    std::vector<std::uint32_t> rank;
    // [F] >= 0, to the nearest frame of lower rank when it was chosen; 0 for sampled and mixed poses
    std::vector<double> distance;
    std::vector<std::string> joint_names;  // [J], unique; those of the rig
    std::vector<float> rotations;          // [M,3J] joint rotation vectors (rig_file.h), radians
    std::vector<std::string> node_names;   // [N] of all nodes of the rig; empty without mixed poses
    std::vector<float> mixed;              // [X,N,kMixedValues]
    // Of a rig with morph targets that has sampled or mixed poses: their names [W], and the weights of these poses.
    std::vector<std::string> weight_names;
    std::vector<float> sampled_weights, mixed_weights;  // [M,W], [X,W]
    Provenance provenance;

    std::size_t sampledCount() const { return joint_names.empty() ? 0 : rotations.size() / (3 * joint_names.size()); }
    std::size_t mixedCount() const {
        return node_names.empty() ? 0 : mixed.size() / (kMixedValues * node_names.size());
    }
};

void writePoseFile(const std::filesystem::path& path, const PoseFile& poses);
PoseFile readPoseFile(const std::filesystem::path& path);  // throws IoError, InvalidInput and Unsupported

// Two times of one clip count as the same frame when they are at most this many seconds apart.
constexpr double kSameTime = 1e-6;

}  // namespace penumbra
