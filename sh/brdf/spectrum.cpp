#include "sh/brdf/spectrum.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace penumbra {

namespace {

constexpr int kFirst = 380, kLast = 780;  // nm, the range that the eye sees

// Relative power of the CIE standard illuminant D65 at 380, 390, ... 780 nm (CIE 15:2004, table T.1).
constexpr std::array<double, 41> kD65 = {
    49.9755, 54.6482, 82.7549, 91.4860, 93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861, 115.923,
    108.811, 109.354, 107.802, 104.790, 107.689, 104.405, 104.046, 100.000, 96.3342, 95.7880, 88.6856,
    90.0062, 89.5991, 87.6987, 83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091,
    74.3490, 61.6040, 69.8856, 75.0870, 63.5927, 46.4182, 66.8054, 63.3828};

double d65(double wavelength) {
    const double at = std::clamp((wavelength - kFirst) / 10, 0.0, double(kD65.size() - 1));
    const std::size_t below = std::min(std::size_t(at), kD65.size() - 2);
    return kD65[below] + (at - double(below)) * (kD65[below + 1] - kD65[below]);
}

// The colour matching functions of Wyman, Sloan and Shirley 2013, "Simple analytic approximations to the CIE XYZ color
// matching functions", section 2.2: sums of Gaussians whose width differs on the two sides of the peak.
Vec3d colourMatching(double w) {
    const auto lobe = [w](double height, double peak, double below, double above) {
        const double t = (w - peak) / (w < peak ? below : above);
        return height * std::exp(-t * t / 2);
    };
    return {lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) + lobe(-0.065, 501.1, 20.4, 26.2),
            lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
            lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8)};
}

}  // namespace

std::vector<Vec3d> rec709Weights(std::span<const double> wavelengths) {
    assert(wavelengths.size() >= 2 && std::is_sorted(wavelengths.begin(), wavelengths.end()));
    // This matrix takes XYZ to linear Rec.709 (ITU-R BT.709 primaries, white D65).
    const Mat3d rgb_of_xyz{
        {3.2404542, -1.5371385, -0.4985314, -0.9692660, 1.8760108, 0.0415560, 0.0556434, -0.2040259, 1.0572252}};
    std::vector<Vec3d> weights(wavelengths.size());
    Vec3d white;
    for (int w = kFirst; w <= kLast; ++w) {
        // 1. The light of one nanometre that a white reflector returns.
        const Vec3d rgb = rgb_of_xyz * (colourMatching(w) * d65(w));
        white += rgb;
        // 2. It belongs to the samples on both sides, in proportion to their nearness.
        const auto above = std::upper_bound(wavelengths.begin(), wavelengths.end(), double(w));
        const auto k = std::size_t(above - wavelengths.begin());
        if (k == 0 || k == wavelengths.size()) {
            weights[k == 0 ? 0 : k - 1] += rgb;
            continue;
        }
        const double share = (w - wavelengths[k - 1]) / (wavelengths[k] - wavelengths[k - 1]);
        weights[k - 1] += rgb * (1 - share);
        weights[k] += rgb * share;
    }
    // 3. Scale so that a white reflector is (1, 1, 1).
    for (Vec3d& weight : weights) weight = {weight.x / white.x, weight.y / white.y, weight.z / white.z};
    return weights;
}

}  // namespace penumbra
