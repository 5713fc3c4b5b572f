// Reads scattered measurements of an isotropic material, as the Program of Computer Graphics at Cornell University
// publishes them. The file has the number of wavelengths, the wavelengths in nm, then rows theta_i phi_i theta_o
// phi_o and a value for each wavelength. Section 3 of docs/formulas.md tells how well the table predicts samples that
// were left out.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/brdf/brdf_readers.h"
#include "formats/brdf/half_difference_table.h"
#include "formats/brdf/number_scanner.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "sh/spectrum.h"

namespace penumbra {

constexpr std::size_t kMostSamples = 100000;
constexpr double kMostSpectralRadiance = 1e6;  // 1/sr

namespace {
struct Sample {
    Vec3d place;
    Vec3d rgb;
};

// Returns a place such that neighbouring places have similar values. Lobes follow theta_h and are narrow at 0, so the
// first coordinate is its logarithm. The second is theta_d. The third is |cos theta_i - cos theta_o| / 2, which tells
// phi_d only as far as it matters.
Vec3d placeOf(const HalfDifference& a) {
    return {std::log1p(a.theta_h / 0.2) / std::log1p(0.8 / 0.2), a.theta_d / (std::numbers::pi / 2),
            std::sin(a.theta_h) * std::sin(a.theta_d) * std::cos(a.phi_d)};
}

std::vector<double> readWavelengths(NumberScanner& scanner) {
    std::vector<double> wavelengths(std::size_t(scanner.integer("the number of wavelengths", 2, 1000)));
    for (std::size_t k = 0; k < wavelengths.size(); ++k) {
        wavelengths[k] = scanner.number("wavelength " + std::to_string(k));
        if (!(wavelengths[k] >= 100 && wavelengths[k] <= 10000) || (k > 0 && wavelengths[k] <= wavelengths[k - 1]))
            scanner.fail("wavelength " + std::to_string(k) + " is not ascending or not within 100..10000 nm");
    }
    return wavelengths;
}

Vec3d directionOf(double theta, double phi) {
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

Vec3d readDirection(NumberScanner& scanner, const std::string& which) {
    const double theta = scanner.number("theta " + which), phi = scanner.number("phi " + which);
    if (!(theta >= 0 && theta < std::numbers::pi / 2))
        scanner.fail("theta " + which + " is not within 0..pi/2 radians, above the horizon");
    return directionOf(theta, phi);
}

// Reads rows up to the end of the text.
std::vector<Sample> readSamples(NumberScanner& scanner, const std::vector<Vec3d>& weights,
                                std::map<std::string, double>& figures) {
    double &clamped = figures["clamped"], &outside = figures["outside_rec709"];
    std::vector<Sample> samples;
    while (!scanner.atEnd()) {
        if (samples.size() == kMostSamples) scanner.fail("more than 100000 samples");
        const Vec3d wi = readDirection(scanner, "i"), wo = readDirection(scanner, "o");
        Vec3d rgb;
        for (Vec3d weight : weights) {
            const double value = scanner.number("a spectral value");
            if (value > kMostSpectralRadiance) scanner.fail("a spectral value is larger than any measurement");
            clamped += value < 0;
            rgb += weight * std::max(0.0, value);
        }
        for (int c = 0; c < 3; ++c) {
            outside += rgb[c] < 0;
            rgb[c] = std::max(0.0, rgb[c]);
        }
        samples.push_back({placeOf(halfDifference(wi, wo)), rgb});
    }
    if (samples.size() < 16) scanner.fail("fewer than 16 samples");
    return samples;
}

// Regresses by a kernel (Nadaraya 1964, Watson 1964): a Gaussian that is wide enough to reach the nearest sample.
// `samples` ascend in place.x, so that far ones need not be looked at.
Vec3d regress(const std::vector<Sample>& samples, Vec3d place) {
    constexpr double kWidth = 0.02, kReach = 16 * kWidth * kWidth;  // e^-16 is too little to see
    const auto square = [&](const Sample& sample) {
        const Vec3d d = sample.place - place;
        return dot(d, d);
    };
    const auto squareInX = [&](const Sample& sample) {
        return (sample.place.x - place.x) * (sample.place.x - place.x);
    };
    const auto start = std::lower_bound(samples.begin(), samples.end(), place.x,
                                        [](const Sample& sample, double x) { return sample.place.x < x; });
    double nearest = 1e30;
    for (auto s = start; s != samples.end() && squareInX(*s) < nearest; ++s) nearest = std::min(nearest, square(*s));
    for (auto s = start; s != samples.begin() && squareInX(*(s - 1)) < nearest; --s)
        nearest = std::min(nearest, square(*(s - 1)));
    Vec3d sum;
    double total = 0;
    const auto add = [&](const Sample& sample) {
        const double further = square(sample) - nearest;
        if (further > kReach) return;
        const double weight = std::exp(-further / (kWidth * kWidth));
        sum += sample.rgb * weight;
        total += weight;
    };
    for (auto s = start; s != samples.end() && squareInX(*s) <= nearest + kReach; ++s) add(*s);
    for (auto s = start; s != samples.begin() && squareInX(*(s - 1)) <= nearest + kReach; --s) add(*(s - 1));
    return sum / total;
}

}  // namespace

BrdfReading decodeScattered(std::string_view text, const std::string& name, int threads) {
    constexpr int kHistogramCells = 48;  // along each angle; finer than any of these measurements
    NumberScanner scanner(text, name);
    const std::vector<Vec3d> weights = rec709Weights(readWavelengths(scanner));
    std::map<std::string, double> figures;
    std::vector<Sample> samples = readSamples(scanner, weights, figures);
    figures["samples"] = double(samples.size());
    std::stable_sort(samples.begin(), samples.end(),
                     [](const Sample& a, const Sample& b) { return a.place.x < b.place.x; });
    HalfDifferenceTable table{kHistogramCells, kHistogramCells, kHistogramCells,
                              std::vector<Vec3>(kHistogramCells * kHistogramCells * kHistogramCells)};
    parallelFor(kHistogramCells * kHistogramCells, threads, [&](std::size_t row) {
        throwIfInterrupted();
        for (std::size_t cell = row * kHistogramCells; cell < (row + 1) * kHistogramCells; ++cell)
            table.values[cell] = toFloat(regress(samples, placeOf(table.centre(cell))));
    });
    return {interpolated(name, std::move(table)), figures};
}

}  // namespace penumbra
