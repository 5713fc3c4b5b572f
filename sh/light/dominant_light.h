#pragma once
// Splits a light into suns and a soft remainder (Nowrouzezahrai 2011 eq. 9-13 and section 7). A sun is a delta: a
// direction and an irradiance. It can have a shadow with an edge, which spherical harmonics cannot have.
// docs/formulas.md, section 11, has the derivation.
#include <array>
#include <span>
#include <vector>

#include "sh/sh_basis.h"
#include "sh/vec3.h"

namespace penumbra {

constexpr int kMaxSuns = 8;

// A light at infinity: a delta whose shadow has the penumbra of a disc.
template <class T>
struct BasicSun {
    BasicVec3<T> direction{0, 1, 0};  // unit, towards the light
    BasicVec3<T> irradiance{};        // at normal incidence, linear Rec.709, >= 0
    T radius = 0;                     // radians from the center of the disc to its rim; 0 for a point
};
using Sun = BasicSun<float>;
using SunD = BasicSun<double>;
constexpr Sun floatSun(const SunD& s) { return {toFloat(s.direction), toFloat(s.irradiance), float(s.radius)}; }

template <class T>
constexpr T luminance(BasicVec3<T> rgb) {
    return T(0.2126) * rgb.x + T(0.7152) * rgb.y + T(0.0722) * rgb.z;  // Rec.709
}

enum class FactorMode {
    kHandOver,  // the suns fade as the light loses its dominant directions: continuous in the light
    kPaper,     // eq. 9-13 as they stand: one sun, of band 1 alone. It finds a sun in any light that is not symmetric.
};

// A direction that may have a sun. The irradiance of its sun is 0 where the light does not need one.
struct SunCandidate {
    SunD sun;
    Vec3d least_squares;   // irradiance of the delta that fits bands >= 1 best
    Vec3d most;            // above this irradiance the windowed remainder would be negative somewhere
    double dominance = 0;  // q: 1 - (windowed luminance of the brightest other direction) / (that of this one)
    double share = 0;      // c of the hand-over, 0 .. 1
};
struct FactoredLight {
    std::array<SunCandidate, kMaxSuns> candidates;  // by descending windowed luminance
    int count = 0;
};

// Finds suns. It makes its tables when it is made; factor() allocates nothing.
class LightFactor {
public:
    // For lights of this order, 1 <= order <= kMaxOrder; a light of order 1 has no sun. 1 <= suns <= kMaxSuns.
    explicit LightFactor(int order, int suns = 1, FactorMode mode = FactorMode::kHandOver);

    int order() const { return order_; }
    int suns() const { return suns_; }
    // Factors a light [order^2, 3]. It may be negative in places. Throws std::invalid_argument when a coefficient is
    // not finite.
    FactoredLight factor(std::span<const double> sh);

private:
    struct Peak {
        Vec3d direction;
        double height = 0;  // windowed luminance there
        std::array<double, coefficientCount(kMaxOrder)> basis{};
    };

    int order_, suns_;
    FactorMode mode_;
    std::vector<Vec3d> directions_;
    std::vector<float> basis_;                          // [order^2, directions], a row a coefficient
    std::array<std::vector<float>, 3> light_;           // windowed, a channel each
    std::vector<float> luminance_;                      // luminance of light_
    std::array<std::vector<float>, kMaxSuns> kernels_;  // the windowed delta of each peak, as a part of its maximum
    double kernel_peak_ = 0;                            // largest value of that kernel, for irradiance 1
    double lobe_ = 0;                                   // radians from the peak to where the kernel ends
    std::array<Peak, kMaxSuns> peaks_;
    int count_ = 0;

    void evaluateGrid(std::span<const double> windowed);
    double findPeaks(std::span<const double> windowed);
    void fillShares(double next, FactoredLight& out) const;
    void fillIrradiance(std::span<const double> sh, std::span<const double> windowed, FactoredLight& out) const;
    double mostIrradiance(int peak, int channel, double at_peak) const;
    double commonScale(int channel, const FactoredLight& out) const;
    double kernel(double cosine) const;
    FactoredLight factorAsPrinted(std::span<const double> sh) const;
};

// Subtracts suns from the SH of a light, in place: L_g = L - sum E_d y(direction), band l times window[l]. sh.size() is
// 3 n^2, and the window is empty or has n factors.
void subtractSuns(std::span<const Sun> suns, std::span<const float> window, std::span<float> sh);
void subtractSuns(std::span<const SunD> suns, std::span<const double> window, std::span<double> sh);

}  // namespace penumbra
