#pragma once
// Finds the numbers of a camera from pictures of a flat grid whose points are known (Zhang 2000).
#include <array>
#include <span>
#include <string>
#include <vector>

#include "formats/camera/tag_pose.h"
#include "sh/pinhole_camera.h"

namespace penumbra {

struct GridShot {
    std::string file;               // for messages
    std::vector<SeenPoint> points;  // on the plane z = 0; at least 8
};

struct SolvedCamera {
    PinholeCamera camera;
    std::vector<CameraPose> poses;  // [shot]
    std::vector<double> residuals;  // [shot] rms distance of the points, pixels
    double residual = 0;            // the same over all shots
    std::size_t points = 0;         // points that count
    std::size_t strays = 0;         // left out, because they are far off
    // Standard deviations of f, cx, cy (pixels), k1 and k2 that follow from the residual.
    std::array<double, 5> deviations{};
    double coverage = 0;  // share of 8 x 6 fields of the picture that show a point, 0..1
    double tilt = 0;      // largest angle between the grid and the picture, degrees
};

// Returns f, cx, cy, k1 and k2 that put all points where they are seen: least squares over camera and poses, in which a
// point that is off by more than a pixel counts less, and one far beyond the others not at all. Throws InvalidInput,
// with the name of a shot's file, where pictures do not tell a camera: no shot, all without tilt, or no camera fits.
SolvedCamera solveCamera(int width, int height, std::span<const GridShot> shots);

}  // namespace penumbra
