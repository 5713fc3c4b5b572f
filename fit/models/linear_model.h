#pragma once
// Ridge regression with an intercept: centred X and Y, W = (X^T X + alpha^2 I)^-1 X^T Y (paper 002 section 4.2, where
// alpha is squared too).
#include <span>

#include "fit/numerics/matrix.h"

namespace penumbra {

struct Ridge {
    Matrix weights;                 // [I, K]
    std::vector<double> intercept;  // [K]: prediction = x weights + intercept
    std::vector<double> leverage;   // [n]: diagonal of the hat matrix, 1/n of the intercept included
};

Ridge fitRidge(const Matrix& inputs, const Matrix& outputs, double alpha);

// Root mean square over rows and columns of the leave-one-out residuals, (y - prediction) / (1 - leverage). Optimistic
// on consecutive frames of an animation: reported, never used for a choice.
double leaveOneOutError(const Ridge& ridge, const Matrix& inputs, const Matrix& outputs);

Matrix predict(const Ridge& ridge, const Matrix& inputs);

}  // namespace penumbra
