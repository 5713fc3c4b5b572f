#pragma once
// Principal components through the smaller Gram matrix: for n rows and d columns it solves an eigenproblem of size
// min(n, d) only.
#include <array>
#include <span>

#include "fit/numerics/matrix.h"
#include "sh/vec3.h"

namespace penumbra {

// All principal components of n centered rows of d numbers, in descending order. rows = scores * basis, and the basis
// rows are orthonormal.
struct Pca {
    // [r] sum over rows of the squared score; components below 1e-12 of the total are left out.
    std::vector<double> energies;
    Matrix scores;          // [n, r]
    Matrix to_basis;        // [n, r], basis = to_basis^T rows, when from_rows; else [r, d], the basis itself
    bool from_rows = true;  // n <= d
    double total = 0;       // sum of all energies
};

// Computes the principal components of rows that are already centered. The result is deterministic: in each computed
// eigenvector the entry of largest magnitude (the first of equals) is positive.
Pca principalComponents(const MatrixF& rows);
Pca principalComponents(const Matrix& rows);

// Returns the first `count` basis vectors, [count, d]. `rows` must be the rows given to principalComponents(). Basis
// rows past the rank are zero.
Matrix basisOf(const Pca& pca, const Matrix& rows, std::size_t count);
MatrixF basisOf(const Pca& pca, const MatrixF& rows, std::size_t count);

// Returns the smallest count, at least 1, whose energies add up to `fraction` of the total.
std::size_t componentsFor(const Pca& pca, double fraction);

// Adds rows rows^T to `gram`, [rows, rows].
void addGram(const MatrixF& rows, Matrix& gram);
// Returns the eigenvalues of a symmetric matrix in descending order. Negative ones count as zero.
std::vector<double> eigenvalues(const Matrix& symmetric);

// Returns the unit principal directions of points about their centroid, the largest extent first. The coordinate of
// largest magnitude of each is positive. When all points coincide, these are the coordinate axes.
std::array<Vec3d, 3> principalAxes(std::span<const Vec3> points);

}  // namespace penumbra
