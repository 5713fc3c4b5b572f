#pragma once
// Ridge regression with an intercept. For centered X and Y it computes W = (X^T X + alpha^2 I)^-1 X^T Y (Nowrouzezahrai
// 2007 section 4.2, which squares alpha too).
#include <span>

#include "fit/numerics/matrix.h"

namespace penumbra {

struct Ridge {
    Matrix weights;                 // [I, K]
    std::vector<double> intercept;  // [K], in prediction = x weights + intercept
    std::vector<double> leverage;   // [n] diagonal of the hat matrix, with the 1/n of the intercept
};

// Fits `outputs` [n, K] to `inputs` [n, I]; n must be at least 1.
Ridge fitRidge(const Matrix& inputs, const Matrix& outputs, double alpha);

// Returns the root mean square, over rows and columns, of the leave-one-out residuals (y - prediction) / (1 -
// leverage). It is too optimistic on consecutive frames of an animation, so it is reported but never used for a choice.
double leaveOneOutError(const Ridge& ridge, const Matrix& inputs, const Matrix& outputs);

// Returns the predictions [n, K] for `inputs` [n, I].
Matrix predict(const Ridge& ridge, const Matrix& inputs);

}  // namespace penumbra
