#include "fit/slice_table.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <span>

#include "formats/parallel_for.h"
#include "formats/write_file.h"
#include "sh/quadrature.h"
#include "sh/sh_basis.h"

namespace penumbra {

// Adds directions to F_i(o) one after the other, in a fixed order, so that the sum does not depend on threads.
struct SliceSum {
    const BrdfFunction& brdf;
    Vec3d view;
    std::span<double> slice;
    int order = bandOfIndex(int(slice.size()) - 1) + 1;
    std::array<double, coefficientCount(kMaxOrder)> storage{};

    void add(Vec3d incident, double weight) {
        const double value = brdf(incident, view) * incident.z * weight;
        if (value == 0) return;
        const std::span<double> y = std::span(storage).first(slice.size());
        evalBasis(order, incident, y);
        for (std::size_t i = 0; i < slice.size(); ++i) slice[i] += value * y[i];
    }
};

// At grazing views a lobe of width a is only a (z_i + z_o) wide in azimuth, so azimuths are taken from the mirror
// direction on as +- c (z_i + z_o) sinh(b u), and heights as z = t^2; t and u are Gauss-Legendre nodes on (0, 1).
static void integrateAroundMirror(const std::vector<WeightedDirection>& t_nodes,
                                  const std::vector<WeightedDirection>& u_nodes, SliceSum& sum) {
    constexpr double kWidth = 0.1;  // c: the narrowest lobe that the coarsest grid should see
    const double mirror = std::atan2(-sum.view.y, -sum.view.x);
    for (const auto& [t, t_weight] : t_nodes) {
        const double z = t.z * t.z, sine = std::sqrt(1 - z * z), dz = 2 * t.z * t_weight / (2 * std::numbers::pi);
        const double scale = kWidth * (z + sum.view.z), b = std::asinh(std::numbers::pi / scale);
        for (const auto& [u, u_weight] : u_nodes) {
            const double offset = scale * std::sinh(b * u.z);
            const double weight = dz * scale * b * std::cosh(b * u.z) * u_weight / (2 * std::numbers::pi);
            for (double azimuth : {mirror + offset, mirror - offset})
                sum.add({sine * std::cos(azimuth), sine * std::sin(azimuth), z}, weight);
        }
    }
}

// f(s) -> f(Rz(angle)^-1 s): pairs (m, -m) turn by m angle.
static void rotateAboutNormal(double angle, std::span<const double> in, std::span<double> out) {
    for (int l = 0; coefficientCount(l) < int(in.size()); ++l) {
        out[shIndex(l, 0)] = in[shIndex(l, 0)];
        for (int m = 1; m <= l; ++m) {
            const double c = std::cos(m * angle), s = std::sin(m * angle);
            const double plus = in[shIndex(l, m)], minus = in[shIndex(l, -m)];
            out[shIndex(l, m)] = c * plus - s * minus;
            out[shIndex(l, -m)] = s * plus + c * minus;
        }
    }
}

// y -> -y keeps cosines and flips sines; x -> -x does the same after (-1)^m on both.
static void mirror(bool flip_x, bool flip_y, std::span<double> slice) {
    for (int l = 0; coefficientCount(l) < int(slice.size()); ++l)
        for (int m = -l; m <= l; ++m) {
            const bool sine_sign = (m < 0) && (flip_x != flip_y), odd_sign = flip_x && m % 2 != 0;
            if (sine_sign != odd_sign) slice[shIndex(l, m)] = -slice[shIndex(l, m)];
        }
}

// Row of the table that azimuth j of n (a multiple of 4) can be made from: isotropic BRDFs need azimuth 0 only, the
// others here are symmetric to the planes x = 0 and y = 0 and need the first quadrant.
static int sourceAzimuth(bool isotropic, int j, int n) {
    if (isotropic) return 0;
    const int k = j > n / 2 ? n - j : j;
    return k > n / 4 ? n / 2 - k : k;
}

// The view grid; slices are zero.
static SliceTable makeTable(int slice_order, int view_n_z) {
    assert(view_n_z % 2 == 0);
    SliceTable table;
    for (const auto& [direction, weight] : gaussHemisphere(view_n_z, 2 * view_n_z)) {
        table.views.push_back(direction);
        table.weights.push_back(weight * direction.z);
    }
    table.view_n_z = view_n_z;
    table.slices.resize(table.views.size() * std::size_t(coefficientCount(slice_order)));
    return table;
}

static std::span<double> sliceOf(SliceTable& table, std::size_t view) {
    const std::size_t count = table.slices.size() / table.views.size();
    return std::span(table.slices).subspan(view * count, count);
}

// Views that must be integrated; the others follow from them.
static std::vector<std::size_t> sourceViews(const SliceTable& table, bool isotropic) {
    const int azimuths = 2 * table.view_n_z;
    std::vector<std::size_t> views;
    for (int view = 0; view < int(table.views.size()); ++view)
        if (sourceAzimuth(isotropic, view % azimuths, azimuths) == view % azimuths) views.push_back(std::size_t(view));
    return views;
}

static void spreadBySymmetry(SliceTable& table, bool isotropic) {
    const int azimuths = 2 * table.view_n_z;
    for (int view = 0; view < int(table.views.size()); ++view) {
        const int j = view % azimuths, source = sourceAzimuth(isotropic, j, azimuths);
        if (source == j) continue;
        const auto from = sliceOf(table, std::size_t(view - j + source)), to = sliceOf(table, std::size_t(view));
        if (isotropic) {
            rotateAboutNormal(2 * std::numbers::pi * j / azimuths, from, to);
        } else {
            std::copy(from.begin(), from.end(), to.begin());
            mirror(j > azimuths / 4 && j<3 * azimuths / 4, j> azimuths / 2, to);
        }
    }
}

// Integrates `views` anew; returns w z |change of F|^2 of each.
using Integrate = std::function<void(SliceSum&)>;
static std::vector<double> integrateViews(const BrdfFunction& brdf, const Integrate& integrate,
                                          const std::vector<std::size_t>& views, int threads, SliceTable& table) {
    std::vector<double> change(views.size());
    parallelFor(views.size(), threads, [&](std::size_t k) {
        throwIfInterrupted();
        const std::span<double> to = sliceOf(table, views[k]);
        std::vector<double> slice(to.size());
        SliceSum sum{brdf, table.views[views[k]], slice};
        integrate(sum);
        for (std::size_t i = 0; i < slice.size(); ++i)
            change[k] += table.weights[views[k]] * (slice[i] - to[i]) * (slice[i] - to[i]);
        std::copy(slice.begin(), slice.end(), to.begin());
    });
    return change;
}

SliceTable tabulateSlices(const BrdfSpec& spec, int slice_order, int incident_n_z, int view_n_z, int threads) {
    SliceTable table = makeTable(slice_order, view_n_z);
    const bool isotropic = isIsotropic(spec);
    const std::vector<WeightedDirection> grid = gaussHemisphere(incident_n_z, 2 * incident_n_z);
    const auto integrate = [&grid](SliceSum& sum) {
        for (const auto& [direction, weight] : grid) sum.add(direction, weight);
    };
    integrateViews(brdfFunction(spec), integrate, sourceViews(table, isotropic), threads, table);
    spreadBySymmetry(table, isotropic);
    return table;
}

SliceTable refinedSlices(const BrdfSpec& spec, int slice_order, int threads) {
    constexpr int kViewNz = 32, kCoarsest = 32, kFinest = 512;
    SliceTable table = makeTable(slice_order, kViewNz);
    const bool isotropic = isIsotropic(spec);
    const BrdfFunction brdf = brdfFunction(spec);
    std::vector<std::size_t> views = sourceViews(table, isotropic);
    const double enough = 0.25 * kSettled * kSettled / double(views.size());  // leaves as much to views still open
    const auto sum = [](const std::vector<double>& values) { return std::reduce(values.begin(), values.end()); };
    const auto integrateAll = [&](int n) {
        const auto t_nodes = gaussHemisphere(n, 1), u_nodes = gaussHemisphere(n / 2, 1);
        return integrateViews(
            brdf, [&](SliceSum& slice) { integrateAroundMirror(t_nodes, u_nodes, slice); }, views, threads, table);
    };
    const double total = sum(integrateAll(kCoarsest));
    double settled_change = 0, open_change = total;
    for (int n = 2 * kCoarsest; n <= kFinest && !views.empty(); n *= 2) {
        const std::vector<double> change = integrateAll(n);
        std::vector<std::size_t> open;
        open_change = 0;
        for (std::size_t k = 0; k < views.size(); ++k) {
            const bool settled = change[k] <= enough * total;
            (settled ? settled_change : open_change) += change[k];
            if (!settled) open.push_back(views[k]);
        }
        if (settled_change + open_change <= kSettled * kSettled * total) break;
        views = std::move(open);
    }
    table.refinement = total > 0 ? std::sqrt((settled_change + open_change) / total) : 0;
    spreadBySymmetry(table, isotropic);
    return table;
}

}  // namespace penumbra
