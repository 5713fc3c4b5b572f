#pragma once
// SH of few bands overshoot beside bright sources and go below 0 (ringing). A window multiplies band l by w_l <= 1. It
// costs accuracy: the projection itself is nearest to the light.
#include <span>
#include <string>
#include <vector>

namespace penumbra {

struct WindowChoice {
    enum class Mode { kNone, kAuto, kAlways, kLambda } mode = Mode::kAuto;
    double lambda =
        0;  // of kLambda: w_l = 1 / (1 + lambda l^2 (l+1)^2) (Sloan, Stupid Spherical Harmonics Tricks, 2008)
};
// none, auto, always or a number from 0 to 1000. std::invalid_argument.
WindowChoice parseWindow(const std::string& text);

// The window of the sharpest zonal kernel of this order that is nowhere negative: what it leaves of any light >= 0 is
// >= 0. The largest w_1 that this allows; K = q^2 or (1 + x) q^2, q from Gauss nodes without the last.
std::span<const double> sharpestWindow(int order);

// The least radiance of any channel over its mean over the sphere (a channel without light counts as 1): -0.01 is
// ringing of 1% of the mean. Over 4096 directions, the lowest few refined: right to 1e-6.
double leastRadiance(int order, std::span<const double> sh);

constexpr double kMostRinging = 0.01;  // of the mean
struct WindowReport {
    std::vector<double> weights;                                      // [order]; all 1: no window
    double least_before = 1, least_after = 1, irradiance_change = 0;  // the last over all normals, relative

    bool any() const { return weights.size() > 1 && weights[1] < 1; }
};
// Windows `sh` [order^2, 3]. kAlways: the least of Sloan's windows and the least of 1 - s (1 - sharpestWindow), 0 < s
// <= 1, that leave leastRadiance() >= -kMostRinging; of these two the one that changes irradiance less. kAuto here is
// kNone: fit_light.h knows when it is kAlways.
WindowReport windowLight(int order, const WindowChoice& choice, std::span<double> sh);

}  // namespace penumbra
