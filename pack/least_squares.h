#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace penumbra {

// The span of K vectors of `length` floats. Directions that repeat others (to 1e-9 of their own length) do not count.
// Eigen's decompositions change the errors that `penumbra-pack check` reports by up to 1e-12 of their size.
class SpanProjector {
public:
    SpanProjector(std::vector<float> basis, std::size_t length);  // [K, length]

    // Squared distance of (point - origin) from the span; double sums.
    double squaredDistance(std::span<const float> point, std::span<const float> origin) const;

    // Writes the point of origin + span that is nearest to `point`.
    void project(std::span<const float> point, std::span<const float> origin, std::span<float> out) const;

private:
    std::vector<float> basis_;
    std::size_t length_;
    // Rows of the inverse Cholesky factor of the Gram matrix, so that row k of factor . basis is orthonormal; a row of
    // zeros for a direction that repeats others.
    std::vector<double> factor_;  // [K, K], lower

    // Coordinates of (point - origin) along the orthonormal rows; `difference` is resized to what they are taken of.
    std::vector<double> coordinates(std::span<const float> point, std::span<const float> origin,
                                    std::vector<float>& difference) const;
};

}  // namespace penumbra
