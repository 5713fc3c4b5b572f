#include "fit/numerics/truncated_svd.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>

#include "fit/numerics/eigen_map.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr Index kDirect = 128;        // up to this many rows or columns the whole SVD is cheaper
constexpr Index kKrylovBlock = 24;    // columns a step; more than any run of equal values among those asked for
constexpr Index kLargestSpace = 480;  // 20 steps: no BRDF needed more than 9
constexpr double kResidual = 1e-11;   // of the largest singular value

TruncatedSvd stored(const MatrixXd& u, const Eigen::VectorXd& sigma, const MatrixXd& v, std::size_t count) {
    const std::size_t k = std::min(count, std::size_t(sigma.size()));
    TruncatedSvd out{{sigma.data(), sigma.data() + k}, {k, std::size_t(u.rows())}, {k, std::size_t(v.rows())}};
    for (std::size_t b = 0; b < k; ++b) {
        Index largest = 0;
        u.col(Index(b)).cwiseAbs().maxCoeff(&largest);
        const double sign = u(largest, Index(b)) < 0 ? -1 : 1;  // the routine's sign is arbitrary
        for (Index i = 0; i < u.rows(); ++i) out.u(b, std::size_t(i)) = sign * u(i, Index(b));
        for (Index i = 0; i < v.rows(); ++i) out.v(b, std::size_t(i)) = sign * v(i, Index(b));
    }
    return out;
}

MatrixXd orthonormal(const MatrixXd& m) {
    return Eigen::HouseholderQR<MatrixXd>(m).householderQ() * MatrixXd::Identity(m.rows(), m.cols());
}

// Any full-rank start will do; this one is the same everywhere (numbers of a linear congruential generator).
MatrixXd startOf(Index rows) {
    MatrixXd start(rows, kKrylovBlock);
    std::uint64_t state = 1;
    for (Index i = 0; i < start.size(); ++i) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        start.data()[i] = double(state >> 11) * 0x1p-52 - 1;
    }
    return start;
}

TruncatedSvd krylovSvd(const Eigen::Map<const EigenRows<double>>& a, std::size_t count) {
    const Index largest = std::min({kLargestSpace, a.rows(), a.cols()});
    MatrixXd space(a.cols(), 0), image(a.rows(), 0), block = startOf(a.cols());
    while (true) {
        throwIfInterrupted();
        for (int pass = 0; pass < 2 && space.cols() > 0; ++pass) block -= space * (space.transpose() * block);
        block = orthonormal(block);
        const Index before = space.cols();
        space.conservativeResize(Eigen::NoChange, before + kKrylovBlock);
        image.conservativeResize(Eigen::NoChange, before + kKrylovBlock);
        space.rightCols(kKrylovBlock) = block;
        image.rightCols(kKrylovBlock) = a * block;
        if (space.cols() >= 4 * kKrylovBlock) {
            const Eigen::BDCSVD<MatrixXd> svd(image, Eigen::ComputeThinU | Eigen::ComputeThinV);
            const Index k = Index(count);
            const MatrixXd u = svd.matrixU().leftCols(k), v = space * svd.matrixV().leftCols(k);
            const Eigen::VectorXd sigma = svd.singularValues().head(k);
            const double residual = (a.transpose() * u - v * sigma.asDiagonal()).colwise().norm().maxCoeff();
            if (residual <= kResidual * sigma[0] || space.cols() + kKrylovBlock > largest)
                return stored(u, sigma, v, count);
        }
        block = a.transpose() * image.rightCols(kKrylovBlock);
    }
}

}  // namespace

TruncatedSvd truncatedSvd(const Matrix& a, std::size_t count) {
    const auto m = asEigen(a);
    count = std::min({count, a.rows, a.columns});
    if (std::min(m.rows(), m.cols()) > kDirect && count <= std::size_t(kKrylovBlock)) return krylovSvd(m, count);
    const Eigen::BDCSVD<MatrixXd> svd(MatrixXd(m), Eigen::ComputeThinU | Eigen::ComputeThinV);
    return stored(svd.matrixU(), svd.singularValues(), svd.matrixV(), count);
}

}  // namespace penumbra
