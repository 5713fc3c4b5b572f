// Reads scattered measurements of an isotropic material, as the Program of Computer Graphics at Cornell University
// publishes them. The file has the number of wavelengths, the wavelengths in nm, then rows theta_i phi_i theta_o
// phi_o and a value for each wavelength. Section 3 of docs/formulas.md tells how well the table predicts samples that
// were left out.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/brdf/brdf_readers.h"
#include "formats/brdf/fit_lobes.h"
#include "formats/brdf/half_difference_table.h"
#include "formats/brdf/number_scanner.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "sh/brdf/spectrum.h"

namespace penumbra {

constexpr std::size_t kMaxSamples = 100000;
constexpr double kMaxSpectralRadiance = 1e6;  // 1/sr

namespace {
struct Sample {
    Vec3d place;
    Vec3d rgb;
};

// Lobes narrower than the distance between samples are taken from a fit to all samples. The table has the rest.
struct Separated {
    std::vector<BrdfLobe> narrow;
    std::vector<Sample> rest;
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
std::vector<BrdfSample> readSamples(NumberScanner& scanner, const std::vector<Vec3d>& weights,
                                    std::map<std::string, double>& figures) {
    double &clamped = figures["clamped"], &outside = figures["outside_rec709"];
    std::vector<BrdfSample> samples;
    while (!scanner.atEnd()) {
        if (samples.size() == kMaxSamples) scanner.fail("more than 100000 samples");
        const Vec3d wi = readDirection(scanner, "i"), wo = readDirection(scanner, "o");
        Vec3d rgb;
        for (Vec3d weight : weights) {
            const double value = scanner.number("a spectral value");
            if (value > kMaxSpectralRadiance) scanner.fail("a spectral value is larger than any measurement");
            clamped += value < 0;
            rgb += weight * std::max(0.0, value);
        }
        for (int c = 0; c < 3; ++c) {
            outside += rgb[c] < 0;
            rgb[c] = std::max(0.0, rgb[c]);
        }
        samples.push_back({wi, wo, rgb});
    }
    if (samples.size() < 16) scanner.fail("fewer than 16 samples");
    return samples;
}

// Returns the mean distance between half vectors near the normal, in radians, of samples whose theta_d differ by less
// than 10 degrees.
double spacingAtPeak(const std::vector<BrdfSample>& samples) {
    constexpr double kReach = 15 * std::numbers::pi / 180;
    constexpr int kBands = 9;  // bands of theta_d
    const auto near = std::count_if(samples.begin(), samples.end(),
                                    [](const BrdfSample& s) { return halfDifference(s.wi, s.wo).theta_h < kReach; });
    return near > 0 ? std::sqrt(std::numbers::pi * kReach * kReach * kBands / double(near)) : kReach;
}

Separated separated(const std::vector<BrdfSample>& samples, std::map<std::string, double>& figures) {
    Separated result;
    const double spacing = spacingAtPeak(samples);
    figures["spacing"] = spacing;
    for (const BrdfLobe& lobe : fitLobes(samples))
        if (lobe.model == BrdfModel::kGgx && halfWidth(lobe) < spacing) result.narrow.push_back(lobe);
    double core = 0;
    for (const BrdfLobe& lobe : result.narrow) core = std::max(core, 2 * halfWidth(lobe));
    for (const BrdfSample& sample : samples) {
        const HalfDifference angles = halfDifference(sample.wi, sample.wo);
        const Vec3d peak = toDouble(evalLobes(result.narrow, toFloat(sample.wi), toFloat(sample.wo)));
        Vec3d rest;
        for (int c = 0; c < 3; ++c) rest[c] = std::max(0.0, sample.rgb[c] - peak[c]);
        // In the core of the lobe, and where it is most of the value, what is left is its error.
        if (angles.theta_h < core || peak.x + peak.y + peak.z > rest.x + rest.y + rest.z) continue;
        result.rest.push_back({placeOf(angles), rest});
    }
    if (result.rest.empty()) result.rest.push_back({});  // nothing but the lobe
    return result;
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
    const std::vector<BrdfSample> measured = readSamples(scanner, weights, figures);
    figures["samples"] = double(measured.size());
    Separated parts = separated(measured, figures);
    std::vector<Sample>& samples = parts.rest;
    std::stable_sort(samples.begin(), samples.end(),
                     [](const Sample& a, const Sample& b) { return a.place.x < b.place.x; });
    HalfDifferenceTable table{kHistogramCells, kHistogramCells, kHistogramCells,
                              std::vector<Vec3>(kHistogramCells * kHistogramCells * kHistogramCells)};
    parallelFor(kHistogramCells * kHistogramCells, threads, [&](std::size_t row) {
        throwIfInterrupted();
        for (std::size_t cell = row * kHistogramCells; cell < (row + 1) * kHistogramCells; ++cell)
            table.values[cell] = toFloat(regress(samples, placeOf(table.center(cell))));
    });
    RgbBrdf brdf = interpolated(name, std::move(table));
    if (!parts.narrow.empty())
        brdf.eval = [rest = brdf.eval, narrow = parts.narrow](Vec3d wi, Vec3d wo) {
            return rest(wi, wo) + toDouble(evalLobes(narrow, toFloat(wi), toFloat(wo)));
        };
    return {std::move(brdf), figures};
}

}  // namespace penumbra
