#include "pack/compress/span_projector.h"

#include <algorithm>

#include "pack/compress/dense_solvers.h"

namespace penumbra {

namespace {

Eigen::VectorXd asVector(std::span<const float> values) {
    return Eigen::Map<const Eigen::VectorXf>(values.data(), Eigen::Index(values.size())).cast<double>();
}

}  // namespace

SpanProjector::SpanProjector(const std::vector<float>& basis, std::size_t length) {
    const auto columns = Eigen::Index(length > 0 ? basis.size() / length : 0);
    Eigen::MatrixXd directions =
        Eigen::Map<const Eigen::MatrixXf>(basis.data(), Eigen::Index(length), columns).cast<double>();
    for (Eigen::Index k = 0; k < columns; ++k) directions.col(k).normalize();  // leaves columns of zeros alone
    axes_ = orthonormalSpan(directions, 3e-5);
}

double SpanProjector::squaredDistance(std::span<const float> point, std::span<const float> origin) const {
    const Eigen::VectorXd difference = asVector(point) - asVector(origin);
    return std::max(0.0, difference.squaredNorm() - (axes_.transpose() * difference).squaredNorm());
}

void SpanProjector::project(std::span<const float> point, std::span<const float> origin, std::span<float> out) const {
    const Eigen::VectorXd from = asVector(origin), along = axes_.transpose() * (asVector(point) - from);
    Eigen::Map<Eigen::VectorXf>(out.data(), Eigen::Index(out.size())) = (from + axes_ * along).cast<float>();
}

}  // namespace penumbra
