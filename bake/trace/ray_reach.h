#pragma once
// How far rays look for occluders (--distance).
//
// An occluder at the distance d counts by w(d) = 1 - smoothstep(d / D): fully where it touches, half at D / 2, and not
// at all from D on. Rays either escape or do not, so each ray gets an end of its own, drawn so that the share of rays
// that reach beyond d is w(d). Then the expected share of the rays that a surface at d blocks is w(d).
#include <array>
#include <cmath>
#include <cstdint>

#include "bake/trace/ray_directions.h"

namespace penumbra {

class RayReach {
public:
    // `distance` is D, above 0, in the unit of the result.
    explicit RayReach(float distance) {
        // 3 x^2 - 2 x^3 = u has the solution x = 1/2 - sin(asin(1 - 2 u) / 3) in [0, 1].
        for (std::size_t i = 0; i < ends_.size(); ++i) {
            const double u = (double(i) + 0.5) / double(ends_.size());
            ends_[i] = float(double(distance) * (0.5 - std::sin(std::asin(1 - 2 * u) / 3)));
        }
    }

    // Returns where the rays of a packet end for a point. Ray r of point p takes quantile frac(hash(p) + r / golden
    // ratio), so that rays that lie near one another have ends of all lengths.
    LaneWeights of(std::size_t packet, std::uint32_t point) const {
        constexpr std::uint32_t kGolden = 2654435769u;  // 2^32 / golden ratio
        const std::uint32_t start = hashOf(point);
        LaneWeights reach;
        for (std::uint32_t k = 0; k < kLanes; ++k)
            reach.lane[k] = ends_[(start + (std::uint32_t(packet) * kLanes + k) * kGolden) >> (32 - kBits)];
        return reach;
    }

private:
    static constexpr unsigned kBits = 10;
    std::array<float, 1u << kBits> ends_;

    // The finalizer of MurmurHash3 (public domain, A. Appleby): every bit of the number changes all of the result.
    static std::uint32_t hashOf(std::uint32_t x) {
        x ^= x >> 16;
        x *= 0x85ebca6bu;
        x ^= x >> 13;
        x *= 0xc2b2ae35u;
        return x ^ (x >> 16);
    }
};

}  // namespace penumbra
