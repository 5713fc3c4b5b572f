// Computes the largest singular values of a matrix and their vectors.
//
// Problem: a material with an orthotropic BRDF gives matrices of up to 544 x 544, and only some 8 to 15 of their
// singular values are needed. Some of them may be equal.
//
// Naive: compute the whole decomposition and drop most of it. Its cost grows with the cube of the size.
//
// Here: a subspace iteration (Halko, Martinsson and Tropp 2011, algorithm 4.4) around Eigen's decompositions. A space
// of a few vectors more than asked for is multiplied by a^T a again and again and turns towards the largest ones. See
// docs/formulas.md, section 3 (reflection product operators).

#include "fit/numerics/truncated_svd.h"

#include <algorithm>

#include "fit/numerics/dense_solvers.h"
#include "fit/numerics/eigen_map.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr Index kDirect = 128;       // up to this many rows or columns the whole decomposition is cheaper
constexpr Index kExtra = 32;         // vectors of the space beside those asked for
constexpr int kMaxPasses = 100;      // no BRDF needed more than 9
constexpr double kResidual = 1e-11;  // relative to the largest singular value

// Copies the first `count` triples. The entry of largest magnitude of each u is made positive.
TruncatedSvd stored(const MatrixXd& u, const Eigen::VectorXd& sigma, const MatrixXd& v, std::size_t count) {
    const std::size_t k = std::min(count, std::size_t(sigma.size()));
    TruncatedSvd out{{sigma.data(), sigma.data() + k}, {k, std::size_t(u.rows())}, {k, std::size_t(v.rows())}};
    for (std::size_t b = 0; b < k; ++b) {
        const double sign = signOf(u.col(Index(b)));
        for (Index i = 0; i < u.rows(); ++i) out.u(b, std::size_t(i)) = sign * u(i, Index(b));
        for (Index i = 0; i < v.rows(); ++i) out.v(b, std::size_t(i)) = sign * v(i, Index(b));
    }
    return out;
}

// Returns a start for the iteration. Any start of full rank will do; this one is the same on every machine (numbers of
// a linear congruential generator).
MatrixXd startOf(Index rows, Index columns) {
    MatrixXd start(rows, columns);
    std::uint64_t state = 1;
    for (Index i = 0; i < start.size(); ++i) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        start.data()[i] = double(state >> 11) * 0x1p-52 - 1;
    }
    return start;
}

}  // namespace

TruncatedSvd truncatedSvd(const Matrix& a, std::size_t count) {
    const auto m = asEigen(a);
    count = std::min({count, a.rows, a.columns});
    const Index k = Index(count);
    if (k + kExtra > kDirect || std::min(m.rows(), m.cols()) <= kDirect) {
        const ThinSvd svd = thinSvd(m);
        return stored(svd.u, svd.sigma, svd.v, count);
    }
    MatrixXd space = orthonormalColumns(startOf(m.cols(), k + kExtra));
    for (int pass = 1;; ++pass) {
        throwIfInterrupted();
        // 1. Decompose `a` on the space.
        const ThinSvd svd = thinSvd(m * space);
        const MatrixXd v = space * svd.v.leftCols(k), image = m.transpose() * svd.u;
        const Eigen::VectorXd sigma = svd.sigma.head(k);
        // 2. Stop when the triples are accurate, else go on with the image of the space under a^T a.
        const double residual = (image.leftCols(k) - v * sigma.asDiagonal()).colwise().norm().maxCoeff();
        if (residual <= kResidual * sigma[0] || pass == kMaxPasses) return stored(svd.u, sigma, v, count);
        space = orthonormalColumns(image);
    }
}

}  // namespace penumbra
