#pragma once
// Trains a tanh net whose number of neurons and prior weight are chosen by cross-validation (Nowrouzezahrai 2009
// section 5.3).
//
// Eq 13 adds squares of d, which are in 1 / inputs, to squares of c, which are in outputs. So inputs and outputs are
// first divided by their root mean square lengths over the frames. Alpha grows with the number of frames: alpha = prior
// * frames.
#include <cstdint>
#include <vector>

#include "fit/models/neural_model.h"

namespace penumbra {

struct NetSearch {
    // The first is tried with every prior, the others with the best prior of the first.
    std::vector<std::size_t> neurons = {16, 8, 32};
    double least_prior = 2.5e-4, prior_ratio = 2, most_prior = 0.6;
    int folds = 4;
    double input_variance = 0.95;  // share of the variance that the PCA of the inputs keeps
    std::uint64_t seed = 1;
};

struct NetChoice {
    std::size_t neurons = 0;
    double prior = 0;
    double error = 0;  // squared error on each fold, summed over the folds, in outputs squared
};

// Chooses the number of neurons and the prior. `inputs` [n, r] are principal components of the weighted features. They
// must hold more than `input_variance` of the variance, because the PCA is made again without each fold. `outputs` is
// [n, K], and `folds` [n] comes from makeFolds(); when it has more than `search.folds` folds, some are merged. Among
// the numbers of neurons whose root mean square error is within 1% of the best, the smallest is taken.
NetChoice chooseNet(const Matrix& inputs, const Matrix& outputs, const std::vector<int>& folds,
                    const NetSearch& search);

// Fits the chosen net by a round of many starts (neural_start.h). Inputs and outputs are in their own units, and so is
// the net that is returned.
TanhNet fitChosenNet(const Matrix& inputs, const Matrix& outputs, const NetChoice& choice, const NetSearch& search);

}  // namespace penumbra
