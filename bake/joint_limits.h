#pragma once
// How far each joint turns: ranges of the rotation vectors of /frames/pose (rig_file.h, RigPose::pose).
#include <filesystem>
#include <span>
#include <vector>

#include "formats/rig/rig_poses.h"

namespace penumbra {

struct JointLimits {
    std::vector<double> low, high;  // [3J] radians, low <= high; x, y, z of each joint
};

// The 1st and 99th percentile of every component over `frames`: a single bad key does not widen them. Zero for joints
// without parent joint (the pose of the whole) and for those that cannot turn or share the node of an earlier one.
JointLimits limitsOfFrames(const Rig& rig, std::span<const RigFrame> frames, int threads);

// Replaces limits by those of a CSV file: a line "joint,axis,min,max" first, then one row an axis of a joint (x, y or
// z, degrees, -180..180, min <= max). Empty lines and lines that start with # are passed over. IoError, InvalidInput
// with the number of the line.
void applyLimitsFile(const std::filesystem::path& path, const Rig& rig, JointLimits& limits);

}  // namespace penumbra
