#pragma once
// A tanh net with the number of neurons and the prior's weight chosen by cross-validation (paper 000 section 5.3).
//
// Eq 13 weighs squares of d, in 1 / inputs, against squares of c, in outputs. So inputs and outputs are first divided
// by their root mean square lengths over the frames, and alpha is given for each frame: alpha = prior * frames.
#include <cstdint>
#include <vector>

#include "fit/models/neural_model.h"

namespace penumbra {

struct NetSearch {
    std::vector<std::size_t> neurons = {16, 8, 32};  // the first gets the whole path of priors, the others its best
    double least_prior = 2.5e-4, prior_ratio = 2, most_prior = 0.6;
    int folds = 4;
    double input_variance = 0.95;  // that the PCA of the inputs keeps
    std::uint64_t seed = 1;
};

struct NetChoice {
    std::size_t neurons = 0;
    double prior = 0;
    double error = 0;  // sum over the folds of the squared error on the fold, in outputs squared
};

// `inputs` are principal components of the weighted features, [n, r], more than input_variance of them: the PCA is made
// anew without each fold. `outputs` [n, K]. Folds as makeFolds gives them; more than `search.folds` are merged. Of
// numbers of neurons within 1% of the best error the smallest is taken.
NetChoice chooseNet(const Matrix& inputs, const Matrix& outputs, const std::vector<int>& folds,
                    const NetSearch& search);

// Inputs and outputs in their own units; the best of a round of starts (many_starts.h).
TanhNet fitChosenNet(const Matrix& inputs, const Matrix& outputs, const NetChoice& choice, const NetSearch& search);

}  // namespace penumbra
