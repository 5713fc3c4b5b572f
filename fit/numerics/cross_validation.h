#pragma once
// Blocked cross-validation of the ridge's alpha.
#include <functional>
#include <span>
#include <vector>

#include "fit/numerics/matrix.h"
#include "fit/numerics/pca.h"
#include "formats/common/mesh.h"

namespace penumbra {

constexpr std::size_t kLeastFolds = 4, kMostFolds = 8;

// A fold per training frame, [frames.size()]. Neighbouring frames are nearly equal, so folds are blocks: each clip is a
// block; while there are fewer than 4, the longest is cut in half; more than 8 are dealt out, the longest first, each
// to the fold with the fewest frames. `frames` are the training frames, ascending.
std::vector<int> makeFolds(const FrameList& list, std::span<const std::size_t> frames);

// Functions of the reduced inputs [n, I] that the ridge sees in their place, [n, H].
using Expansion = std::function<Matrix(const Matrix& inputs)>;

// Factor of the PCA inputs before an expansion, so that the first has a root mean square of 1.
double expansionScale(const Pca& inputs, std::size_t rows);

// Sum over folds of the squared error on the fold of a ridge from all the others, for each alpha. Nothing of the fold
// enters: centring and input PCA are made anew without it. `outputs` are all principal components of the outputs,
// that is an isometric copy of the outputs themselves, so that no output PCA has to be made anew. `expand`, when given,
// makes of the scaled PCA inputs what the ridge sees.
std::vector<double> blockedErrors(const Matrix& weighted_features, const Matrix& outputs, const std::vector<int>& folds,
                                  double input_variance, std::span<const double> alphas, const Expansion& expand = {});

}  // namespace penumbra
