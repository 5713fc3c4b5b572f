#include "fit/models/input_pca.h"

#include "fit/numerics/eigen_map.h"

namespace penumbra {

InputPca makeInputPca(const RegressionProblem& problem) {
    InputPca inputs;
    inputs.mean = meanOfRows(problem.raw, problem.train);
    inputs.weights = featureWeights(problem.recipe, problem.place, problem.raw, problem.train);
    inputs.weighted = selectRows(problem.raw, problem.train);
    Matrix& x = inputs.weighted;
    for (std::size_t r = 0; r < x.rows; ++r)
        for (std::size_t c = 0; c < x.columns; ++c) x(r, c) = (x(r, c) - inputs.mean[c]) * inputs.weights[c];
    inputs.pca = principalComponents(x);
    return inputs;
}

Matrix setInputs(const InputPca& inputs, std::size_t count, ClusterModel& model) {
    model.feature_mean = toFloats(inputs.mean);
    const Matrix basis = basisOf(inputs.pca, inputs.weighted, count);
    model.input_basis.clear();
    for (std::size_t i = 0; i < basis.rows; ++i)
        for (std::size_t c = 0; c < basis.columns; ++c)
            model.input_basis.push_back(float(basis(i, c) * inputs.weights[c]));
    Matrix x(inputs.weighted.rows, count);
    asEigen(x) = asEigen(inputs.weighted) * asEigen(basis).transpose();
    const Eigen::RowVectorXd least = asEigen(x).colwise().minCoeff(), most = asEigen(x).colwise().maxCoeff();
    model.input_min = toFloats({least.data(), std::size_t(least.size())});
    model.input_max = toFloats({most.data(), std::size_t(most.size())});
    return x;
}

}  // namespace penumbra
