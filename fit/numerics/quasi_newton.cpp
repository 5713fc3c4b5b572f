#include "fit/numerics/quasi_newton.h"

#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>
#include <glog/logging.h>

#include <cmath>

namespace penumbra {

namespace {

// The objective as Ceres asks for it.
class Function : public ceres::FirstOrderFunction {
public:
    Function(const Objective& objective, std::size_t size) : objective_(objective), unused_(size) {}

    bool Evaluate(const double* x, double* cost, double* gradient) const override {
        const std::size_t n = unused_.size();
        *cost = objective_(std::span(x, n), gradient ? std::span(gradient, n) : std::span(unused_));
        return std::isfinite(*cost);  // Ceres would take NaN for convergence
    }
    int NumParameters() const override { return int(unused_.size()); }

private:
    const Objective& objective_;
    mutable std::vector<double> unused_;  // a gradient that Ceres does not ask for
};

// Ends a search at the target, or when its last iterations gained too little.
class Stop : public ceres::IterationCallback {
public:
    explicit Stop(const SearchOptions& options) : options_(options) {}

    ceres::CallbackReturnType operator()(const ceres::IterationSummary& at) override {
        values_.push_back(at.cost);
        const std::size_t last = values_.size() - 1, window = std::size_t(options_.window);
        const bool slow =
            last >= window && values_[last - window] - at.cost <= options_.least_decrease * std::abs(at.cost);
        return slow || at.cost <= options_.target ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
    }

private:
    const SearchOptions& options_;
    std::vector<double> values_;  // values of all iterations
};

}  // namespace

SearchResult minimise(const Objective& objective, const SearchOptions& options, std::vector<double>& x) {
    // A line search that cannot go on is an answer, so Ceres must not warn.
    [[maybe_unused]] static const int quiet = FLAGS_minloglevel = google::GLOG_ERROR;
    Stop stop(options);
    ceres::GradientProblemSolver::Options settings;
    settings.line_search_direction_type = options.method == QuasiNewton::kBfgs ? ceres::BFGS : ceres::LBFGS;
    settings.line_search_type = ceres::WOLFE;
    settings.use_approximate_eigenvalue_bfgs_scaling = true;  // scales by the curvature along the newest step
    settings.max_num_iterations = options.iterations;
    settings.function_tolerance = 0;  // `stop` judges progress
    settings.gradient_tolerance = options.least_gradient;
    settings.parameter_tolerance = 0;
    settings.logging_type = ceres::SILENT;
    settings.callbacks = {&stop};
    const ceres::GradientProblem problem(new Function(objective, x.size()));  // the problem owns the function
    ceres::GradientProblemSolver::Summary summary;
    ceres::Solve(settings, problem, x.data(), &summary);
    if (summary.iterations.empty()) return {};
    return {summary.final_cost, int(summary.iterations.size()) - 1, summary.num_gradient_evaluations};
}

}  // namespace penumbra
