#include "sh/rigid_fit.h"

#include <algorithm>
#include <cassert>

namespace penumbra {

namespace {

constexpr double kPrior = 1e-5;  // well above what nearestRotation() loses to float

// Returns the motion of a part from its sums.
Affine motionOf(const PartSums& part) {
    if (part.count == 0) return {};
    Mat3d turned = part.cross;
    for (int i = 0; i < 3; ++i) turned(i, i) += kPrior * part.size;
    double largest = 0;
    for (double x : turned.m) largest = std::max(largest, std::abs(x));
    Mat3 unit;  // within the range of float at any scale of the scene
    for (std::size_t i = 0; i < 9 && largest > 0; ++i) unit.m[i] = float(turned.m[i] / largest);
    const Mat3 rotation = nearestRotation(unit);
    const Vec3d translation = part.position - toDouble(rotation) * part.rest;
    Affine bone;
    for (std::size_t row = 0; row < 3; ++row) {
        std::copy_n(rotation.m.begin() + long(3 * row), 3, bone.m.begin() + long(4 * row));
        bone.m[4 * row + 3] = float(translation[int(row)]);
    }
    return bone;
}

}  // namespace

void partMotions(std::span<const Vec3> rest, std::span<const std::uint16_t> part_of_vertex,
                 std::span<const Vec3> positions, std::span<PartSums> sums, std::span<Affine> bones) {
    assert(rest.size() == positions.size() && part_of_vertex.size() == rest.size() && sums.size() == bones.size());
    // 1. Means at rest and in the pose.
    for (PartSums& part : sums) part = {{}, {}, {{}}, 0, 0};
    for (std::size_t v = 0; v < rest.size(); ++v) {
        PartSums& part = sums[part_of_vertex[v]];
        part.rest += toDouble(rest[v]);
        part.position += toDouble(positions[v]);
        ++part.count;
    }
    for (PartSums& part : sums) {
        part.rest = part.rest / std::max(part.count, 1.0);
        part.position = part.position / std::max(part.count, 1.0);
    }
    // 2. Moments about the means.
    for (std::size_t v = 0; v < rest.size(); ++v) {
        PartSums& part = sums[part_of_vertex[v]];
        const Vec3d r = toDouble(rest[v]) - part.rest, p = toDouble(positions[v]) - part.position;
        part.size += dot(r, r);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) part.cross(i, j) += p[i] * r[j];
    }
    // 3. The nearest rotation of each part.
    for (std::size_t p = 0; p < sums.size(); ++p) bones[p] = motionOf(sums[p]);
}

Affine pointBone(Vec3 point, Vec3 center) {
    const Vec3 way = point - center;
    return {{1, 0, 0, way.x, 0, 1, 0, way.y, 0, 0, 1, way.z}};
}

Affine numberBone(float x, float offset, float scale) {
    return {{1, 0, 0, (x - offset) * scale, 0, 1, 0, 0, 0, 0, 1, 0}};
}

}  // namespace penumbra
