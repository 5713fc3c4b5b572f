#pragma once
// Row-major matrices as plain data, so that no header of this stage needs a linear algebra library.
#include <cstddef>
#include <span>
#include <vector>

namespace penumbra {

template <class T>
struct BasicMatrix {
    std::size_t rows = 0, columns = 0;
    std::vector<T> values;  // [rows, columns]

    BasicMatrix() = default;
    BasicMatrix(std::size_t r, std::size_t c) : rows(r), columns(c), values(r * c) {}
    T& operator()(std::size_t r, std::size_t c) { return values[r * columns + c]; }
    T operator()(std::size_t r, std::size_t c) const { return values[r * columns + c]; }
    std::span<T> row(std::size_t r) { return std::span(values).subspan(r * columns, columns); }
    std::span<const T> row(std::size_t r) const { return std::span(values).subspan(r * columns, columns); }
};
using Matrix = BasicMatrix<double>;
using MatrixF = BasicMatrix<float>;

// Returns the mean of the given rows, summed in double and in their order.
template <class T>
std::vector<double> meanOfRows(const BasicMatrix<T>& m, std::span<const std::size_t> rows) {
    std::vector<double> mean(m.columns);
    for (std::size_t r : rows)
        for (std::size_t c = 0; c < m.columns; ++c) mean[c] += m(r, c);
    for (double& x : mean) x /= double(rows.size());
    return mean;
}

// Returns the given rows minus `mean`.
inline Matrix centredRows(const Matrix& m, std::span<const std::size_t> rows, std::span<const double> mean) {
    Matrix out(rows.size(), m.columns);
    for (std::size_t r = 0; r < rows.size(); ++r)
        for (std::size_t c = 0; c < m.columns; ++c) out(r, c) = m(rows[r], c) - mean[c];
    return out;
}

inline double squaredDistance(std::span<const double> a, std::span<const double> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sum;
}

}  // namespace penumbra
