#pragma once
// Which rays are traced once more for local moments, and how far (occlusion_embree.cpp).
#include <algorithm>
#include <array>
#include <cmath>

#include "bake/trace/occlusion.h"

namespace penumbra {

// Returns how far local triangles may lie along each lane of a packet: up to where the ray leaves the last box of a
// local part, and 0 where it meets none of these boxes.
inline LaneWeights localReach(Vec3 origin, const DirectionPacket& directions, const LocalTriangles& local) {
    constexpr float kMin = 1e-20f;     // no division by 0
    constexpr float kPadding = 1e-5f;  // in diagonals of the model; rounding in a hit is a hundredth of that
    LaneWeights reach;
    DirectionPacket inverse;
    const auto invert = [](const std::array<float, kLanes>& from, std::array<float, kLanes>& to) {
        for (std::size_t k = 0; k < kLanes; ++k) to[k] = 1 / (std::abs(from[k]) < kMin ? kMin : from[k]);
    };
    invert(directions.x, inverse.x);
    invert(directions.y, inverse.y);
    invert(directions.z, inverse.z);
    for (std::size_t part = 0; part < local.box_of_part.size(); ++part) {
        if (!local.is_local[part]) continue;
        const BoundingBox& box = local.box_of_part[part];
        const Vec3 low = box.low - origin - Vec3{kPadding, kPadding, kPadding};
        const Vec3 high = box.high - origin + Vec3{kPadding, kPadding, kPadding};
        for (std::size_t k = 0; k < kLanes; ++k) {
            const float x0 = low.x * inverse.x[k], x1 = high.x * inverse.x[k];
            const float y0 = low.y * inverse.y[k], y1 = high.y * inverse.y[k];
            const float z0 = low.z * inverse.z[k], z1 = high.z * inverse.z[k];
            const float enter = std::max({std::min(x0, x1), std::min(y0, y1), std::min(z0, z1)});
            const float leave = std::min({std::max(x0, x1), std::max(y0, y1), std::max(z0, z1)});
            reach.lane[k] = enter <= leave ? std::max(reach.lane[k], leave) : reach.lane[k];
        }
    }
    return reach;
}

// Rays of several packets that wait for their second trace. Neighbours along the Morton curve share a packet again.
struct WaitingRays {
    DirectionPacket directions;
    LaneWeights reach;
    std::array<float*, kLanes> weight{};  // where the answer of each lane goes
    std::size_t count = 0;

    void add(const DirectionPacket& from, std::size_t lane, float how_far, float& answer) {
        directions.x[count] = from.x[lane];
        directions.y[count] = from.y[lane];
        directions.z[count] = from.z[lane];
        reach.lane[count] = how_far;
        weight[count++] = &answer;
    }
};

}  // namespace penumbra
