// Cross-validates ridge regressions without fitting any of them.
//
// Problem: choose alpha for outputs of 36 x 11,534 columns and 430 rows, by leaving out each row or each block of rows.
//
// Naive: fit again for each alpha and each fold, and predict all columns. Each fit reads all outputs.
//
// Here: a ridge regression is linear in its outputs B, so that the residuals are E B with a small matrix E of the rows
// alone. Their squared norm is the trace of E G E^T with G = B B^T, which is summed over the columns once. With the SVD
// of the inputs, E is made of two thin matrices and a diagonal, so each alpha costs products of size k only. See
// docs/formulas.md, section 14.
#include "fit/numerics/ridge_path.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "fit/numerics/dense_solvers.h"
#include "fit/numerics/eigen_map.h"

namespace penumbra {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kMinAlphaExponent = -5, kMaxAlphaExponent = 1.5, kAlphaExponentStep = 0.25;

VectorXd sigmaOf(const RidgeSvd& path) {
    return Eigen::Map<const VectorXd>(path.sigma.data(), Index(path.sigma.size()));
}

// Returns s^2 / (s^2 + alpha^2), how much of each singular direction of the outputs survives.
VectorXd kept(const VectorXd& sigma, double alpha) {
    const Eigen::ArrayXd squares = sigma.array().square();
    return squares / (squares + alpha * alpha);
}

// Returns the Gram matrix of the outputs less their mean over all rows.
MatrixXd centeredGram(const Matrix& gram) {
    const MatrixXd g = asEigen(gram);
    const Eigen::RowVectorXd mean = g.colwise().mean();
    return (g.rowwise() - mean).colwise() - (mean.transpose().array() - mean.mean()).matrix();
}

MatrixXd part(const MatrixXd& m, const std::vector<Index>& rows, const std::vector<Index>& columns) {
    return m(rows, columns);
}

// One fold and what its error for an alpha is computed from. Rows that are not of the fold are "others".
struct LeftOut {
    VectorXd sigma;
    MatrixXd inputs;       // [f, k] of the fold, as principal components of the others
    MatrixXd cross, gram;  // u^T G of others with the fold, and u^T G u of the others
    VectorXd from_mean;    // u^T G 1 / others
    double total = 0, mean_cross = 0, mean_gram = 0;
};

LeftOut leaveOut(const Matrix& inputs, const MatrixXd& gram, const std::vector<int>& folds, int which,
                 std::size_t most) {
    std::vector<Index> own, others;
    std::vector<std::size_t> rows;
    for (std::size_t r = 0; r < folds.size(); ++r)
        if (folds[r] == which) {
            own.push_back(Index(r));
        } else {
            others.push_back(Index(r));
            rows.push_back(r);
        }
    Matrix without(rows.size(), inputs.columns);
    for (std::size_t r = 0; r < rows.size(); ++r)
        std::copy_n(inputs.row(rows[r]).begin(), inputs.columns, without.row(r).begin());
    const RidgeSvd path = makeRidgeSvd(without, most);
    const auto u = asEigen(path.u), v = asEigen(path.v);
    const MatrixXd own_inputs = asEigen(inputs)(own, Eigen::all);
    const MatrixXd own_gram = part(gram, own, own), cross = part(gram, others, own),
                   other_gram = part(gram, others, others);
    const Eigen::Map<const Eigen::RowVectorXd> mean(path.mean.data(), Index(path.mean.size()));
    LeftOut fold;
    fold.sigma = sigmaOf(path);
    fold.inputs = (own_inputs.rowwise() - mean) * v;
    fold.cross = u.transpose() * cross;
    fold.gram = u.transpose() * other_gram * u;
    fold.from_mean = u.transpose() * other_gram.rowwise().mean();
    fold.total = own_gram.trace();
    fold.mean_cross = cross.colwise().mean().sum();
    fold.mean_gram = other_gram.mean();
    return fold;
}

// Returns the squared norm of B_f - W B_o, where W = 1 1^T / others + inputs diag(s / (s^2 + alpha^2)) u^T.
double errorOf(const LeftOut& fold, double alpha) {
    const VectorXd shrunk = (kept(fold.sigma, alpha).array() / fold.sigma.array()).matrix();
    const MatrixXd scaled = fold.inputs * shrunk.asDiagonal();
    const double cross = fold.mean_cross + scaled.cwiseProduct(fold.cross.transpose()).sum();
    const double predicted = double(fold.inputs.rows()) * fold.mean_gram +
                             2 * scaled.colwise().sum().dot(fold.from_mean) +
                             (scaled * fold.gram).cwiseProduct(scaled).sum();
    return fold.total - 2 * cross + predicted;
}

}  // namespace

RidgeSvd makeRidgeSvd(const Matrix& inputs, std::size_t most) {
    assert(inputs.rows > 0);
    const Eigen::RowVectorXd mean = asEigen(inputs).colwise().mean();
    const MatrixXd centered = asEigen(inputs).rowwise() - mean;
    const ThinSvd svd = thinSvd(centered);
    Index k = 0;
    while (k < svd.sigma.size() && std::size_t(k) < most && svd.sigma[k] > 0 &&
           svd.sigma[k] > kInputRankTolerance * svd.sigma[0])
        ++k;
    RidgeSvd path;
    path.mean.assign(mean.data(), mean.data() + mean.size());
    path.sigma.assign(svd.sigma.data(), svd.sigma.data() + k);
    path.u = Matrix(inputs.rows, std::size_t(k));
    path.v = Matrix(inputs.columns, std::size_t(k));
    for (Index c = 0; c < k; ++c) {
        const double sign = signOf(svd.v.col(c));
        asEigen(path.u).col(c) = sign * svd.u.col(c);
        asEigen(path.v).col(c) = sign * svd.v.col(c);
    }
    return path;
}

std::vector<double> alphaGrid(double largest_singular_value) {
    std::vector<double> alphas;
    for (double e = kMinAlphaExponent; e <= kMaxAlphaExponent; e += kAlphaExponentStep)
        alphas.push_back(std::pow(10.0, e) * std::max(largest_singular_value, 1e-12));
    return alphas;
}

std::size_t strongestOfBest(std::span<const double> errors) {
    std::size_t best = 0;
    for (std::size_t a = 1; a < errors.size(); ++a)
        if (errors[a] <= errors[best]) best = a;
    return best;
}

std::vector<double> leaveOneOutErrors(const RidgeSvd& path, const Matrix& gram, std::span<const double> alphas) {
    assert(gram.rows == path.u.rows && gram.columns == gram.rows);
    const auto u = asEigen(path.u);
    const MatrixXd g = centeredGram(gram);
    const MatrixXd projected = u.transpose() * g;  // [k, n]
    const MatrixXd inner = projected * u;          // [k, k]
    std::vector<double> errors;
    for (const double alpha : alphas) {
        const VectorXd keep = kept(sigmaOf(path), alpha);
        const MatrixXd shrunk = u * keep.asDiagonal();
        // diag((1 - u keep u^T) G (1 - u keep u^T)) and diag of the hat matrix.
        const VectorXd residual = g.diagonal() - 2 * shrunk.cwiseProduct(projected.transpose()).rowwise().sum() +
                                  (shrunk * inner).cwiseProduct(shrunk).rowwise().sum();
        const VectorXd left = 1 - (shrunk.cwiseProduct(u).rowwise().sum().array() + 1 / double(g.rows()));
        errors.push_back((residual.array() / left.array().square()).sum());
    }
    return errors;
}

std::vector<double> foldErrors(const Matrix& inputs, const Matrix& gram, const std::vector<int>& folds,
                               std::size_t most, std::span<const double> alphas) {
    assert(folds.size() == inputs.rows && gram.rows == inputs.rows);
    const MatrixXd g = centeredGram(gram);
    std::vector<double> errors(alphas.size());
    const int last = *std::max_element(folds.begin(), folds.end());
    for (int f = 0; last > 0 && f <= last; ++f) {
        const LeftOut fold = leaveOut(inputs, g, folds, f, most);
        for (std::size_t a = 0; a < alphas.size(); ++a) errors[a] += errorOf(fold, alphas[a]);
    }
    return errors;
}

Matrix weightsOperator(const RidgeSvd& path, double alpha) {
    const VectorXd sigma = sigmaOf(path);
    Matrix out(path.sigma.size(), path.u.rows);
    asEigen(out) = (kept(sigma, alpha).array() / sigma.array()).matrix().asDiagonal() * asEigen(path.u).transpose();
    return out;
}

}  // namespace penumbra
