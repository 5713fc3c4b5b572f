#pragma once
// Trains the models of a cluster. Each trainer sets what maps raw features to scores, and chooses its parameters by
// blocked cross-validation.
#include "fit/models/input_pca.h"

namespace penumbra {

// The linear model (degree 1): input PCA and ridge regression (Nowrouzezahrai 2009 sections 5.2 and 5.3, Nowrouzezahrai
// 2007 section 4.2). The quadratic model (degree 2) sees the products of two inputs, too. A product grows with the
// square of the inputs' unit, so the inputs are scaled first: the first has a root mean square of 1.
RegressionErrors trainRidge(const RegressionProblem& problem, int degree, ClusterModel& model);
// Writes x_0 .. x_(I-1), then x_i x_j for i <= j, with j running fastest: [n, I] becomes [n, quadraticUnits(I)]. The
// run-time evaluator uses the same order.
Matrix quadraticInputs(const Matrix& inputs);
// Returns the values of alpha to try for a regression of this degree on training rows.
std::vector<double> ridgePriors(int degree, const InputPca& inputs, std::size_t rows);

// The neural model: input PCA and a tanh net (Nowrouzezahrai 2009 eq 12 and 13). There is no closed form of the
// leave-one-out error, so it is NaN.
RegressionErrors trainNeural(const RegressionProblem& problem, ClusterModel& model);

// The additive model: a sum of radial units, each of which sees the inputs of one group (one bone, for example).
// Occlusion nearly adds up over occluders. A model that never looks at two bones at once is therefore also right for
// combinations of poses that it never saw. The groups of `model`, their weights and ranges must be set before
// (setGroups()). Groups that turn out to be of no use are removed. The leave-one-out error is NaN.
RegressionErrors trainAdditive(const RegressionProblem& problem, ClusterModel& model);

}  // namespace penumbra
