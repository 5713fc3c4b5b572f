#pragma once
// Windows the SH of a light. SH with few bands overshoot beside bright sources and go below 0 (ringing). A window
// multiplies band l by w_l <= 1. It costs accuracy, because the projection itself is nearest to the light.
#include <span>
#include <string>
#include <vector>

namespace penumbra {

struct WindowChoice {
    enum class Mode { kNone, kAuto, kAlways, kLambda } mode = Mode::kAuto;
    // For kLambda: w_l = 1 / (1 + lambda l^2 (l+1)^2) (Sloan, Stupid Spherical Harmonics Tricks, 2008).
    double lambda = 0;
};
// Reads none, auto, always or a number from 0 to 1000. Throws std::invalid_argument for anything else.
WindowChoice parseWindow(const std::string& text);

// Returns the least radiance of any channel, divided by that channel's mean over the sphere. A channel without light
// counts as 1. -0.01 means ringing of 1% of the mean. It evaluates 4096 directions and refines the lowest few; the
// result is right to 1e-6.
double leastRadiance(int order, std::span<const double> sh);

constexpr double kMaxRinging = 0.01;  // relative to the mean
struct WindowReport {
    std::vector<double> weights;  // [order]; all are 1 when there is no window
    // `irradiance_change` is relative and over all normals.
    double least_before = 1, least_after = 1, irradiance_change = 0;

    bool any() const { return weights.size() > 1 && weights[1] < 1; }
};
// Windows `sh` [order^2, 3]. kAlways takes the least of Sloan's windows and the least of 1 - s (1 - sharpestWindow), 0
// < s <= 1, that leave leastRadiance() >= -kMaxRinging, and of these two the one that changes irradiance less. kAuto
// means kNone here; windowFit() (fit_light.h) decides when it means kAlways.
WindowReport windowLight(int order, const WindowChoice& choice, std::span<double> sh);

}  // namespace penumbra
