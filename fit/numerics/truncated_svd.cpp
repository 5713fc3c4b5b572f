// Computes the largest singular values of a matrix and their vectors.
//
// Problem: a material with an orthotropic BRDF gives matrices of up to 544 x 544, and only some 8 to 15 of their
// singular values are needed. Some of them may be equal.
//
// Naive: compute the whole decomposition and drop most of it. Its cost grows with the cube of the size. A Lanczos
// iteration with single vectors finds only one vector for values that are equal.
//
// Here: a block of 24 vectors, wider than any run of equal values, spans a Krylov space of a^T a together with its
// images (Golub, Luk and Overton 1981). The decomposition of `a` on that small space converges to the largest singular
// values first. See docs/formulas.md, section 3 (reflection product operators).

#include "fit/numerics/truncated_svd.h"

#include <algorithm>

#include "fit/numerics/dense_solvers.h"
#include "fit/numerics/eigen_map.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr Index kDirect = 128;        // up to this many rows or columns the whole decomposition is cheaper
constexpr Index kKrylovBlock = 24;    // columns added in a step; more than any run of equal values that is asked for
constexpr Index kLargestSpace = 480;  // 20 steps; no BRDF needed more than 9
constexpr double kResidual = 1e-11;   // as a part of the largest singular value

// Copies the first `count` triples. The entry of largest magnitude of each u is made positive.
TruncatedSvd stored(const MatrixXd& u, const Eigen::VectorXd& sigma, const MatrixXd& v, std::size_t count) {
    const std::size_t k = std::min(count, std::size_t(sigma.size()));
    TruncatedSvd out{{sigma.data(), sigma.data() + k}, {k, std::size_t(u.rows())}, {k, std::size_t(v.rows())}};
    for (std::size_t b = 0; b < k; ++b) {
        Index largest = 0;
        u.col(Index(b)).cwiseAbs().maxCoeff(&largest);
        const double sign = u(largest, Index(b)) < 0 ? -1 : 1;  // the sign that the routine returns is arbitrary
        for (Index i = 0; i < u.rows(); ++i) out.u(b, std::size_t(i)) = sign * u(i, Index(b));
        for (Index i = 0; i < v.rows(); ++i) out.v(b, std::size_t(i)) = sign * v(i, Index(b));
    }
    return out;
}

// Returns a start for the iteration. Any start of full rank will do; this one is the same on every machine (numbers of
// a linear congruential generator).
MatrixXd startOf(Index rows) {
    MatrixXd start(rows, kKrylovBlock);
    std::uint64_t state = 1;
    for (Index i = 0; i < start.size(); ++i) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        start.data()[i] = double(state >> 11) * 0x1p-52 - 1;
    }
    return start;
}

// The block Krylov iteration. `space` is orthonormal, and `image` is a * space.
TruncatedSvd krylovSvd(const Eigen::Map<const EigenRows<double>>& a, std::size_t count) {
    const Index largest = std::min({kLargestSpace, a.rows(), a.cols()});
    MatrixXd space(a.cols(), 0), image(a.rows(), 0), block = startOf(a.cols());
    while (true) {
        throwIfInterrupted();
        // 1. Make the new block orthonormal to the space. The second pass removes what rounding left in the first.
        for (int pass = 0; pass < 2 && space.cols() > 0; ++pass) block -= space * (space.transpose() * block);
        block = orthonormalColumns(block);
        // 2. Extend the space and its image by the block.
        const Index before = space.cols();
        space.conservativeResize(Eigen::NoChange, before + kKrylovBlock);
        image.conservativeResize(Eigen::NoChange, before + kKrylovBlock);
        space.rightCols(kKrylovBlock) = block;
        image.rightCols(kKrylovBlock) = a * block;
        // 3. From the fourth step on, decompose the image, and stop when the triples are accurate or the space is full.
        if (space.cols() >= 4 * kKrylovBlock) {
            const ThinSvd svd = thinSvd(image);
            const Index k = Index(count);
            const MatrixXd u = svd.u.leftCols(k), v = space * svd.v.leftCols(k);
            const Eigen::VectorXd sigma = svd.sigma.head(k);
            const double residual = (a.transpose() * u - v * sigma.asDiagonal()).colwise().norm().maxCoeff();
            if (residual <= kResidual * sigma[0] || space.cols() + kKrylovBlock > largest)
                return stored(u, sigma, v, count);
        }
        // 4. The next block is a^T a times this one.
        block = a.transpose() * image.rightCols(kKrylovBlock);
    }
}

}  // namespace

TruncatedSvd truncatedSvd(const Matrix& a, std::size_t count) {
    const auto m = asEigen(a);
    count = std::min({count, a.rows, a.columns});
    if (std::min(m.rows(), m.cols()) > kDirect && count <= std::size_t(kKrylovBlock)) return krylovSvd(m, count);
    const ThinSvd svd = thinSvd(m);
    return stored(svd.u, svd.sigma, svd.v, count);
}

}  // namespace penumbra
