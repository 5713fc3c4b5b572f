#pragma once
// Chooses the alpha of a ridge regression by cross-validation over blocks of frames.
#include <functional>
#include <span>
#include <vector>

#include "fit/numerics/matrix.h"
#include "fit/numerics/pca.h"
#include "formats/common/mesh.h"

namespace penumbra {

constexpr std::size_t kMinFolds = 4, kMaxFolds = 8;

// Deals things of these sizes out to `groups` groups: starting with the largest, each goes to the group that has the
// least so far. Returns the group of each.
std::vector<int> dealOut(std::span<const std::size_t> sizes, std::size_t groups);

// Returns the fold of each training frame, [frames.size()]. Neighbouring frames are nearly equal, so folds are made of
// blocks. Each clip is a block; while there are fewer than 4 blocks, the longest is cut in half. When there are more
// than 8, they are dealt out to 8 folds. `frames` are the training frames in ascending order.
std::vector<int> makeFolds(const FrameList& list, std::span<const std::size_t> frames);

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
