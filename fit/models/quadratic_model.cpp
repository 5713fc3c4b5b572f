#include "fit/models/quadratic_model.h"

#include <algorithm>
#include <cassert>

namespace penumbra {

void quadraticInputs(std::span<const double> x, std::span<double> out) {
    assert(out.size() == quadraticUnits(x.size()));
    std::copy(x.begin(), x.end(), out.begin());
    std::size_t at = x.size();
    for (std::size_t i = 0; i < x.size(); ++i)
        for (std::size_t j = i; j < x.size(); ++j) out[at++] = x[i] * x[j];
}

Matrix quadraticInputs(const Matrix& inputs) {
    Matrix out(inputs.rows, quadraticUnits(inputs.columns));
    for (std::size_t r = 0; r < inputs.rows; ++r) quadraticInputs(inputs.row(r), out.row(r));
    return out;
}

}  // namespace penumbra
