// Computes the largest principal components of a large matrix in several passes over its columns.
//
// Problem: Nowrouzezahrai 2007 stacks one row a pose and coefficient, of one number a vertex: 15,480 x 11,534 for its
// first character. 22 or 500 of the principal components are wanted.
//
// Naive: the Gram matrix of the smaller side takes 1 GB, and its eigenvectors minutes.
//
// Here: a randomised subspace iteration (Halko, Martinsson and Tropp 2011, algorithm 4.4). A random combination of the
// columns is multiplied by M M^T again and again and made orthonormal, and turns towards the leading left singular
// vectors. The space is wider than what is asked for, so that it converges in some passes. M M^T Q is a sum over blocks
// of columns, and the mean of a column needs that column alone, so that one block at a time lies in memory.
#include "fit/numerics/leading_components.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "fit/numerics/dense_solvers.h"
#include "fit/numerics/eigen_map.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Rows = EigenRows<float>;

constexpr std::size_t kMinExtra = 20, kExtraShare = 5;  // columns beside those asked for: 20, or a fifth of them
constexpr int kMaxSweeps = 12;
constexpr double kConverged = 1e-5;   // relative to the total energy
constexpr double kMinEnergy = 1e-10;  // relative to the total energy; floats do not resolve smaller components
constexpr Index kTile = 64;           // columns or rows that one task multiplies; fixed, so results are too

// Numbers in [-1, 1) that depend on the place alone, so that every machine starts alike (splitmix64).
float randomAt(std::uint64_t row, std::uint64_t column) {
    std::uint64_t x = row * 0x9e3779b97f4a7c15u + (column + 1) * 0xd1b54a32d192ed03u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return float(double((x ^ (x >> 31)) >> 11) * 0x1p-52 - 1);
}

// Calls body(first, count) for the tiles of [0, size).
template <class Body>
void overTiles(Index size, int threads, const Body& body) {
    parallelFor(std::size_t((size + kTile - 1) / kTile), threads, [&](std::size_t tile) {
        const Index first = Index(tile) * kTile;
        body(first, std::min(kTile, size - first));
    });
}

// Takes the mean off every column and returns the means.
std::vector<float> center(MatrixF& block, int threads) {
    std::vector<float> mean(block.columns);
    auto m = asEigen(block);
    overTiles(m.cols(), threads, [&](Index first, Index count) {
        const Eigen::RowVectorXd of_tile = m.middleCols(first, count).template cast<double>().colwise().mean();
        m.middleCols(first, count).rowwise() -= of_tile.cast<float>();
        for (Index c = 0; c < count; ++c) mean[std::size_t(first + c)] = float(of_tile[c]);
    });
    return mean;
}

// Returns block^T q.
Rows transposedTimes(const MatrixF& block, const Rows& q, int threads) {
    const auto m = asEigen(block);
    Rows out(m.cols(), q.cols());
    overTiles(m.cols(), threads, [&](Index first, Index count) {
        out.middleRows(first, count).noalias() = m.middleCols(first, count).transpose() * q;
    });
    return out;
}

// Adds block z to `sum`.
template <class Sum>
void addProduct(const MatrixF& block, const Rows& z, int threads, Sum& sum) {
    const auto m = asEigen(block);
    overTiles(m.rows(), threads, [&](Index first, Index count) {
        const Rows product = m.middleRows(first, count) * z;
        sum.middleRows(first, count) += product.template cast<typename Sum::Scalar>();
    });
}

// The product of the matrix with random columns, and the energy of the matrix.
Rows randomImage(const ColumnBlocks& matrix, Index width, int threads, double& total) {
    Rows image = Rows::Zero(Index(matrix.rows), width);
    std::size_t at = 0;
    for (std::size_t b = 0; b < matrix.count; ++b) {
        throwIfInterrupted();
        MatrixF block = matrix.read(b);
        center(block, threads);
        for (std::size_t r = 0; r < block.rows; ++r) total += double(asEigen(block).row(Index(r)).squaredNorm());
        Rows random(Index(block.columns), width);
        for (Index c = 0; c < random.rows(); ++c)
            for (Index k = 0; k < width; ++k) random(c, k) = randomAt(at + std::size_t(c), std::uint64_t(k));
        addProduct(block, random, threads, image);
        at += block.columns;
    }
    return image;
}

// One pass: gram = (M^T q)^T (M^T q), and image = M M^T q.
struct Pass {
    MatrixXd gram;
    Rows image;
};

Pass multiply(const ColumnBlocks& matrix, const Rows& q, int threads) {
    Pass pass{MatrixXd::Zero(q.cols(), q.cols()), Rows::Zero(q.rows(), q.cols())};
    for (std::size_t b = 0; b < matrix.count; ++b) {
        throwIfInterrupted();
        MatrixF block = matrix.read(b);
        center(block, threads);
        const Rows z = transposedTimes(block, q, threads);
        const MatrixXd transposed = z.transpose().cast<double>();
        pass.gram.selfadjointView<Eigen::Lower>().rankUpdate(transposed);
        addProduct(block, z, threads, pass.image);
    }
    return pass;
}

// Keeps the `count` leading directions of the space. The entry of largest magnitude of each is made positive.
LeadingSpace leadingOf(const Rows& q, const EigenPairs& pairs, std::size_t count, double total) {
    LeadingSpace space;
    space.total = total;
    space.u = MatrixF(std::size_t(q.rows()), count);
    MatrixXd vectors = pairs.vectors.rowwise().reverse().leftCols(Index(count));
    Rows u = q * vectors.cast<float>();
    for (Index k = 0; k < u.cols(); ++k) {
        u.col(k) *= float(signOf(u.col(k)));
        space.energies.push_back(std::max(pairs.values[pairs.values.size() - 1 - k], 0.0));
    }
    asEigen(space.u) = u;
    return space;
}

}  // namespace

LeadingSpace leadingSpace(const ColumnBlocks& matrix, std::size_t count, int threads) {
    const std::size_t rank = std::min(matrix.rows, matrix.columns);
    count = std::min(count, rank);
    const std::size_t width = std::min(rank, count + std::max(kMinExtra, count / kExtraShare));
    double total = 0, before = -1;
    // 1. A random combination of columns.
    Rows image = randomImage(matrix, Index(width), threads, total);
    for (int passes = 1;; ++passes) {
        // 2. Make it orthonormal, and measure how much energy each direction of its span has.
        const Rows q = orthonormalColumns(image.cast<double>()).cast<float>();
        Pass pass = multiply(matrix, q, threads);
        const EigenPairs pairs = symmetricEigenPairs(pass.gram);
        const double captured = pairs.values.tail(Index(count)).sum();
        // 3. Stop when another product gains nothing more, else go on with the product.
        if (width == rank || passes == kMaxSweeps || captured - before <= kConverged * total)
            return leadingOf(q, pairs, count, total);
        before = captured;
        image = std::move(pass.image);
    }
}

LeadingComponents componentsIn(const LeadingSpace& space, const ColumnBlocks& matrix, int threads) {
    const std::size_t k = space.energies.size();
    LeadingComponents out;
    out.basis = MatrixF(k, matrix.columns);
    out.scores = Matrix(matrix.rows, k);
    const Rows u = asEigen(space.u);
    Eigen::RowVectorXf inverse(static_cast<Index>(k));
    for (std::size_t i = 0; i < k; ++i)
        inverse[Index(i)] = space.energies[i] > kMinEnergy * space.total ? float(1 / std::sqrt(space.energies[i])) : 0;
    auto scores = asEigen(out.scores);
    for (std::size_t b = 0; b < matrix.count; ++b) {
        throwIfInterrupted();
        MatrixF block = matrix.read(b);
        const std::vector<float> mean = center(block, threads);
        const Rows basis = transposedTimes(block, u, threads) * inverse.asDiagonal();  // [columns of the block, k]
        addProduct(block, basis, threads, scores);
        asEigen(out.basis).middleCols(Index(out.mean.size()), basis.rows()) = basis.transpose();
        out.mean.insert(out.mean.end(), mean.begin(), mean.end());
    }
    return out;
}

}  // namespace penumbra
