#pragma once
// Row-major matrices as plain data, so that no header of this stage needs a linear algebra library.
#include <cmath>
#include <cstddef>
#include <numeric>
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

// Returns 0, 1, .., count - 1: all rows of a matrix, or an order to sort.
inline std::vector<std::size_t> indices(std::size_t count) {
    std::vector<std::size_t> all(count);
    std::iota(all.begin(), all.end(), std::size_t(0));
    return all;
}

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
template <class T>
BasicMatrix<T> centeredRows(const BasicMatrix<T>& m, std::span<const std::size_t> rows, std::span<const double> mean) {
    BasicMatrix<T> out(rows.size(), m.columns);
    for (std::size_t r = 0; r < rows.size(); ++r)
        for (std::size_t c = 0; c < m.columns; ++c) out(r, c) = T(double(m(rows[r], c)) - mean[c]);
    return out;
}
// Subtracts the mean of these rows.
template <class T>
BasicMatrix<T> centeredRows(const BasicMatrix<T>& m, std::span<const std::size_t> rows) {
    return centeredRows(m, rows, meanOfRows(m, rows));
}

// sqrt(sum weight (ours - exact)^2 / sum weight exact^2), and 0 where all exact values are.
struct RelativeRms {
    double error = 0, total = 0;

    void add(double ours, double exact, double weight = 1) {
        error += weight * (ours - exact) * (ours - exact);
        total += weight * exact * exact;
    }
    void add(const RelativeRms& other) { error += other.error, total += other.total; }
    double value() const { return total > 0 ? std::sqrt(error / total) : 0; }
};

inline double squaredDistance(std::span<const double> a, std::span<const double> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sum;
}

}  // namespace penumbra
