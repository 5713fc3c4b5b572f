#include "fit/fit_brdf.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "fit/cholesky.h"
#include "formats/errors.h"
#include "sh/reflectance.h"

namespace penumbra {

static std::vector<double> evenBasisTable(const std::vector<Vec3d>& views, int view_order) {
    const std::vector<int> even = evenIndices(view_order);
    std::vector<double> table, y(std::size_t(coefficientCount(view_order)));
    for (Vec3d view : views) {
        evalBasis(view_order, view, y);
        for (int index : even) table.push_back(y[std::size_t(index)]);
    }
    return table;
}

std::vector<double> fitSlices(const SliceTable& table, const SliceOrders& orders) {
    const std::size_t rows = std::size_t(coefficientCount(orders.slice_order)),
                      columns = evenIndices(orders.view_order).size();
    assert(table.slices.size() == table.views.size() * rows);
    const std::vector<double> y = evenBasisTable(table.views, orders.view_order);
    std::vector<double> gram(columns * columns), c(rows * columns);
    for (std::size_t o = 0; o < table.views.size(); ++o)
        for (std::size_t e = 0; e < columns; ++e) {
            const double weighted = table.weights[o] * y[o * columns + e];
            for (std::size_t d = 0; d < columns; ++d) gram[e * columns + d] += weighted * y[o * columns + d];
            for (std::size_t i = 0; i < rows; ++i) c[i * columns + e] += weighted * table.slices[o * rows + i];
        }
    factorCholesky(gram, columns);
    for (std::size_t i = 0; i < rows; ++i) solveCholesky(gram, std::span(c).subspan(i * columns, columns));
    return c;
}

// sqrt(sum w z |F - C y|^2 / sum w z |F|^2)
static double fitError(const SliceTable& table, const std::vector<double>& c, int view_order) {
    const std::size_t columns = evenIndices(view_order).size(), rows = c.size() / columns;
    const std::vector<double> y = evenBasisTable(table.views, view_order);
    double error = 0, total = 0;
    for (std::size_t o = 0; o < table.views.size(); ++o)
        for (std::size_t i = 0; i < rows; ++i) {
            double fitted = 0;
            for (std::size_t e = 0; e < columns; ++e) fitted += c[i * columns + e] * y[o * columns + e];
            const double exact = table.slices[o * rows + i];
            error += table.weights[o] * (fitted - exact) * (fitted - exact);
            total += table.weights[o] * exact * exact;
        }
    return total > 0 ? std::sqrt(error / total) : 0;
}

// Directional albedo of a view is sqrt(4pi) F_0, because y_0 is constant. `mean` weighs views by their cosine.
struct Albedo {
    double mean = 0, largest = 0;
};
static Albedo albedoOf(const SliceTable& table) {
    const std::size_t rows = table.slices.size() / table.views.size();
    Albedo albedo;
    double weight = 0;
    for (std::size_t o = 0; o < table.views.size(); ++o) {
        const double value = std::sqrt(4 * std::numbers::pi) * table.slices[o * rows];
        albedo.mean += table.weights[o] * value;
        albedo.largest = std::max(albedo.largest, value);
        weight += table.weights[o];
    }
    albedo.mean /= weight;
    return albedo;
}

BrdfFile fitBrdf(const BrdfSpec& spec, const SliceOrders& orders, int threads) {
    const SliceTable table = refinedSlices(spec, orders.slice_order, threads);
    if (table.refinement > kSettled)
        throw InvalidInput("BRDF " + toString(spec) + ": its lobe is too narrow to tabulate (slices still change by " +
                           std::to_string(table.refinement) + ")");
    const std::vector<double> c = fitSlices(table, orders);
    BrdfFile brdf;
    brdf.name = toString(spec);
    brdf.slice_order = orders.slice_order;
    brdf.view_order = orders.view_order;
    brdf.even_index = evenIndices(orders.view_order);
    for (double value : c)
        for (int channel = 0; channel < 3; ++channel) brdf.slices.push_back(value * spec.color[channel]);
    const Albedo albedo = albedoOf(table);
    brdf.errors = {{"fit", fitError(table, c, orders.view_order)},
                   {"refinement", table.refinement},
                   {"albedo_r", albedo.mean * spec.color.x},
                   {"albedo_g", albedo.mean * spec.color.y},
                   {"albedo_b", albedo.mean * spec.color.z},
                   {"albedo_max", albedo.largest * std::max({spec.color.x, spec.color.y, spec.color.z})}};
    return brdf;
}

}  // namespace penumbra
