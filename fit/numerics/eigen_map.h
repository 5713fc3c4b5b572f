#pragma once
// Lets Eigen work on our matrices without a copy. Only .cpp files include it, so that no other header needs Eigen.
#include <Eigen/Core>

#include "fit/numerics/matrix.h"

namespace penumbra {

template <class T>
using EigenRows = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

template <class T>
Eigen::Map<EigenRows<T>> asEigen(BasicMatrix<T>& m) {
    return {m.values.data(), Eigen::Index(m.rows), Eigen::Index(m.columns)};
}
template <class T>
Eigen::Map<const EigenRows<T>> asEigen(const BasicMatrix<T>& m) {
    return {m.values.data(), Eigen::Index(m.rows), Eigen::Index(m.columns)};
}

}  // namespace penumbra
