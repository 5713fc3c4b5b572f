#pragma once
// Tells how far each joint turns: the ranges of the rotation vectors of /frames/pose (rig_file.h, RigPose::pose).
#include <filesystem>
#include <span>
#include <vector>

#include "formats/rig/rig_poses.h"

namespace penumbra {

struct JointLimits {
    std::vector<double> low, high;  // [3J] radians, low <= high; x, y, z of each joint in turn
};

// Returns the 1st and the 99th percentile of every component over `frames`, so that a single bad key does not widen a
// range. Ranges are zero for joints without a parent joint (these pose the whole) and for joints that cannot turn or
// that share the node of an earlier one.
JointLimits limitsOfFrames(const Rig& rig, std::span<const RigFrame> frames, int threads);

// Returns limits for a rig without clips: joints below a root that move vertices turn by up to kFreeTurn / sqrt(d)
// about each axis, but at least kMinFreeTurn. d is the number of joints on the way from the root (1 for its
// children).
constexpr double kFreeTurn = 30, kMinFreeTurn = 10;  // degrees
JointLimits limitsWithoutClips(const Rig& rig);

// Replaces limits by those of a CSV file. Its first line is "joint,axis,min,max". Each further line is an axis of a
// joint (x, y or z; degrees, -180..180, min <= max). Empty lines and lines that start with # are passed over. Throws
// IoError, and InvalidInput with the number of the line.
void applyLimitsFile(const std::filesystem::path& path, const Rig& rig, JointLimits& limits);

}  // namespace penumbra
