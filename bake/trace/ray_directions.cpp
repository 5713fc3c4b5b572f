#include "bake/trace/ray_directions.h"

#include <cassert>
#include <cmath>
#include <numbers>

#include "bake/common/random_numbers.h"
#include "sh/quadrature.h"
#include "sh/quaternion.h"

namespace penumbra {

namespace {

// Draws a rotation uniformly by way of a unit quaternion x y z w (Shoemake 1992, "Uniform random rotations").
Mat3d randomRotation(std::uint64_t seed) {
    const double u = nextUniform(seed), a = 2 * std::numbers::pi * nextUniform(seed),
                 c = 2 * std::numbers::pi * nextUniform(seed);
    const double x = std::sqrt(1 - u) * std::sin(a), y = std::sqrt(1 - u) * std::cos(a);
    const double z = std::sqrt(u) * std::sin(c), w = std::sqrt(u) * std::cos(c);
    return matrixOf({x, y, z, w});
}

}  // namespace

RayDirections makeRayDirections(int rays, std::uint64_t seed, int order) {
    assert(rays > 0 && order >= 1 && order <= kMaxOrder);
    // 1. The set covers the sphere evenly, so that every direction has the same weight 4 pi / count.
    std::vector<Vec3d> directions = fibonacciSphere(2 * rays);
    const Mat3d rotation = seed == 1 ? Mat3d{} : randomRotation(seed);
    for (Vec3d& d : directions) d = rotation * d;
    // 2. Sorted along a Morton curve, the eight rays of a packet point nearly the same way and meet the same boxes of
    // the tree.
    directions = mortonSorted(std::move(directions));

    // 3. Directions go into packets, and the weighted basis into the layout that accumulateMoments() reads front to
    // back.
    RayDirections out{order, 2 * rays, {}, {}};
    const std::size_t packet_count = (directions.size() + kLanes - 1) / kLanes;
    const auto size = std::size_t(coefficientCount(order));
    out.packets.resize(packet_count);
    out.basis.resize(packet_count * size * kLanes);
    const double weight = 4 * std::numbers::pi / double(directions.size());
    std::vector<double> y(size);
    for (std::size_t s = 0; s < directions.size(); ++s) {
        const std::size_t packet = s / kLanes, lane = s % kLanes;
        const Vec3 d = toFloat(directions[s]);
        out.packets[packet].x[lane] = d.x;
        out.packets[packet].y[lane] = d.y;
        out.packets[packet].z[lane] = d.z;
        evalBasis(order, directions[s], y);
        for (std::size_t i = 0; i < size; ++i) out.basis[(packet * size + i) * kLanes + lane] = float(weight * y[i]);
    }
    return out;
}

std::size_t aboveHorizon(const RayDirections& directions, Vec3 normal, Floor floor, std::span<LaneWeights> above) {
    assert(above.size() == directions.packets.size());
    const float lowest_y = floor == Floor::kSolid ? 0.0f : -2.0f;
    float count = 0;
    for (std::size_t p = 0; p < above.size(); ++p) {
        const DirectionPacket& d = directions.packets[p];
        for (std::size_t k = 0; k < kLanes; ++k) {
            const float cosine = d.x[k] * normal.x + d.y[k] * normal.y + d.z[k] * normal.z;
            above[p].lane[k] = float((cosine > 0) & (d.y[k] >= lowest_y));
        }
        for (std::size_t k = 0; k < kLanes; ++k) count += above[p].lane[k];
    }
    return std::size_t(count);  // exact: there are at most 2^21 directions, and a float counts to 2^24
}

namespace {

template <std::size_t kSize>
void accumulate(const RayDirections& directions, std::span<const LaneWeights> visible, std::span<float> b) {
    // Eight partial sums for each number keep the inner loop free of dependencies, so that compilers vectorise it.
    alignas(32) float sum[kSize][kLanes] = {};
    const float* basis = directions.basis.data();
    for (std::size_t p = 0; p < visible.size(); ++p, basis += kSize * kLanes) {
        const std::array<float, kLanes> v = visible[p].lane;
        if (v == std::array<float, kLanes>{}) continue;  // most packets of an occluded vertex are dark
        for (std::size_t i = 0; i < kSize; ++i)
            for (std::size_t k = 0; k < kLanes; ++k) sum[i][k] += v[k] * basis[i * kLanes + k];
    }
    // Eight lanes are added in double, always in the same order.
    for (std::size_t i = 0; i < kSize; ++i) {
        double total = 0;
        for (std::size_t k = 0; k < kLanes; ++k) total += double(sum[i][k]);
        b[i] = float(total);
    }
}

}  // namespace

void accumulateMoments(const RayDirections& directions, std::span<const LaneWeights> visible, std::span<float> b) {
    assert(visible.size() == directions.packets.size() && int(b.size()) == coefficientCount(directions.order));
    static_assert(kMaxOrder == 8);
    using Kernel = void (*)(const RayDirections&, std::span<const LaneWeights>, std::span<float>);
    constexpr Kernel kernel_of_order[] = {accumulate<1>,  accumulate<4>,  accumulate<9>,  accumulate<16>,
                                          accumulate<25>, accumulate<36>, accumulate<49>, accumulate<64>};
    kernel_of_order[directions.order - 1](directions, visible, b);
}

}  // namespace penumbra
