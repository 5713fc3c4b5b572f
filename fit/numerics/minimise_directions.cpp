#include "fit/numerics/minimise_directions.h"

#include <cmath>

#include "fit/numerics/quasi_newton.h"

namespace penumbra {

namespace {

struct Tangents {
    Vec3d a, b;
};

// Returns two unit vectors that are orthogonal to s and to each other.
Tangents tangentsOf(Vec3d s) {
    const Vec3d axis = std::abs(s.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
    const Vec3d a = normalized(cross(s, axis));
    return {a, cross(s, a)};
}

// Coordinates in the tangent planes of some directions. Direction d is the normalised s_d + x_2d a_d + x_2d+1 b_d.
class TangentPlanes {
public:
    explicit TangentPlanes(std::span<const Vec3d> start) : start_(start) {
        for (Vec3d s : start_) tangents_.push_back(tangentsOf(s));
    }

    std::vector<Vec3d> at(std::span<const double> x) const {
        std::vector<Vec3d> directions;
        for (std::size_t d = 0; d < start_.size(); ++d) directions.push_back(normalized(unscaled(d, x)));
        return directions;
    }
    // The gradient by x of what has the gradient `slopes` by the directions. Each is orthogonal to its direction, so
    // the normalisation only divides it by the length.
    void gradient(std::span<const double> x, std::span<const Vec3d> slopes, std::span<double> out) const {
        for (std::size_t d = 0; d < start_.size(); ++d) {
            const double distance = length(unscaled(d, x));
            out[2 * d] = dot(slopes[d], tangents_[d].a) / distance;
            out[2 * d + 1] = dot(slopes[d], tangents_[d].b) / distance;
        }
    }

private:
    Vec3d unscaled(std::size_t d, std::span<const double> x) const {
        return start_[d] + x[2 * d] * tangents_[d].a + x[2 * d + 1] * tangents_[d].b;
    }
    std::span<const Vec3d> start_;
    std::vector<Tangents> tangents_;
};

// Runs one search in the tangent planes of `start`.
DirectionMinimum descend(const DirectionObjective& objective, std::span<const Vec3d> start) {
    const TangentPlanes planes(start);
    std::vector<Vec3d> slopes(start.size());
    std::vector<double> x(2 * start.size(), 0.0);
    const SearchResult found = minimise(
        [&](std::span<const double> at, std::span<double> gradient) {
            const double value = objective(planes.at(at), slopes);
            planes.gradient(at, slopes, gradient);
            return value;
        },
        {.method = QuasiNewton::kBfgs,
         .iterations = 200,
         .least_decrease = 1e-11,
         .window = 1,
         .least_gradient = 1e-10},
        x);
    return {planes.at(x), found.value};
}

}  // namespace

DirectionMinimum minimiseOverDirections(const DirectionObjective& objective, std::span<const Vec3d> start) {
    DirectionMinimum best = descend(objective, start);
    // Begin again where the last search ended, because tangent planes far from their points bend the objective.
    for (int again = 0; again < 2; ++again) {
        DirectionMinimum next = descend(objective, best.directions);
        if (!(next.value < best.value)) break;
        const bool same = best.value - next.value < 1e-10 * best.value;
        best = std::move(next);
        if (same) break;
    }
    return best;
}

}  // namespace penumbra
