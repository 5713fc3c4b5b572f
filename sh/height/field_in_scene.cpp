#include "sh/height/field_in_scene.h"

#include <algorithm>
#include <limits>

#include "sh/bounding_box.h"

namespace penumbra {

double heightOfField(const HeightField& field, Vec3d corner, double x, double z) {
    return corner.y + field.onTriangles((z - corner.z) / double(field.grid().cell_x),
                                        (x - corner.x) / double(field.grid().cell_y));
}

// A smaller share holds the planted foot closer to the ground, and moves the body faster between two steps. On dunes a
// walk is best between the two extremes (tests/bench/results/NOTES.md).
double groundUnderPose(const HeightField& field, Vec3d corner, std::span<const Vec3> pose, const Affine& to_scene) {
    const Vec3d place = toDouble(to_scene.translation());
    if (pose.empty()) return heightOfField(field, corner, place.x, place.z);
    const Mat3 turn = to_scene.linear();
    float lowest = std::numeric_limits<float>::infinity();
    for (const Vec3 p : pose) lowest = std::min(lowest, (turn * p).y);
    const float reach = kStandingShare * 2 * boundsOf(pose).radius();
    double sum = 0, weights = 0;
    for (const Vec3 p : pose) {
        const Vec3 at = turn * p;
        const float h = at.y - lowest;
        if (h > 0 && h >= reach) continue;
        const double left = h > 0 ? double(1 - h / reach) : 1.0, weight = left * left;
        sum += weight * heightOfField(field, corner, place.x + double(at.x), place.z + double(at.z));
        weights += weight;
    }
    return sum / weights;
}

}  // namespace penumbra
