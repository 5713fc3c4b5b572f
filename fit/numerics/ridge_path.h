#pragma once
// Ridge regressions of one set of inputs for many values of alpha, of which cross-validation picks one (Nowrouzezahrai
// 2007, section 4.2). One thin SVD of the inputs serves all alphas. Of the outputs only their Gram matrix is needed, so
// that outputs of millions of columns never lie in memory together.
#include <span>
#include <vector>

#include "fit/numerics/matrix.h"

namespace penumbra {

// Singular values below this part of the largest count as zero: floats do not resolve what lies below.
constexpr double kInputRankTolerance = 1e-6;

// The inputs less their mean are u diag(sigma) v^T, cut after the first k singular values.
struct RidgeSvd {
    std::vector<double> mean;   // [I]
    std::vector<double> sigma;  // [k] descending
    Matrix u, v;                // [n, k] and [I, k], orthonormal columns
};

// Decomposes `inputs` [n, I]. It keeps at most `most` singular values: those of the leading principal components.
RidgeSvd makeRidgeSvd(const Matrix& inputs, std::size_t most);

// Returns the values of alpha to try, as multiples of the inputs' largest singular value. They reach from almost no
// prior to nearly the mean alone.
std::vector<double> alphaGrid(double largest_singular_value);
// Returns the place of the least error, of equal ones the last: that of the strongest prior.
std::size_t strongestOfBest(std::span<const double> errors);

// Each returns, for every alpha, the squared error over all rows and columns of the outputs, each row predicted without
// its own fold. `gram` is outputs outputs^T, [n, n].
// Every row is a fold of its own: e_i = (B - H B)_i / (1 - h_ii), where H includes the 1/n of the intercept.
std::vector<double> leaveOneOutErrors(const RidgeSvd& path, const Matrix& gram, std::span<const double> alphas);
// `folds` [n] are numbered from 0. Means and principal components of the inputs are computed again without the fold.
std::vector<double> foldErrors(const Matrix& inputs, const Matrix& gram, const std::vector<int>& folds,
                               std::size_t most, std::span<const double> alphas);

// Returns diag(sigma / (sigma^2 + alpha^2)) u^T, [k, n]. Times the outputs less their mean it gives the weights of the
// principal components; v times that gives the weights of the inputs.
Matrix weightsOperator(const RidgeSvd& path, double alpha);

}  // namespace penumbra
