#include "fit/reflectance/fit_brdf.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fit/numerics/matrix.h"
#include "sh/reflectance.h"

namespace penumbra {

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
