// Tabulates the cosine-weighted BRDF as seen from many views, projected on SH.
//
// Problem: every view needs the integral of f cos y_i over the hemisphere. The lobe of f may be much narrower than any
// affordable grid, and it usually lies at the mirror direction of the view.
//
// Naive: use one product grid for all views (tabulateSlices, kept as the reference). It misses narrow lobes, or wastes
// points on wide ones.
//
// Here: heights and azimuths are graded towards the mirror direction by x = a sinh(b u), at the scale of the lobe,
// which is probed first. Grids are doubled view by view until the slices of the view no longer change. Views that
// follow from others by the symmetry of the BRDF are not integrated at all.
//
// See docs/formulas.md, section 3 (tabulation).

#include "formats/brdf/slice_table.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <span>

#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "sh/quadrature.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

// --- One integral ---------------------------------------------------------------------------------------------------

// Integrates F(o) of one view on the nodes of any grid over the hemisphere. Nodes are added one after the other, so the
// sum does not depend on threads.
void integrateOnGrid(const RgbBrdf& brdf, Vec3d view, const std::vector<WeightedDirection>& grid,
                     std::span<double> slice) {
    const int count = int(slice.size()) / kSliceChannels, order = bandOfIndex(count - 1) + 1;
    std::array<double, coefficientCount(kMaxOrder)> storage;
    const std::span<double> y = std::span(storage).first(std::size_t(count));
    for (const auto& [direction, weight] : grid) {
        const Vec3d value = brdf.eval(direction, view) * (direction.z * weight);
        evalBasis(order, direction, y);
        for (std::size_t i = 0; i < y.size(); ++i)
            for (int c = 0; c < kSliceChannels; ++c) slice[kSliceChannels * i + std::size_t(c)] += value[c] * y[i];
    }
}

// Sums over directions of one height. y_l+-m is A_lm(z) times cos m phi or sin m phi, so a direction adds to 2J - 1
// sums only.
struct Ring {
    int order;
    std::array<Vec3d, kMaxOrder> cosines{}, sines{};  // sums over directions of value cos m phi and value sin m phi

    // Adds a direction with the given cosine and sine of its azimuth. cos m phi and sin m phi come by recurrence.
    void add(Vec3d value, double cosine, double sine) {
        double c = 1, s = 0;
        for (std::size_t m = 0; m < std::size_t(order); ++m) {
            cosines[m] += value * c;
            sines[m] += value * s;
            const double next = c * cosine - s * sine;
            s = s * cosine + c * sine;
            c = next;
        }
    }
};

// Adds the sums of a ring at height z to the slice.
void addRing(const Ring& ring, double z, double sine, std::span<double> slice) {
    std::array<double, coefficientCount(kMaxOrder)> storage;
    const std::span<double> y = std::span(storage).first(std::size_t(coefficientCount(ring.order)));
    evalBasis(ring.order, Vec3d{sine, 0, z}, y);
    for (int l = 0; l < ring.order; ++l)
        for (int m = 0; m <= l; ++m)
            for (int c = 0; c < kSliceChannels; ++c) {
                const double a = y[std::size_t(shIndex(l, m))];
                slice[std::size_t(kSliceChannels * shIndex(l, m) + c)] += a * ring.cosines[std::size_t(m)][c];
                if (m > 0) slice[std::size_t(kSliceChannels * shIndex(l, -m) + c)] += a * ring.sines[std::size_t(m)][c];
            }
}

// The width of a lobe at the mirror direction. Half of the value there is left at distance `t` in sqrt(z), and at
// azimuth distance azimuth * (z_i + z_o): at grazing views a lobe of width a is only a (z_i + z_o) wide in azimuth.
struct LobeWidth {
    double t, azimuth;
};

// Probes the lobe at doubling distances.
LobeWidth lobeWidth(const RgbBrdf& brdf, Vec3d view) {
    constexpr double kMin = 1e-4, kMax = 0.1;
    const double t_o = std::sqrt(view.z), mirror = std::atan2(-view.y, -view.x);
    const auto value = [&](double t, double azimuth) {
        const double z = t * t, r = std::sqrt(std::max(0.0, 1 - z * z));
        const Vec3d f = brdf.eval({r * std::cos(azimuth), r * std::sin(azimuth), z}, view);
        return f.x + f.y + f.z;
    };
    const double half = value(t_o, mirror) / 2;
    if (half <= 0) return {kMax, kMax};
    LobeWidth width{kMin, kMin};
    const auto wideInT = [&](double d) {
        return (t_o + d >= 1 || value(t_o + d, mirror) > half) && (t_o - d <= 0 || value(t_o - d, mirror) > half);
    };
    while (width.t < kMax && wideInT(width.t)) width.t *= 2;
    const auto wideInAzimuth = [&](double d) {
        const double angle = 2 * view.z * d;
        return angle > std::numbers::pi || (value(t_o, mirror + angle) > half && value(t_o, mirror - angle) > half);
    };
    while (width.azimuth < kMax && wideInAzimuth(width.azimuth)) width.azimuth *= 2;
    return {std::min(width.t, kMax), std::min(width.azimuth, kMax)};
}

// The substitution x = scale sinh(b u) takes Gauss-Legendre nodes u on (0, 1) to (0, range), and makes them dense at 0.
struct Graded {
    double scale, b;
    Graded(double least, double range) : scale(least), b(std::asinh(range / least)) {}
    WeightedNumber at(const WeightedNumber& u) const {
        return {scale * std::sinh(b * u.x), scale * b * std::cosh(b * u.x) * u.weight};
    }
};

// Integrates F(o) of one view with heights z = t^2 on both sides of the mirror direction's, and azimuths on both sides
// of its azimuth.
void integrateAroundMirror(const RgbBrdf& brdf, Vec3d view, const std::vector<WeightedNumber>& nodes,
                           std::span<double> slice) {
    const LobeWidth width = lobeWidth(brdf, view);
    const double t_o = std::sqrt(view.z), radius = std::hypot(view.x, view.y);
    const double mirror_cosine = radius > 0 ? -view.x / radius : 1, mirror_sine = radius > 0 ? -view.y / radius : 0;
    const int order = bandOfIndex(int(slice.size()) / kSliceChannels - 1) + 1;
    // Takes heights z = t^2 below and above the mirror direction's.
    for (double side : {-1.0, 1.0}) {
        const Graded heights(width.t, side < 0 ? t_o : 1 - t_o);
        for (const WeightedNumber& node : nodes) {
            const auto [distance, dt] = heights.at(node);
            const double t = t_o + side * distance, z = t * t, r = std::sqrt(std::max(0.0, 1 - z * z));
            const Graded azimuths(width.azimuth * (z + view.z), std::numbers::pi);
            Ring ring{order};
            for (const WeightedNumber& u : nodes) {
                const auto [offset, weight] = azimuths.at(u);
                const double c = std::cos(offset), s = std::sin(offset), factor = z * 2 * t * dt * weight;
                for (double sign : {1.0, -1.0}) {
                    const double cosine = mirror_cosine * c - sign * mirror_sine * s,
                                 sine = mirror_sine * c + sign * mirror_cosine * s;
                    ring.add(brdf.eval({r * cosine, r * sine, z}, view) * factor, cosine, sine);
                }
            }
            addRing(ring, z, r, slice);
        }
    }
}

// --- Symmetries -----------------------------------------------------------------------------------------------------

// Turns a slice by an angle about the normal: f(s) becomes f(Rz(angle)^-1 s). The pair (m, -m) turns by m angle.
void rotateAboutNormal(double angle, std::span<const double> in, std::span<double> out) {
    for (int l = 0; kSliceChannels * coefficientCount(l) < int(in.size()); ++l)
        for (int m = 0; m <= l; ++m) {
            const double cosine = std::cos(m * angle), sine = std::sin(m * angle);
            for (int c = 0; c < kSliceChannels; ++c) {
                const std::size_t i = std::size_t(kSliceChannels * shIndex(l, m) + c),
                                  j = std::size_t(kSliceChannels * shIndex(l, -m) + c);
                const double plus = in[i], minus = m > 0 ? in[j] : 0;
                if (m > 0) out[j] = sine * plus + cosine * minus;
                out[i] = cosine * plus - sine * minus;
            }
        }
}

// Mirrors a slice. y -> -y keeps cosines and flips sines. x -> -x does the same after a factor (-1)^m on both.
void mirror(bool flip_x, bool flip_y, std::span<double> slice) {
    for (int l = 0; kSliceChannels * coefficientCount(l) < int(slice.size()); ++l)
        for (int m = -l; m <= l; ++m) {
            const bool sine_sign = (m < 0) && (flip_x != flip_y), odd_sign = flip_x && m % 2 != 0;
            if (sine_sign == odd_sign) continue;
            for (double& value : slice.subspan(std::size_t(kSliceChannels * shIndex(l, m)), kSliceChannels))
                value = -value;
        }
}

// Returns the azimuth from whose row azimuth j of n (a multiple of 4) can be made.
int sourceAzimuth(BrdfSymmetry symmetry, int j, int n) {
    if (symmetry == BrdfSymmetry::kGeneral) return j;
    if (symmetry == BrdfSymmetry::kIsotropic) return 0;
    const int k = j > n / 2 ? n - j : j;
    return k > n / 4 ? n / 2 - k : k;
}

// --- The table ------------------------------------------------------------------------------------------------------

// Makes a table with its view grid and with zeros for slices.
SliceTable makeTable(int slice_order, int view_n_z) {
    assert(view_n_z % 2 == 0);
    SliceTable table;
    for (const auto& [direction, weight] : gaussHemisphere(view_n_z, 2 * view_n_z)) {
        table.views.push_back(direction);
        table.weights.push_back(weight * direction.z);
    }
    table.view_n_z = view_n_z;
    table.slices.resize(table.views.size() * std::size_t(kSliceChannels * coefficientCount(slice_order)));
    return table;
}

std::span<double> sliceOf(SliceTable& table, std::size_t view) {
    const std::size_t count = table.slices.size() / table.views.size();
    return std::span(table.slices).subspan(view * count, count);
}

// Returns the views that must be integrated. The others follow from them by symmetry.
std::vector<std::size_t> sourceViews(const SliceTable& table, BrdfSymmetry symmetry) {
    const int azimuths = 2 * table.view_n_z;
    std::vector<std::size_t> views;
    for (int view = 0; view < int(table.views.size()); ++view)
        if (sourceAzimuth(symmetry, view % azimuths, azimuths) == view % azimuths) views.push_back(std::size_t(view));
    return views;
}

// Fills in the views that follow by symmetry.
void spreadBySymmetry(SliceTable& table, BrdfSymmetry symmetry) {
    const int azimuths = 2 * table.view_n_z;
    for (int view = 0; view < int(table.views.size()); ++view) {
        const int j = view % azimuths, source = sourceAzimuth(symmetry, j, azimuths);
        if (source == j) continue;
        const auto from = sliceOf(table, std::size_t(view - j + source)), to = sliceOf(table, std::size_t(view));
        if (symmetry == BrdfSymmetry::kIsotropic) {
            rotateAboutNormal(2 * std::numbers::pi * j / azimuths, from, to);
        } else {
            std::copy(from.begin(), from.end(), to.begin());
            const bool flip_x = j > azimuths / 4 && j<3 * azimuths / 4, flip_y = j> azimuths / 2;
            mirror(flip_x, flip_y, to);
        }
    }
}

// Integrates the given views again and returns w z |change of F|^2 for each.
using Integrate = std::function<void(Vec3d view, std::span<double> slice)>;
std::vector<double> integrateViews(const Integrate& integrate, const std::vector<std::size_t>& views, int threads,
                                   SliceTable& table) {
    std::vector<double> change(views.size());
    parallelFor(views.size(), threads, [&](std::size_t k) {
        throwIfInterrupted();
        const std::span<double> to = sliceOf(table, views[k]);
        std::vector<double> slice(to.size());
        integrate(table.views[views[k]], slice);
        for (std::size_t i = 0; i < slice.size(); ++i)
            change[k] += table.weights[views[k]] * (slice[i] - to[i]) * (slice[i] - to[i]);
        std::copy(slice.begin(), slice.end(), to.begin());
    });
    return change;
}

}  // namespace

SliceTable tabulateSlices(const RgbBrdf& brdf, int slice_order, int incident_n_z, int view_n_z, int threads) {
    SliceTable table = makeTable(slice_order, view_n_z);
    const std::vector<WeightedDirection> grid = gaussHemisphere(incident_n_z, 2 * incident_n_z);
    integrateViews([&](Vec3d view, std::span<double> slice) { integrateOnGrid(brdf, view, grid, slice); },
                   sourceViews(table, brdf.symmetry), threads, table);
    spreadBySymmetry(table, brdf.symmetry);
    return table;
}

SliceTable refinedSlices(const RgbBrdf& brdf, int slice_order, int threads) {
    constexpr int kCoarsest = 32, kFinest = 512;  // heights, and azimuths
    constexpr double kMaxEvaluations = 4e7;       // in one refinement: takes some seconds
    // With these views, C of any model here is within 5e-5 of that with 64 heights.
    const int view_n_z = brdf.symmetry == BrdfSymmetry::kIsotropic ? 32 : 16;
    SliceTable table = makeTable(slice_order, view_n_z);
    std::vector<std::size_t> views = sourceViews(table, brdf.symmetry);
    // A view has settled when it changes by no more than this. As much is left for the views that are still open.
    const double enough = 0.25 * kSettled * kSettled / double(views.size());
    const auto sum = [](const std::vector<double>& values) { return std::reduce(values.begin(), values.end()); };
    const auto integrateAll = [&](int n) {
        const std::vector<WeightedNumber> nodes = gaussInterval(n / 2);
        return integrateViews([&](Vec3d view, std::span<double> s) { integrateAroundMirror(brdf, view, nodes, s); },
                              views, threads, table);
    };
    // 1. Integrate all views on the coarsest grid.
    const double total = sum(integrateAll(kCoarsest));
    double settled_change = 0, open_change = total;
    // 2. Double the grid of the views that still change, until the sum of all changes is small.
    for (int n = 2 * kCoarsest; n <= kFinest && !views.empty(); n *= 2) {
        if (double(views.size()) * n * n > kMaxEvaluations) break;
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
    // 3. Report the change that is left, and fill in the other views.
    table.refinement = total > 0 ? std::sqrt((settled_change + open_change) / total) : 0;
    spreadBySymmetry(table, brdf.symmetry);
    return table;
}

double largestAlbedo(const RgbBrdf& brdf, int threads) {
    constexpr std::array<double, 9> kViewHeights = {0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 0.9};
    const std::size_t azimuths = brdf.symmetry == BrdfSymmetry::kIsotropic     ? 1
                                 : brdf.symmetry == BrdfSymmetry::kOrthotropic ? 3
                                                                               : 8;
    const std::vector<WeightedNumber> nodes = gaussInterval(64);
    std::vector<double> largest(kViewHeights.size() * azimuths);
    parallelFor(largest.size(), threads, [&](std::size_t k) {
        throwIfInterrupted();
        const double z = kViewHeights[k / azimuths], r = std::sqrt(1 - z * z),
                     phi = std::numbers::pi / 4 * double(k % azimuths);
        std::array<double, kSliceChannels> f0{};
        integrateAroundMirror(brdf, {r * std::cos(phi), r * std::sin(phi), z}, nodes, f0);
        // F_0 is the integral with the constant y_0 = 1 / sqrt(4 pi).
        largest[k] = std::sqrt(4 * std::numbers::pi) * *std::max_element(f0.begin(), f0.end());
    });
    return *std::max_element(largest.begin(), largest.end());
}

}  // namespace penumbra
