#include "formats/brdf/fit_slices.h"

#include <Eigen/Cholesky>
#include <cassert>
#include <stdexcept>

#include "formats/common/errors.h"
#include "sh/reflectance.h"
#include "sh/sh_basis.h"

namespace penumbra {

std::vector<double> evenBasisTable(const std::vector<Vec3d>& views, int view_order) {
    const std::vector<int> even = evenIndices(view_order);
    std::vector<double> table, y(std::size_t(coefficientCount(view_order)));
    for (Vec3d view : views) {
        evalBasis(view_order, view, y);
        for (int index : even) table.push_back(y[std::size_t(index)]);
    }
    return table;
}

std::vector<double> fitSlices(const SliceTable& table, const SliceOrders& orders) {
    const std::size_t rows = std::size_t(kSliceChannels * coefficientCount(orders.slice_order)),
                      columns = evenIndices(orders.view_order).size();
    assert(table.slices.size() == table.views.size() * rows);
    const std::vector<double> y = evenBasisTable(table.views, orders.view_order);
    // 1. Sum the normal equations: the Gram matrix of the view functions and the right side of every row.
    const auto views = Eigen::Index(table.views.size());
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const Eigen::Map<const RowMajor> basis(y.data(), views, Eigen::Index(columns)),
        slices(table.slices.data(), views, Eigen::Index(rows));
    const Eigen::MatrixXd weighted =
        Eigen::Map<const Eigen::VectorXd>(table.weights.data(), views).asDiagonal() * basis;
    const Eigen::MatrixXd gram = weighted.transpose() * basis;
    // 2. Solve them for every row.
    Eigen::MatrixXd by_row = weighted.transpose() * slices;  // [E, 3 J^2]
    const Eigen::LLT<Eigen::MatrixXd> factor(gram);
    if (factor.info() != Eigen::Success) throw std::logic_error("the views of a slice table are too few");
    by_row = factor.solve(by_row);
    std::vector<double> c(rows * columns);
    for (std::size_t i = 0; i < rows; ++i)
        for (std::size_t e = 0; e < columns; ++e)
            c[(i / kSliceChannels * columns + e) * kSliceChannels + i % kSliceChannels] =
                by_row(Eigen::Index(e), Eigen::Index(i));
    return c;
}

SliceTable settledSlices(const RgbBrdf& source, int slice_order, int threads) {
    SliceTable table = refinedSlices(source, slice_order, threads);
    if (!(table.refinement <= kSettled))
        throw InvalidInput("BRDF " + source.name + ": it changes too abruptly to tabulate (slices still change by " +
                           std::to_string(table.refinement) + ")");
    return table;
}

}  // namespace penumbra
