#pragma once
// Joins two tracks of one camera that stand in two frames of reference: a marker's, which has metres, and that of a
// tracker without markers (or of another marker), which has any scale.
#include <span>
#include <vector>

#include "formats/camera/camera_file.h"

namespace penumbra {

// From frame a to frame b: x_b = scale rotation x_a + origin.
struct FrameMap {
    double scale = 1;
    Mat3d rotation;
    Vec3d origin;
};

// One picture in both tracks.
struct PosePair {
    CameraPose a, b;
};

struct AlignedFrames {
    FrameMap map;
    // How far the mapped poses of b are off those of a, rms over the pictures: camera's place in units of a, turn in
    // degrees.
    double place_rms = 0, turn_rms = 0;
    // Largest angle between two cameras as seen from the middle of what they look at (a's origin), degrees.
    double spread = 0;
};

// Least squares over all pictures. Throws InvalidInput (without a name) for fewer than two pictures, and where all
// cameras stand at one place, which tells no scale.
AlignedFrames alignFrames(std::span<const PosePair> pairs);

// Returns a pose of frame b in frame a: of the same camera, with a's lengths.
CameraPose poseInA(const FrameMap& map, const CameraPose& b);

// Largest angle between the places of two cameras as seen from the origin of a, degrees.
double spreadOf(std::span<const PosePair> pairs);

// Pairs the frames of two tracks that have a pose in both: by the name of their file without folders or, where neither
// track has names, by their number. Each has the number of its frame in `a` and in `b`. Throws InvalidInput where one
// track has two frames of one name.
struct FramePair {
    std::size_t a = 0, b = 0;
};
std::vector<FramePair> pairFrames(const CameraTrack& a, const CameraTrack& b);

}  // namespace penumbra
