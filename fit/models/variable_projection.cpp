// Fits a layer of tanh neurons by variable projection.
//
// Problem: find hidden weights d, hidden biases d0, output weights c and output biases c0 that minimise eq 13 of
// Nowrouzezahrai 2009, sum over frames |sum_n c^n tanh(d^n . x + d0^n) + c0 - y|^2 + alpha sum_n (|c^n|^2 + |d^n|^2).
//
// Naive: search all weights together with BFGS, as the papers do (tests/fit/neural_bfgs.h). Every change of a hidden
// weight makes the output weights wrong, and the search needs further steps to bring them back.
//
// Here: for fixed d and d0 the objective is a ridge regression in c and c0, which one Cholesky factorisation solves
// exactly. So the search runs over d and d0 only and always sees the best c. Centered activations and outputs take care
// of c0. At the best c the derivative by c is zero, so the gradient of this projected objective is the gradient of
// eq 13 by d with c held: no derivative of the ridge regression is needed. L-BFGS with the Gauss-Newton diagonal
// minimises it.
//
// Derivation: docs/formulas.md, section 4. Measurements: tests/bench (bench_optimisers).

#include "fit/models/variable_projection.h"

#include <cassert>
#include <cmath>

#include "fit/models/net_kernels.h"
#include "fit/numerics/dense_solvers.h"
#include "fit/numerics/eigen_map.h"

namespace penumbra {

namespace {

// The objective as a function of the hidden weights and biases alone.
class ProjectedObjective {
public:
    ProjectedObjective(const NetData& data, const TanhNet& start, double alpha)
        : data_(data),
          kernels_(netKernelPaths().back()),
          neurons_(start.neurons()),
          alpha_(alpha),
          h_(neurons_ * data.stride),
          slope_(h_.size()),
          back_(h_.size()),
          residual_(data.outputs * data.stride),
          h_mean_(neurons_),
          gram_(neurons_, neurons_),
          output_(neurons_, data.outputs) {}

    // Returns the objective at the variables `x` and fills its gradient; infinity when the ridge regression has no
    // solution.
    double evaluate(std::span<const double> x, std::span<double> gradient) {
        // 1. Evaluate the hidden neurons.
        setActivations(x);
        // 2. Solve for the best output weights.
        if (!solveOutputs()) return std::numeric_limits<double>::infinity();
        // 3. Sum the squared residuals and the penalties, and take the gradient with the output weights held.
        const double value = setResidual() + alpha_ * asEigen(output_).squaredNorm();
        return value + backPropagate(x, gradient);
    }

    // Fills the Gauss-Newton diagonal at the last evaluated variables, with the output weights held: 2 |c^n|^2 sum_f
    // slope^2 x^2 + 2 alpha.
    void curvature(std::span<double> diagonal) {
        for (std::size_t i = 0; i < slope_.size(); ++i) back_[i] = slope_[i] * slope_[i];
        products(data_.x_squared, diagonal);
        for (std::size_t n = 0; n < neurons_; ++n) {
            const double factor = 2 * asEigen(output_).row(Eigen::Index(n)).squaredNorm();
            for (double& d : diagonal.subspan(n * width(), width())) d = factor * d + 2 * alpha_;
        }
    }

    // Writes the output weights and biases that belong to the last evaluated variables into `net`.
    void setOutputs(TanhNet& net) const {
        net.output = output_;
        net.output_bias = data_.y_mean;
        for (std::size_t n = 0; n < neurons_; ++n)
            for (std::size_t k = 0; k < data_.outputs; ++k) net.output_bias[k] -= h_mean_[n] * output_(n, k);
    }

private:
    // Sets h_ to tanh(d . x + d0) less its mean over the frames, and slope_ to 1 - tanh^2. Both are zero in the
    // padding.
    void setActivations(std::span<const double> x) {
        const std::size_t stride = data_.stride, frames = data_.frames;
        // 1. Fill each row with the neuron's bias, then add the product of weights and inputs.
        for (std::size_t n = 0; n < neurons_; ++n) std::fill_n(&h_[n * stride], stride, x[n * width() + data_.inputs]);
        kernels_.addProduct(neurons_, data_.inputs, stride, x.data(), width(), data_.x.data(), h_.data());
        // 2. Apply tanh.
        kernels_.tanhAndSlope(h_.size(), h_.data(), slope_.data());
        // 3. Center every row over the frames and clear the padding.
        for (std::size_t n = 0; n < neurons_; ++n) {
            Eigen::Map<Eigen::ArrayXd> row(&h_[n * stride], Eigen::Index(frames));
            h_mean_[n] = row.mean();
            row -= h_mean_[n];
            for (std::size_t f = frames; f < stride; ++f) h_[n * stride + f] = slope_[n * stride + f] = 0;
        }
    }

    // Solves (H H^T + alpha) C = H Y^T for the output weights C. Returns false when the matrix is not positive
    // definite.
    bool solveOutputs() {
        const std::size_t stride = data_.stride;
        kernels_.innerProducts(neurons_, neurons_, stride, h_.data(), h_.data(), gram_.values.data(), neurons_);
        kernels_.innerProducts(neurons_, data_.outputs, stride, h_.data(), data_.y.data(), output_.values.data(),
                               data_.outputs);
        asEigen(gram_).diagonal().array() += alpha_;
        RowMajorXd output = asEigen(output_);
        if (!solvePositive(asEigen(gram_), output, output)) return false;
        asEigen(output_) = output;
        return true;
    }

    // Sets residual_ to Y - C^T H and returns its squared norm.
    double setResidual() {
        const EigenRows<double> minus = -asEigen(output_).transpose();
        residual_ = data_.y;
        kernels_.addProduct(data_.outputs, neurons_, data_.stride, minus.data(), neurons_, h_.data(), residual_.data());
        return Eigen::Map<const Eigen::VectorXd>(residual_.data(), Eigen::Index(residual_.size())).squaredNorm();
    }

    // Fills the gradient and returns the penalty of the hidden weights. The residuals of each output sum to zero over
    // the frames, so it makes no difference that h_ has its mean taken off.
    double backPropagate(std::span<const double> x, std::span<double> gradient) {
        // 1. Take the residuals back through the output weights and through tanh.
        std::fill(back_.begin(), back_.end(), 0.0);
        kernels_.addProduct(neurons_, data_.outputs, data_.stride, output_.values.data(), data_.outputs,
                            residual_.data(), back_.data());
        for (std::size_t i = 0; i < back_.size(); ++i) back_[i] *= -2 * slope_[i];
        // 2. Multiply by the inputs and add the derivative of the penalty. Biases have none.
        double square = 0;
        products(data_.x, gradient);
        for (std::size_t n = 0; n < neurons_; ++n)
            for (std::size_t i = 0; i < data_.inputs; ++i) {
                const double d = x[n * width() + i];
                gradient[n * width() + i] += 2 * alpha_ * d;
                square += d * d;
            }
        return alpha_ * square;
    }

    // Computes, for each neuron, the sums over frames of back_ times the inputs, then the sum of back_ alone.
    void products(const std::vector<double>& inputs, std::span<double> out) {
        const std::size_t stride = data_.stride;
        kernels_.innerProducts(neurons_, data_.inputs, stride, back_.data(), inputs.data(), out.data(), width());
        for (std::size_t n = 0; n < neurons_; ++n)
            out[n * width() + data_.inputs] =
                Eigen::Map<const Eigen::VectorXd>(&back_[n * stride], Eigen::Index(stride)).sum();
    }
    // The variables of a neuron: its weights, then its bias.
    std::size_t width() const { return data_.inputs + 1; }

    const NetData& data_;
    NetKernels kernels_;
    std::size_t neurons_;
    double alpha_;
    std::vector<double> h_, slope_, back_;  // [N, stride]; back_ is the derivative by each neuron's argument
    std::vector<double> residual_;          // [K, stride]
    std::vector<double> h_mean_;            // [N]
    Matrix gram_, output_;                  // [N, N] and [N, K]
};

// Returns the hidden weights, each neuron's followed by its bias.
std::vector<double> variablesOf(const TanhNet& net) {
    std::vector<double> x;
    for (std::size_t n = 0; n < net.neurons(); ++n) {
        x.insert(x.end(), net.hidden.row(n).begin(), net.hidden.row(n).end());
        x.push_back(net.hidden_bias[n]);
    }
    return x;
}

// The inverse of variablesOf().
void setHidden(TanhNet& net, std::span<const double> x) {
    const std::size_t inputs = net.hidden.columns;
    for (std::size_t n = 0; n < net.neurons(); ++n) {
        std::copy_n(&x[n * (inputs + 1)], inputs, net.hidden.row(n).begin());
        net.hidden_bias[n] = x[n * (inputs + 1) + inputs];
    }
}

// Returns the transpose of `m` less the mean of each column, every row padded with zeros to `stride`.
std::vector<double> paddedRows(const Matrix& m, std::size_t stride, std::span<const double> mean) {
    std::vector<double> rows(m.columns * stride);
    for (std::size_t f = 0; f < m.rows; ++f)
        for (std::size_t c = 0; c < m.columns; ++c) rows[c * stride + f] = m(f, c) - mean[c];
    return rows;
}

}  // namespace

NetData netData(const Matrix& inputs, const Matrix& outputs) {
    assert(inputs.rows == outputs.rows && inputs.rows > 0);
    NetData data;
    // The frames are padded to a whole number of lanes.
    data.frames = inputs.rows;
    data.stride = (inputs.rows + kNetLanes - 1) / kNetLanes * kNetLanes;
    data.inputs = inputs.columns;
    data.outputs = outputs.columns;
    data.y_mean.resize(outputs.columns);
    Eigen::Map<Eigen::RowVectorXd>(data.y_mean.data(), Eigen::Index(outputs.columns)) =
        asEigen(outputs).colwise().mean();
    data.x = paddedRows(inputs, data.stride, std::vector<double>(inputs.columns));
    data.y = paddedRows(outputs, data.stride, data.y_mean);
    for (double x : data.x) data.x_squared.push_back(x * x);
    return data;
}

NetFit fitByProjection(const NetData& data, const TanhNet& start, double alpha, const SearchOptions& options) {
    assert(alpha > 0 && start.hidden.columns == data.inputs);
    ProjectedObjective objective(data, start, alpha);
    std::vector<double> x = variablesOf(start), gradient(x.size()), scale(x.size(), 1.0), scaled(x.size());
    // 1. Scale the variables by the Gauss-Newton diagonal at the start, so that L-BFGS sees curvatures near 1.
    NetFit fit{start, objective.evaluate(x, gradient), 0, 1};
    if (std::isfinite(fit.objective)) objective.curvature(scale);
    for (std::size_t i = 0; i < x.size(); ++i) {
        scale[i] = std::sqrt(scale[i]);
        scaled[i] = scale[i] * x[i];
    }
    // 2. Search. The first point and the last one have often just been evaluated.
    std::vector<double> evaluated = scaled;
    const auto evaluate = [&](std::span<const double> at) {
        if (std::equal(at.begin(), at.end(), evaluated.begin())) return fit.objective;
        evaluated.assign(at.begin(), at.end());
        for (std::size_t i = 0; i < x.size(); ++i) x[i] = at[i] / scale[i];
        ++fit.evaluations;
        return fit.objective = objective.evaluate(x, gradient);
    };
    const auto scaledObjective = [&](std::span<const double> at, std::span<double> slope) {
        const double value = evaluate(at);
        for (std::size_t i = 0; i < x.size(); ++i) slope[i] = gradient[i] / scale[i];
        return value;
    };
    fit.iterations = minimise(scaledObjective, options, scaled).iterations;
    // 3. Take the weights where it ended.
    evaluate(scaled);
    setHidden(fit.net, x);
    objective.setOutputs(fit.net);
    return fit;
}

}  // namespace penumbra
