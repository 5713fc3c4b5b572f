#include "fit/reflectance/fit_brdf.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "fit/numerics/dense_solvers.h"
#include "fit/numerics/matrix.h"
#include "formats/common/errors.h"
#include "sh/reflectance.h"

namespace penumbra {

namespace {

// Returns y_even of every view, [views, E].
std::vector<double> evenBasisTable(const std::vector<Vec3d>& views, int view_order) {
    const std::vector<int> even = evenIndices(view_order);
    std::vector<double> table, y(std::size_t(coefficientCount(view_order)));
    for (Vec3d view : views) {
        evalBasis(view_order, view, y);
        for (int index : even) table.push_back(y[std::size_t(index)]);
    }
    return table;
}

}  // namespace

std::vector<double> fitSlices(const SliceTable& table, const SliceOrders& orders) {
    const std::size_t rows = std::size_t(kSliceChannels * coefficientCount(orders.slice_order)),
                      columns = evenIndices(orders.view_order).size();
    assert(table.slices.size() == table.views.size() * rows);
    const std::vector<double> y = evenBasisTable(table.views, orders.view_order);
    // 1. Sum the normal equations: the Gram matrix of the view functions and the right side of every row.
    const auto views = Eigen::Index(table.views.size());
    const Eigen::Map<const RowMajorXd> basis(y.data(), views, Eigen::Index(columns)),
        slices(table.slices.data(), views, Eigen::Index(rows));
    const Eigen::MatrixXd weighted =
        Eigen::Map<const Eigen::VectorXd>(table.weights.data(), views).asDiagonal() * basis;
    const Eigen::MatrixXd gram = weighted.transpose() * basis;
    // 2. Solve them for every row.
    Eigen::MatrixXd by_row = weighted.transpose() * slices;  // [E, 3 J^2]
    if (!solvePositive(gram, by_row, by_row)) throw std::logic_error("the views of a slice table are too few");
    std::vector<double> c(rows * columns);
    for (std::size_t i = 0; i < rows; ++i)
        for (std::size_t e = 0; e < columns; ++e)
            c[(i / kSliceChannels * columns + e) * kSliceChannels + i % kSliceChannels] =
                by_row(Eigen::Index(e), Eigen::Index(i));
    return c;
}

namespace {

// Returns sqrt(sum w z |F - C y|^2 / sum w z |F|^2) over all channels.
double fitError(const SliceTable& table, const std::vector<double>& c, int view_order) {
    const std::size_t columns = evenIndices(view_order).size(), rows = c.size() / columns;
    const std::vector<double> y = evenBasisTable(table.views, view_order);
    RelativeRms error;
    for (std::size_t o = 0; o < table.views.size(); ++o)
        for (std::size_t i = 0; i < rows; ++i) {
            double fitted = 0;
            for (std::size_t e = 0; e < columns; ++e)
                fitted +=
                    c[(i / kSliceChannels * columns + e) * kSliceChannels + i % kSliceChannels] * y[o * columns + e];
            error.add(fitted, table.slices[o * rows + i], table.weights[o]);
        }
    return error.value();
}

// The directional albedo of a view is sqrt(4pi) F_0, because y_0 is constant. `mean` weighs the views by their cosine.
struct Albedo {
    Vec3d mean;
    double largest = 0;
};
Albedo albedoOf(const SliceTable& table) {
    const std::size_t rows = table.slices.size() / table.views.size();
    Albedo albedo;
    double weight = 0;
    for (std::size_t o = 0; o < table.views.size(); ++o) {
        weight += table.weights[o];
        for (int channel = 0; channel < kSliceChannels; ++channel) {
            const double value = std::sqrt(4 * std::numbers::pi) * table.slices[o * rows + std::size_t(channel)];
            albedo.mean[channel] += table.weights[o] * value;
            albedo.largest = std::max(albedo.largest, value);
        }
    }
    albedo.mean = albedo.mean / weight;
    return albedo;
}

}  // namespace

SliceTable settledSlices(const RgbBrdf& source, int slice_order, int threads) {
    SliceTable table = refinedSlices(source, slice_order, threads);
    if (!(table.refinement <= kSettled))
        throw InvalidInput("BRDF " + source.name + ": it changes too abruptly to tabulate (slices still change by " +
                           std::to_string(table.refinement) + ")");
    return table;
}

BrdfFile fitBrdf(const RgbBrdf& source, const SliceOrders& orders, int threads) {
    const SliceTable table = settledSlices(source, orders.slice_order, threads);
    BrdfFile brdf;
    brdf.name = source.name;
    brdf.slice_order = orders.slice_order;
    brdf.view_order = orders.view_order;
    brdf.even_index = evenIndices(orders.view_order);
    brdf.slices = fitSlices(table, orders);
    const Albedo albedo = albedoOf(table);
    brdf.errors = {{"fit", fitError(table, brdf.slices, orders.view_order)},
                   {"refinement", table.refinement},
                   {"albedo_r", albedo.mean.x},
                   {"albedo_g", albedo.mean.y},
                   {"albedo_b", albedo.mean.z},
                   {"albedo_max", std::max(albedo.largest, largestAlbedo(source, threads))}};
    return brdf;
}

}  // namespace penumbra
