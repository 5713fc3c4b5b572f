// Scattered measurements of an isotropic material, as the Program of Computer Graphics at Cornell University publishes
// them: the number of wavelengths, the wavelengths in nm, then rows theta_i phi_i theta_o phi_o and a value per
// wavelength.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/brdf_readers.h"
#include "formats/half_difference_table.h"
#include "formats/number_scanner.h"
#include "formats/parallel_for.h"
#include "sh/spectrum.h"

namespace penumbra {

constexpr std::size_t kMostSamples = 100000;
constexpr double kMostRadiance = 1e6;  // 1/sr

namespace {
struct Sample {
    Vec3d place;
    Vec3d rgb;
};
}  // namespace

// Where neighbours are alike: lobes follow theta_h and are narrow at 0, so its logarithm; theta_d; and a third number
// that is |cos theta_i - cos theta_o| / 2 and tells phi_d only as far as it matters.
static Vec3d placeOf(const HalfDifference& a) {
    return {std::log1p(a.theta_h / 0.2) / std::log1p(0.8 / 0.2), a.theta_d / (std::numbers::pi / 2),
            std::sin(a.theta_h) * std::sin(a.theta_d) * std::cos(a.phi_d)};
}

static std::vector<double> readWavelengths(NumberScanner& scanner) {
    std::vector<double> wavelengths(std::size_t(scanner.integer("the number of wavelengths", 2, 1000)));
    for (std::size_t k = 0; k < wavelengths.size(); ++k) {
        wavelengths[k] = scanner.number("wavelength " + std::to_string(k));
        if (!(wavelengths[k] >= 100 && wavelengths[k] <= 10000) || (k > 0 && wavelengths[k] <= wavelengths[k - 1]))
            scanner.fail("wavelength " + std::to_string(k) + " is not ascending or not within 100..10000 nm");
    }
    return wavelengths;
}

static Vec3d directionOf(double theta, double phi) {
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

static Vec3d readDirection(NumberScanner& scanner, const std::string& which) {
    const double theta = scanner.number("theta " + which), phi = scanner.number("phi " + which);
    if (!(theta >= 0 && theta < std::numbers::pi / 2))
        scanner.fail("theta " + which + " is not within 0..pi/2 radians, above the horizon");
    return directionOf(theta, phi);
}

// Rows up to the end of the text.
static std::vector<Sample> readSamples(NumberScanner& scanner, const std::vector<Vec3d>& weights,
                                       std::map<std::string, double>& figures) {
    double &clamped = figures["clamped"], &outside = figures["outside_rec709"];
    std::vector<Sample> samples;
    while (!scanner.atEnd()) {
        if (samples.size() == kMostSamples) scanner.fail("more than 100000 samples");
        const Vec3d wi = readDirection(scanner, "i"), wo = readDirection(scanner, "o");
        Vec3d rgb;
        for (Vec3d weight : weights) {
            const double value = scanner.number("a spectral value");
            if (value > kMostRadiance) scanner.fail("a spectral value is larger than any measurement");
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

// Kernel regression (Nadaraya 1964, Watson 1964) with a Gaussian that is wide enough to reach the nearest sample.
static Vec3d regress(const std::vector<Sample>& samples, Vec3d place, std::vector<float>& squares) {
    constexpr float kWidth = 0.02f, kReach = 16;  // e^-16: too little to see
    float nearest = 1e30f;
    for (std::size_t k = 0; k < samples.size(); ++k) {
        const Vec3d d = samples[k].place - place;
        squares[k] = float(dot(d, d)) / (kWidth * kWidth);
        nearest = std::min(nearest, squares[k]);
    }
    Vec3d sum;
    double total = 0;
    for (std::size_t k = 0; k < samples.size(); ++k) {
        if (squares[k] - nearest > kReach) continue;
        const double weight = std::exp(nearest - squares[k]);
        sum += samples[k].rgb * weight;
        total += weight;
    }
    return sum / total;
}

BrdfReading decodeScattered(std::string_view text, const std::string& name, int threads) {
    constexpr int kCells = 48;  // along each angle: finer than any of these measurements
    NumberScanner scanner(text, name);
    const std::vector<Vec3d> weights = rec709Weights(readWavelengths(scanner));
    std::map<std::string, double> figures;
    const std::vector<Sample> samples = readSamples(scanner, weights, figures);
    figures["samples"] = double(samples.size());
    HalfDifferenceTable table{kCells, kCells, kCells, std::vector<Vec3>(kCells * kCells * kCells)};
    parallelFor(kCells * kCells, threads, [&](std::size_t row) {
        std::vector<float> squares(samples.size());
        for (std::size_t cell = row * kCells; cell < (row + 1) * kCells; ++cell)
            table.values[cell] = toFloat(regress(samples, placeOf(table.centre(cell)), squares));
    });
    return {interpolated(name, std::move(table)), figures};
}

}  // namespace penumbra
