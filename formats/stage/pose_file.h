#pragma once
// x.poses.h5: a list of poses of a rig (HDF5, format "penumbra.poses", version 1; formats/README.md lists every
// dataset). It holds frames of the rig's clips, and poses given by joint rotations, which form the clip "sampled".
#include <filesystem>
#include <string>
#include <vector>

#include "formats/common/mesh.h"
#include "formats/common/provenance.h"

namespace penumbra {

constexpr int kPosesVersion = 1;
constexpr const char* kSampledClip = "sampled";

struct PoseFile {
    FrameList frames;  // every clip name is used; in "sampled" the frame at k seconds is row k of `rotations`
    // [F] the order of choice, a permutation of 0..F-1: the frames of rank < N are the best N. Sampled poses come
    // last.
    std::vector<std::uint32_t> rank;
    // [F] >= 0, to the nearest frame of lower rank when it was chosen; 0 for sampled poses
    std::vector<double> distance;
    std::vector<std::string> joint_names;  // [J], unique; those of the rig
    std::vector<float> rotations;          // [M,3J] joint rotation vectors (rig_file.h), radians
    Provenance provenance;

    std::size_t sampledCount() const { return joint_names.empty() ? 0 : rotations.size() / (3 * joint_names.size()); }
};

void writePoseFile(const std::filesystem::path& path, const PoseFile& poses);
PoseFile readPoseFile(const std::filesystem::path& path);  // throws IoError, InvalidInput and Unsupported

// Two times of one clip count as the same frame when they are at most this many seconds apart.
constexpr double kSameTime = 1e-6;

}  // namespace penumbra
