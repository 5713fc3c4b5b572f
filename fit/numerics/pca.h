#pragma once
// Principal components through the smaller Gram matrix: of n rows and d columns only an eigenproblem of size min(n, d)
// is solved. The only place of this stage that decomposes matrices.
#include <array>
#include <span>

#include "fit/numerics/matrix.h"
#include "sh/vec3.h"

namespace penumbra {

// All principal components of centred rows, descending. rows = scores basis, basis rows orthonormal.
struct Pca {
    std::vector<double> energies;  // [r] sum over rows of the squared score; components below 1e-12 of the sum left out
    Matrix scores;                 // [n, r]
    Matrix to_basis;               // the r basis rows are to_basis^T rows when n <= d; else to_basis holds them, [r, d]
    bool from_rows = true;         // which of the two
    double total = 0;              // sum of all energies
};

// `rows` are centred already. Deterministic: each component's entry of largest magnitude (first of equals) in the
// eigenvector that was computed is positive.
Pca principalComponents(const MatrixF& rows);
Pca principalComponents(const Matrix& rows);

// The first `count` basis vectors, [count, d]; `rows` as given to principalComponents. Rows past the rank are zero.
Matrix basisOf(const Pca& pca, const Matrix& rows, std::size_t count);
MatrixF basisOf(const Pca& pca, const MatrixF& rows, std::size_t count);

// The smallest count, at least 1, whose energies add up to `fraction` of the total.
std::size_t componentsFor(const Pca& pca, double fraction);

// gram += rows rows^T; gram is [rows, rows].
void addGram(const MatrixF& rows, Matrix& gram);
// Of a symmetric matrix, descending; those below zero count as zero.
std::vector<double> eigenvalues(const Matrix& symmetric);

// Unit principal directions of points about their centroid, largest extent first; the largest coordinate of each is
// positive. Fewer than two different points: the coordinate axes.
std::array<Vec3d, 3> principalAxes(std::span<const Vec3> points);

}  // namespace penumbra
