#pragma once
// x.poses.h5: a list of poses of a rig (HDF5, format "penumbra.poses", version 1; README.md lists every dataset):
// frames of its clips, and poses given by joint rotations, which form the clip "sampled".
#include <filesystem>
#include <string>
#include <vector>

#include "formats/common/mesh.h"
#include "formats/common/provenance.h"

namespace penumbra {

constexpr int kPosesVersion = 1;
constexpr const char* kSampledClip = "sampled";

struct PoseFile {
    FrameList frames;  // every clip name is used; of "sampled" the frame at k seconds is row k of `rotations`
    // [F] a permutation of 0..F-1, the order of choice: the frames of rank < N are the best N. Sampled poses come last.
    std::vector<std::uint32_t> rank;
    std::vector<double> distance;  // [F] >= 0, to the nearest frame of lower rank when chosen; 0 for sampled ones
    std::vector<std::string> joint_names;  // [J], of the rig; unique
    std::vector<float> rotations;          // [M,3J] joint rotation vectors (rig_file.h), radians
    Provenance provenance;

    std::size_t sampledCount() const { return joint_names.empty() ? 0 : rotations.size() / (3 * joint_names.size()); }
};

void writePoseFile(const std::filesystem::path& path, const PoseFile& poses);
PoseFile readPoseFile(const std::filesystem::path& path);  // IoError, InvalidInput, Unsupported

// Two times of one clip that count as the same frame are at most this far apart, in seconds.
constexpr double kSameTime = 1e-6;

}  // namespace penumbra
