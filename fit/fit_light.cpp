#include "fit/fit_light.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "formats/errors.h"
#include "formats/write_file.h"
#include "sh/quadrature.h"
#include "sh/sh_rotation.h"

namespace penumbra {

using std::numbers::pi;

// All in a frame whose z is the picture's pole, s' = (sin t cos q, sin t sin q, cos t) with q = -p (latLongDirection).
struct RowMoments {
    std::array<Vec3d, kMaxOrder> cosine{}, sine{};  // sum over pixels of radiance times integral of cos mq, sin mq dq
};

static RowMoments momentsOfRow(std::span<const Vec3> row, int order) {
    RowMoments moments;
    const double width = 2 * pi / double(row.size());
    for (int m = 0; m < order; ++m) {
        // Integrals of cos mp and sin mp over a pixel are those at its centre times sin(m width/2) / (m/2).
        const double chord = m == 0 ? width : std::sin(m * width / 2) / (m / 2.0);
        for (std::size_t x = 0; x < row.size(); ++x) {
            const double p = width * (double(x) + 0.5) - pi;
            moments.cosine[std::size_t(m)] += toDouble(row[x]) * (chord * std::cos(m * p));
            moments.sine[std::size_t(m)] += toDouble(row[x]) * (-chord * std::sin(m * p));
        }
    }
    return moments;
}

// Integral of y(l, m >= 0; azimuth 0) sin t dt over [t0, t1], by 8 Gauss nodes in t: exact to rounding for rows of up
// to 45 degrees (a picture of 4 rows) at every order.
static std::vector<double> rowIntegrals(double t0, double t1, int order) {
    static const std::vector<WeightedDirection> nodes = gaussSphere(8, 1);
    std::vector<double> sum(std::size_t(coefficientCount(order))), y(sum.size());
    for (const auto& [node, weight] : nodes) {
        const double t = (t0 + t1) / 2 + node.z * (t1 - t0) / 2;
        evalBasis(order, Vec3d{std::sin(t), 0, std::cos(t)}, y);
        const double w = weight / (2 * pi) * (t1 - t0) / 2 * std::sin(t);
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += w * y[i];
    }
    return sum;
}

static std::vector<Vec3d> projectAboutPole(const Image& image, int order, double& energy) {
    std::vector<Vec3d> sh(std::size_t(coefficientCount(order)));
    energy = 0;
    for (int row = 0; row < image.height; ++row) {
        throwIfInterrupted();
        const auto pixels =
            std::span(image.pixels).subspan(std::size_t(row) * std::size_t(image.width), std::size_t(image.width));
        const double t0 = pi * row / image.height, t1 = pi * (row + 1) / image.height;
        const double solid_angle = 2 * pi / image.width * (std::cos(t0) - std::cos(t1));
        for (Vec3 p : pixels) energy += solid_angle * dot(toDouble(p), toDouble(p));
        const RowMoments moments = momentsOfRow(pixels, order);
        const std::vector<double> integrals = rowIntegrals(t0, t1, order);
        for (int l = 0; l < order; ++l)
            for (int m = 0; m <= l; ++m) {
                const double integral = integrals[std::size_t(shIndex(l, m))];
                sh[std::size_t(shIndex(l, m))] += moments.cosine[std::size_t(m)] * integral;
                if (m > 0) sh[std::size_t(shIndex(l, -m))] += moments.sine[std::size_t(m)] * integral;
            }
    }
    return sh;
}

LightFile fitLight(const Image& image, const std::string& name, int order) {
    assert(order >= 1 && order <= kMaxOrder);
    if (image.width != 2 * image.height)
        throw InvalidInput(name + ": a lat-long picture is twice as wide as high, not " + std::to_string(image.width) +
                           " x " + std::to_string(image.height));
    double energy = 0, kept = 0;
    const std::vector<Vec3d> about_pole = projectAboutPole(image, order, energy);
    const ShRotationD to_model =
        makeShRotation(order, Mat3d{{1, 0, 0, 0, 0, 1, 0, -1, 0}});  // (x', y', z') -> (x, z, -y)
    LightFile light;
    light.name = std::filesystem::path(name).filename().string();
    light.order = order;
    light.sh.resize(about_pole.size() * 3);
    std::vector<double> in(about_pole.size()), out(about_pole.size());
    for (int channel = 0; channel < 3; ++channel) {
        for (std::size_t i = 0; i < in.size(); ++i) in[i] = about_pole[i][channel];
        apply(to_model, in, out);
        for (std::size_t i = 0; i < out.size(); ++i) {
            light.sh[3 * i + std::size_t(channel)] = out[i];
            kept += out[i] * out[i];
        }
    }
    // The projection is orthogonal: |L - SH|^2 = |L|^2 - |SH|^2.
    light.residual = energy > 0 ? std::sqrt(std::max(0.0, 1 - kept / energy)) : 0;
    return light;
}

}  // namespace penumbra
