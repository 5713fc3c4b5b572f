#include "fit/models/neural_bfgs.h"

#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>
#include <glog/logging.h>

#include <cmath>
#include <stdexcept>

namespace penumbra {

namespace {

// Calls visit() with every array of weights, always in the same order.
template <class Net, class Visit>
void visitWeights(Net& net, Visit visit) {
    visit(net.hidden.values), visit(net.hidden_bias), visit(net.output.values), visit(net.output_bias);
}

std::vector<double> weightsOf(const TanhNet& net) {
    std::vector<double> all;
    visitWeights(net, [&](const std::vector<double>& part) { all.insert(all.end(), part.begin(), part.end()); });
    return all;
}

void setWeights(TanhNet& net, const double* weights) {
    visitWeights(net, [&](std::vector<double>& part) {
        std::copy_n(weights, part.size(), part.begin());
        weights += part.size();
    });
}

// Eq 13 and its gradient as Ceres asks for them.
class Objective : public ceres::FirstOrderFunction {
public:
    Objective(const Matrix& inputs, const Matrix& outputs, const TanhNet& start, double alpha)
        : inputs_(inputs), outputs_(outputs), start_(start), alpha_(alpha), size_(int(weightsOf(start).size())) {}

    bool Evaluate(const double* weights, double* cost, double* gradient) const override {
        TanhNet net = start_, slope;
        setWeights(net, weights);
        *cost = gradient ? netObjective(net, inputs_, outputs_, alpha_, slope)
                         : netObjective(net, inputs_, outputs_, alpha_);
        if (gradient) {
            const std::vector<double> values = weightsOf(slope);
            std::copy(values.begin(), values.end(), gradient);
        }
        return std::isfinite(*cost);  // Ceres would take NaN for convergence
    }
    int NumParameters() const override { return size_; }

private:
    const Matrix &inputs_, &outputs_;
    TanhNet start_;
    double alpha_;
    int size_;
};

}  // namespace

NetFit fitByBfgs(const Matrix& inputs, const Matrix& outputs, const TanhNet& start, double alpha,
                 const BfgsOptions& options) {
    FLAGS_minloglevel = google::GLOG_ERROR;  // Ceres warns on stderr when BFGS has more than 1000 variables
    ceres::GradientProblem problem(new Objective(inputs, outputs, start, alpha));
    ceres::GradientProblemSolver::Options settings;
    settings.line_search_type = ceres::WOLFE;
    settings.line_search_direction_type = options.method == QuasiNewton::kBfgs ? ceres::BFGS : ceres::LBFGS;
    settings.max_num_iterations = options.iterations;
    settings.function_tolerance = options.least_decrease;
    settings.gradient_tolerance = 0;
    settings.parameter_tolerance = 0;
    settings.logging_type = ceres::SILENT;
    std::vector<double> weights = weightsOf(start);
    ceres::GradientProblemSolver::Summary summary;
    ceres::Solve(settings, problem, weights.data(), &summary);
    if (summary.iterations.empty()) throw std::runtime_error("BFGS: the objective is not finite at the start");
    NetFit fit{start, 0, int(summary.iterations.size()) - 1, summary.num_gradient_evaluations};
    setWeights(fit.net, weights.data());
    fit.objective = netObjective(fit.net, inputs, outputs, alpha);
    return fit;
}

}  // namespace penumbra
