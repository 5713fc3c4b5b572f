#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

namespace penumbra {

// The span of K vectors of `length` floats. Directions that repeat others to 3e-5 of their own length do not count.
class SpanProjector {
public:
    SpanProjector(const std::vector<float>& basis, std::size_t length);  // [K, length]

    // Squared distance of (point - origin) from the span; double sums.
    double squaredDistance(std::span<const float> point, std::span<const float> origin) const;

    // Writes the point of origin + span that is nearest to `point`.
    void project(std::span<const float> point, std::span<const float> origin, std::span<float> out) const;

private:
    Eigen::MatrixXd axes_;  // [length, rank], orthonormal columns
};

}  // namespace penumbra
