#include "fit/numerics/cross_validation.h"

#include <algorithm>
#include <cmath>

#include "fit/numerics/eigen_map.h"

namespace penumbra {

namespace {

struct Fold {
    std::vector<std::size_t> kept, left_out;  // rows
};

// Rows of a fold, expressed in the principal components of the kept rows.
struct Reduced {
    Pca pca;                // principal components of the kept rows
    std::size_t count = 0;  // number of components
    Matrix left_out;        // [left out, count] scores of the rows that were left out
};

Reduced reduce(const Matrix& all, const Fold& fold, double variance) {
    const std::vector<double> mean = meanOfRows(all, fold.kept);
    const Matrix kept = centeredRows(all, fold.kept, mean);
    Reduced out{principalComponents(kept), 0, {}};
    out.count = std::min(componentsFor(out.pca, variance), out.pca.energies.size());
    out.left_out = Matrix(fold.left_out.size(), out.count);
    asEigen(out.left_out).noalias() =
        asEigen(centeredRows(all, fold.left_out, mean)) * asEigen(basisOf(out.pca, kept, out.count)).transpose();
    return out;
}

// Applies `expand` to the reduced inputs, scaled by expansionScale(), and reduces the result again without dropping any
// component.
Reduced expanded(const Reduced& inputs, const Fold& fold, const Expansion& expand) {
    const double scale = expansionScale(inputs.pca, fold.kept.size());
    Matrix x(fold.kept.size() + fold.left_out.size(), inputs.count);
    const auto kept = Eigen::Index(fold.kept.size()), out = Eigen::Index(fold.left_out.size());
    asEigen(x).topRows(kept) = scale * asEigen(inputs.pca.scores).leftCols(Eigen::Index(inputs.count));
    asEigen(x).bottomRows(out) = scale * asEigen(inputs.left_out);
    Fold in_order;
    for (std::size_t r = 0; r < x.rows; ++r) (r < fold.kept.size() ? in_order.kept : in_order.left_out).push_back(r);
    return reduce(expand(x), in_order, 1);
}

// Returns the squared error on one fold for every alpha.
//
// Naive: solve a ridge regression for each alpha. Here the inputs are x = U s in their own PCA, which makes the
// regression diagonal: a left-out row with scores z is predicted as sum_i z_i d_i (U_i^T Y), where d_i = s_i / (s_i^2 +
// alpha^2). The squared error of the fold is then |Y_out|^2 - 2 d.c + d.Bd with c_i = (Z^T Y_out)_i . (U^T Y)_i and
// B_ij = (Z^T Z)_ij (U^T Y)_i . (U^T Y)_j, and each further alpha costs only I^2.
std::vector<double> foldErrors(const Matrix& features, const Matrix& outputs, const Fold& fold, double input_variance,
                               std::span<const double> alphas, const Expansion& expand) {
    // 1. Reduce the inputs, and expand them if asked to.
    Reduced inputs = reduce(features, fold, input_variance);
    if (expand) inputs = expanded(inputs, fold, expand);
    const std::vector<double> y_mean = meanOfRows(outputs, fold.kept);
    const Matrix y = centeredRows(outputs, fold.kept, y_mean), y_out = centeredRows(outputs, fold.left_out, y_mean);
    const auto n = Eigen::Index(inputs.count);
    const double square = asEigen(y_out).squaredNorm();
    // When inputs or outputs never change, the prediction is the mean.
    if (n == 0 || y.columns == 0) return std::vector<double>(alphas.size(), square);

    // 2. Compute what does not depend on alpha: s, U^T Y, c and B.
    const Eigen::VectorXd s = Eigen::Map<const Eigen::VectorXd>(inputs.pca.energies.data(), n).cwiseSqrt();
    const auto z = asEigen(inputs.left_out);
    const Eigen::MatrixXd uy =
        s.cwiseInverse().asDiagonal() * (asEigen(inputs.pca.scores).leftCols(n).transpose() * asEigen(y)).eval();
    const Eigen::VectorXd c = (z.transpose() * asEigen(y_out)).cwiseProduct(uy).rowwise().sum();
    const Eigen::MatrixXd b = (z.transpose() * z).cwiseProduct(uy * uy.transpose());
    std::vector<double> errors;
    // 3. Each alpha gives its own d.
    for (double alpha : alphas) {
        const Eigen::VectorXd d = s.array() / (s.array().square() + alpha * alpha);
        errors.push_back(square - 2 * d.dot(c) + d.dot(b * d));
    }
    return errors;
}

}  // namespace

double expansionScale(const Pca& inputs, std::size_t rows) {
    return inputs.energies.empty() ? 1 : std::sqrt(double(rows) / inputs.energies[0]);
}

std::vector<double> blockedErrors(const Matrix& weighted_features, const Matrix& outputs, const std::vector<int>& folds,
                                  double input_variance, std::span<const double> alphas, const Expansion& expand) {
    std::vector<double> errors(alphas.size());
    const int fold_count = folds.empty() ? 0 : 1 + *std::max_element(folds.begin(), folds.end());
    if (fold_count < 2) return errors;
    for (int f = 0; f < fold_count; ++f) {
        Fold fold;
        for (std::size_t i = 0; i < folds.size(); ++i) (folds[i] == f ? fold.left_out : fold.kept).push_back(i);
        const std::vector<double> of_fold =
            foldErrors(weighted_features, outputs, fold, input_variance, alphas, expand);
        for (std::size_t a = 0; a < alphas.size(); ++a) errors[a] += of_fold[a];
    }
    return errors;
}

}  // namespace penumbra
