#include "fit/numerics/minimise_directions.h"

#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>
#include <glog/logging.h>

#include <cmath>

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

// The objective as a function of coordinates in the tangent planes. Direction d is the normalised s_d + x_2d a_d +
// x_2d+1 b_d.
class TangentPlanes : public ceres::FirstOrderFunction {
public:
    TangentPlanes(const DirectionObjective& objective, std::span<const Vec3d> start)
        : objective_(objective), start_(start.begin(), start.end()) {
        for (Vec3d s : start_) tangents_.push_back(tangentsOf(s));
    }

    std::vector<Vec3d> at(const double* x) const {
        std::vector<Vec3d> directions;
        for (std::size_t d = 0; d < start_.size(); ++d) directions.push_back(normalized(unscaled(d, x)));
        return directions;
    }
    bool Evaluate(const double* x, double* cost, double* gradient) const override {
        std::vector<Vec3d> slopes(start_.size());
        *cost = objective_(at(x), slopes);
        // The gradient is orthogonal to the direction, so the normalisation only divides it by the length.
        if (gradient)
            for (std::size_t d = 0; d < start_.size(); ++d) {
                const double distance = length(unscaled(d, x));
                gradient[2 * d] = dot(slopes[d], tangents_[d].a) / distance;
                gradient[2 * d + 1] = dot(slopes[d], tangents_[d].b) / distance;
            }
        return std::isfinite(*cost);
    }
    int NumParameters() const override { return 2 * int(start_.size()); }

private:
    Vec3d unscaled(std::size_t d, const double* x) const {
        return start_[d] + x[2 * d] * tangents_[d].a + x[2 * d + 1] * tangents_[d].b;
    }
    const DirectionObjective& objective_;
    std::vector<Vec3d> start_;
    std::vector<Tangents> tangents_;
};

// Runs one search in the tangent planes of `start`.
DirectionMinimum descend(const DirectionObjective& objective, std::span<const Vec3d> start) {
    const auto planes = new TangentPlanes(objective, start);  // the problem owns it
    ceres::GradientProblem problem(planes);
    ceres::GradientProblemSolver::Options options;
    options.line_search_direction_type = ceres::BFGS;
    options.line_search_type = ceres::WOLFE;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-11;
    options.gradient_tolerance = 1e-10;
    options.logging_type = ceres::SILENT;
    ceres::GradientProblemSolver::Summary summary;
    std::vector<double> x(2 * start.size(), 0.0);
    ceres::Solve(options, problem, x.data(), &summary);
    return {planes->at(x.data()), summary.final_cost};
}

}  // namespace

DirectionMinimum minimiseOverDirections(const DirectionObjective& objective, std::span<const Vec3d> start) {
    FLAGS_minloglevel = google::GLOG_ERROR;  // a line search that cannot go on is an answer, so Ceres must not warn
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
