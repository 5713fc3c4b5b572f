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

// The sign that makes the entry of largest magnitude positive; the sign that a decomposition returns is arbitrary.
template <class Vector>
int signOf(const Vector& v) {
    Eigen::Index largest = 0;
    v.cwiseAbs().maxCoeff(&largest);
    return v[largest] < 0 ? -1 : 1;
}

}  // namespace penumbra
