// Computes LDR-FLIP (flip.h).
//
// Problem: tell how different two pictures look. A difference of pixels does not: noise that nobody sees counts as
// much as a shadow in the wrong place.
//
// Here: first filter both pictures as the eye does at the viewing distance (contrast sensitivity), and compare
// colours in a perceptually uniform space. Then compare edges and points of lightness. A difference of features
// amplifies that of colour. The filters are sums of separable Gaussians, so that each costs passes along rows and
// columns only.
#include "player/render/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "formats/common/parallel_for.h"

namespace penumbra {

namespace {

constexpr double kPi = std::numbers::pi;
// Exponents and knee of the colour difference; exponent and width (degrees) of the feature difference.
constexpr double kQc = 0.7, kPc = 0.4, kPt = 0.95, kQf = 0.5, kFeatureWidth = 0.082;
// Matrix from linear sRGB to XYZ, D65.
constexpr double kXyz[3][3] = {{10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
                               {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
                               {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382}};

using Plane = std::vector<double>;
using Planes = std::array<Plane, 3>;
using Kernel = std::vector<double>;  // an odd number of weights, the middle one for the pixel itself

struct Size {
    int width, height;
    std::size_t pixels() const { return std::size_t(width) * std::size_t(height); }
};

// Returns XYZ divided by that of white.
std::array<double, 3> relativeXyz(const std::array<double, 3>& rgb) {
    std::array<double, 3> xyz;
    for (int i = 0; i < 3; ++i)
        xyz[std::size_t(i)] =
            (kXyz[i][0] * rgb[0] + kXyz[i][1] * rgb[1] + kXyz[i][2] * rgb[2]) / (kXyz[i][0] + kXyz[i][1] + kXyz[i][2]);
    return xyz;
}

// Converts to YyCxCz: achromatic, red-green, blue-yellow.
Planes opponent(Size size, std::span<const Vec3> picture) {
    Planes planes;
    for (Plane& plane : planes) plane.resize(size.pixels());
    for (std::size_t i = 0; i < size.pixels(); ++i) {
        const Vec3 p = picture[i];
        const auto [x, y, z] = relativeXyz({double(p.x), double(p.y), double(p.z)});
        planes[0][i] = 116 * y - 16;
        planes[1][i] = 500 * (x - y);
        planes[2][i] = 200 * (y - z);
    }
    return planes;
}

// Solves kXyz rgb = xyz by Cramer's rule.
std::array<double, 3> rgbOfXyz(const std::array<double, 3>& xyz) {
    const auto determinant = [](const std::array<std::array<double, 3>, 3>& m) {
        return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
               m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    };
    std::array<std::array<double, 3>, 3> matrix;
    for (std::size_t i = 0; i < 3; ++i) matrix[i] = {kXyz[i][0], kXyz[i][1], kXyz[i][2]};
    const double all = determinant(matrix);
    std::array<double, 3> rgb;
    for (std::size_t c = 0; c < 3; ++c) {
        auto replaced = matrix;
        for (std::size_t i = 0; i < 3; ++i) replaced[i][c] = xyz[i];
        rgb[c] = determinant(replaced) / all;
    }
    return rgb;
}

std::array<double, 3> rgbOfOpponent(double yy, double cx, double cz) {
    const double y = (yy + 16) / 116;
    std::array<double, 3> xyz = {cx / 500 + y, y, y - cz / 200};
    for (std::size_t i = 0; i < 3; ++i) xyz[i] *= kXyz[i][0] + kXyz[i][1] + kXyz[i][2];
    return rgbOfXyz(xyz);
}

// Converts to CIELAB whose chroma is scaled by lightness (Hunt effect).
std::array<double, 3> huntLab(const std::array<double, 3>& rgb) {
    std::array<double, 3> f = relativeXyz(rgb);
    constexpr double kKnee = 6.0 / 29;
    for (double& t : f) t = t > kKnee * kKnee * kKnee ? std::cbrt(t) : t / (3 * kKnee * kKnee) + 4.0 / 29;
    const double lightness = 116 * f[1] - 16;
    return {lightness, 0.01 * lightness * 500 * (f[0] - f[1]), 0.01 * lightness * 200 * (f[1] - f[2])};
}

double hyab(const std::array<double, 3>& a, const std::array<double, 3>& b) {
    return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

// Adds kernel[k] in[x] to out[x].
void addWeighted(const Kernel& kernel, int k, const double* in, int width, double* out) {
    const double weight = kernel[std::size_t(k + int(kernel.size() / 2))];
    for (int x = 0; x < width; ++x) out[x] += weight * in[x];
}

// Convolves along rows or columns, repeating the edges.
Plane convolved(Size size, const Plane& plane, const Kernel& kernel, bool along_rows, int threads) {
    Plane out(plane.size());
    const int radius = int(kernel.size() / 2), width = size.width;
    parallelFor(std::size_t(size.height), threads, [&](std::size_t y) {
        const auto row = [&](int at) { return plane.data() + std::size_t(at) * std::size_t(width); };
        double* const sums = out.data() + y * std::size_t(width);
        if (!along_rows) {
            for (int k = -radius; k <= radius; ++k)
                addWeighted(kernel, k, row(std::clamp(int(y) - k, 0, size.height - 1)), width, sums);
            return;
        }
        const double* const in = row(int(y));
        std::vector<double> padded(std::size_t(radius), in[0]);
        padded.insert(padded.end(), in, in + width);
        padded.insert(padded.end(), std::size_t(radius), in[width - 1]);
        for (int k = -radius; k <= radius; ++k) addWeighted(kernel, k, padded.data() + (radius - k), width, sums);
    });
    return out;
}

// --- Colour ---------------------------------------------------------------------------------------------------------

// Contrast sensitivity for each opponent channel: a sum of Gaussians sqrt(pi/b) a exp(-pi^2 d^2 / b), d in degrees.
struct Lobe {
    double a, b;
};
const std::array<std::vector<Lobe>, 3> kSensitivity = {{{{1, 0.0047}}, {{1, 0.0053}}, {{34.1, 0.04}, {13.5, 0.025}}}};

Plane sensitivityFiltered(Size size, const Plane& plane, const std::vector<Lobe>& lobes, int threads) {
    constexpr double kWidest = 0.04;
    const int radius = int(std::ceil(3 * std::sqrt(kWidest / (2 * kPi * kPi)) * kFlipPixelsPerDegree));
    std::vector<Kernel> kernels;
    std::vector<double> scales;
    double total = 0;
    for (const Lobe& lobe : lobes) {
        Kernel kernel;
        double sum = 0;
        for (int k = -radius; k <= radius; ++k) {
            const double d = k / kFlipPixelsPerDegree;
            kernel.push_back(std::exp(-kPi * kPi * d * d / lobe.b));
            sum += kernel.back();
        }
        kernels.push_back(std::move(kernel));
        scales.push_back(lobe.a * std::sqrt(kPi / lobe.b));
        total += scales.back() * sum * sum;
    }
    Plane out(size.pixels());
    for (std::size_t l = 0; l < lobes.size(); ++l) {
        const Plane half = convolved(size, plane, kernels[l], false, threads);
        const Plane filtered = convolved(size, half, kernels[l], true, threads);
        for (std::size_t i = 0; i < out.size(); ++i) out[i] += scales[l] / total * filtered[i];
    }
    return out;
}

Planes perceived(Size size, const Planes& ycc, int threads) {
    Planes lab;
    for (std::size_t c = 0; c < 3; ++c) lab[c] = sensitivityFiltered(size, ycc[c], kSensitivity[c], threads);
    parallelFor(std::size_t(size.height), threads, [&](std::size_t row) {
        for (std::size_t i = row * std::size_t(size.width); i < (row + 1) * std::size_t(size.width); ++i) {
            std::array<double, 3> rgb = rgbOfOpponent(lab[0][i], lab[1][i], lab[2][i]);
            for (double& c : rgb) c = std::clamp(c, 0.0, 1.0);
            const std::array<double, 3> converted = huntLab(rgb);
            for (std::size_t c = 0; c < 3; ++c) lab[c][i] = converted[c];
        }
    });
    return lab;
}

// --- Features -------------------------------------------------------------------------------------------------------

// Scales weights so that the negative ones sum to -1 and the positive ones to 1.
void balance(Kernel& kernel) {
    double negative = 0, positive = 0;
    for (const double w : kernel) (w < 0 ? negative : positive) += std::abs(w);
    for (double& w : kernel) w /= w < 0 ? negative : positive;
}

// Returns the magnitude of edges, or of points, of lightness.
Plane features(Size size, const Plane& lightness, bool points, int threads) {
    const double deviation = 0.5 * kFeatureWidth * kFlipPixelsPerDegree;
    const int radius = int(std::ceil(3 * deviation));
    Kernel derivative, smooth;
    double sum = 0;
    for (int x = -radius; x <= radius; ++x) {
        smooth.push_back(std::exp(-x * x / (2 * deviation * deviation)));
        sum += smooth.back();
        derivative.push_back((points ? x * x / (deviation * deviation) - 1 : -double(x)) * smooth.back());
    }
    for (double& w : smooth) w /= sum;
    balance(derivative);
    Plane out(size.pixels());
    for (const bool rows : {false, true}) {
        const Plane across = convolved(size, lightness, derivative, rows, threads);
        const Plane slope = convolved(size, across, smooth, !rows, threads);
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = std::hypot(out[i], slope[i]);
    }
    return out;
}

// Returns the larger one of the differences of edges and of points.
Plane featureDifference(Size size, const std::array<Plane, 2>& lightness, int threads) {
    Plane out(size.pixels());
    for (const bool points : {false, true}) {
        const Plane a = features(size, lightness[0], points, threads),
                    b = features(size, lightness[1], points, threads);
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = std::max(out[i], std::abs(a[i] - b[i]));
    }
    return out;
}

}  // namespace

std::vector<float> flipMap(int width, int height, std::span<const Vec3> reference, std::span<const Vec3> test,
                           int threads) {
    const Size size{width, height};
    const std::array<Planes, 2> ycc = {opponent(size, reference), opponent(size, test)};
    const std::array<Planes, 2> lab = {perceived(size, ycc[0], threads), perceived(size, ycc[1], threads)};
    std::array<Plane, 2> lightness = {ycc[0][0], ycc[1][0]};
    for (Plane& plane : lightness)
        for (double& y : plane) y = (y + 16) / 116;
    const Plane feature = featureDifference(size, lightness, threads);
    const double largest = std::pow(hyab(huntLab({0, 1, 0}), huntLab({0, 0, 1})), kQc), knee = kPc * largest;
    std::vector<float> map(size.pixels());
    for (std::size_t i = 0; i < map.size(); ++i) {
        const double distance =
            hyab({lab[0][0][i], lab[0][1][i], lab[0][2][i]}, {lab[1][0][i], lab[1][1][i], lab[1][2][i]});
        double color = std::pow(distance, kQc);
        color = color < knee ? kPt / knee * color : kPt + (color - knee) / (largest - knee) * (1 - kPt);
        const double weight = std::pow(std::clamp(feature[i] / std::numbers::sqrt2, 0.0, 1.0), kQf);
        map[i] = float(std::pow(std::clamp(color, 0.0, 1.0), 1 - weight));
    }
    return map;
}

}  // namespace penumbra
