#pragma once
// Chooses the alpha of a ridge regression by cross-validation over blocks of frames.
#include <functional>
#include <span>
#include <vector>

#include "fit/numerics/matrix.h"
#include "fit/numerics/pca.h"
#include "formats/common/frame_folds.h"

namespace penumbra {

// Turns the reduced inputs [n, I] into the functions of them that the ridge regression sees in their place, [n, H].
using Expansion = std::function<Matrix(const Matrix& inputs)>;

// Returns the factor that gives the first of the PCA inputs a root mean square of 1. Inputs are scaled by it before an
// expansion. `rows` is the number of rows that the PCA was made of.
double expansionScale(const Pca& inputs, std::size_t rows);

// Returns, for each alpha, the squared error on each fold of a ridge regression on all other folds, summed over the
// folds. Without a second fold all errors are zero. Nothing of a fold enters its prediction: means and input PCA are
// computed again without it. `outputs` are all principal components of the outputs. They are an isometric copy of the
// outputs, so no output PCA has to be computed again. When `expand` is given, the regression sees expand(scaled PCA
// inputs).
std::vector<double> blockedErrors(const Matrix& weighted_features, const Matrix& outputs, const std::vector<int>& folds,
                                  double input_variance, std::span<const double> alphas, const Expansion& expand = {});

}  // namespace penumbra
