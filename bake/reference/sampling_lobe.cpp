// Fits a sampling lobe to any BRDF.
//
// Problem: a path tracer should draw directions where the BRDF is large, but of a measured BRDF only its values are
// known.
//
// Naive: draw cosine-weighted directions. A mirror-like material then needs thousands of samples, since nearly all of
// them miss its lobe ("Brute force" in section 3 of docs/formulas.md has figures).
//
// Here: probe the BRDF once with lobes of six widths, so that one of them finds its peak. Then compute from these
// samples how much variance each lobe of a fixed family would have, and take the best one. No lobe needs samples of
// its own.
#include "bake/reference/sampling_lobe.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

namespace penumbra {

namespace {

// --- Points ---------------------------------------------------------------------------------------------------------

// Hashes a number to [0, 1) (the finaliser of SplitMix64).
double hashToUnit(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return double((x ^ (x >> 31)) >> 11) * 0x1p-53;
}

// Mirrors the binary digits of i at the binary point (van der Corput).
double radicalInverse(std::uint32_t i) {
    i = (i << 16) | (i >> 16);
    i = ((i & 0x00ff00ffu) << 8) | ((i & 0xff00ff00u) >> 8);
    i = ((i & 0x0f0f0f0fu) << 4) | ((i & 0xf0f0f0f0u) >> 4);
    i = ((i & 0x33333333u) << 2) | ((i & 0xccccccccu) >> 2);
    i = ((i & 0x55555555u) << 1) | ((i & 0xaaaaaaaau) >> 1);
    return double(i) * 0x1p-32;
}

}  // namespace

UnitSquare stratified(int i, int n, std::uint64_t seed) {
    double u = (i + 0.5) / n + hashToUnit(seed * 2 + 1),
           v = radicalInverse(std::uint32_t(i)) + hashToUnit(seed * 2 + 2);
    u -= std::floor(u);
    v -= std::floor(v);
    return {u, v};
}

// --- Directions -----------------------------------------------------------------------------------------------------

namespace {

// Returns the unit vector of height z at this azimuth.
Vec3d onCircle(double z, double azimuth) {
    const double r = std::sqrt(std::max(0.0, 1 - z * z));
    return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

}  // namespace

Vec3d sampleCosine(UnitSquare s) { return onCircle(std::sqrt(1 - s.u), 2 * std::numbers::pi * s.v); }
double cosineDensity(Vec3d wi) { return std::max(0.0, wi.z) / std::numbers::pi; }

namespace {

// Turns `local`, which is given around the z axis, to lie around the unit vector `axis`.
Vec3d around(Vec3d axis, Vec3d local) {
    // Duff et al. 2017, "Building an orthonormal basis, revisited".
    const double sign = std::copysign(1.0, axis.z), a = -1 / (sign + axis.z), b = axis.x * axis.y * a;
    const Vec3d x{1 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x};
    const Vec3d y{b, sign + axis.y * axis.y * a, -axis.y};
    return x * local.x + y * local.y + axis * local.z;
}

}  // namespace

Vec3d sampleLobe(const SamplingLobe& lobe, Vec3d wo, UnitSquare s) {
    if (lobe.kind == SamplingLobe::Kind::kPower)
        return around({-wo.x, -wo.y, wo.z}, onCircle(std::pow(1 - s.u, 1 / (lobe.x + 1)), 2 * std::numbers::pi * s.v));
    // The slopes of a GGX surface follow a circular distribution that is stretched along x and y.
    const double slope = std::sqrt(s.u / (1 - s.u)), azimuth = 2 * std::numbers::pi * s.v;
    const Vec3d h = normalized(Vec3d{lobe.x * slope * std::cos(azimuth), lobe.y * slope * std::sin(azimuth), 1});
    return 2 * dot(wo, h) * h - wo;
}

double lobeDensity(const SamplingLobe& lobe, Vec3d wo, Vec3d wi) {
    if (lobe.kind == SamplingLobe::Kind::kPower) {
        const double cosine = dot(Vec3d{-wo.x, -wo.y, wo.z}, wi);
        return cosine > 0 ? (lobe.x + 1) / (2 * std::numbers::pi) * std::pow(cosine, lobe.x) : 0;
    }
    const Vec3d h = normalized(wi + wo);
    const double projected = std::abs(dot(wo, h));
    if (h.z <= 0 || projected <= 0) return 0;
    const double x = h.x / lobe.x, y = h.y / lobe.y, d = x * x + y * y + h.z * h.z;
    return h.z / (std::numbers::pi * lobe.x * lobe.y * d * d) / (4 * projected);
}

// --- The fit --------------------------------------------------------------------------------------------------------

namespace {
// A direction that probes the BRDF for a view.
struct Trial {
    Vec3d wo, wi;
    double weight;  // (f cos)^2 / (albedo of the view)^2 / density of the trial
    double cosine;  // density of cosine-weighted directions
};

// The half vectors of these lobes have every width that a material may have, so that one of them finds its lobe.
const std::array<SamplingLobe, 6>& probes() {
    constexpr auto probe = [](double alpha) { return SamplingLobe{SamplingLobe::Kind::kHalfVector, alpha, alpha, 0}; };
    static const std::array<SamplingLobe, 6> all = {probe(1),    probe(0.3),   probe(0.1),
                                                    probe(0.03), probe(0.008), probe(0.002)};
    return all;
}

// Draws directions for one view from all probes and the cosine, and weights them by the joint density of all of these
// (the balance heuristic). Weights are relative to the view's albedo, so that all views count alike.
void addTrials(const RgbBrdf& brdf, Vec3d wo, std::vector<Trial>& trials) {
    constexpr int kSamples = 512;  // from each probe
    const std::size_t first = trials.size();
    double albedo = 0;
    for (std::size_t p = 0; p <= probes().size(); ++p)
        for (int i = 0; i < kSamples; ++i) {
            const UnitSquare s = stratified(i, kSamples, p);
            const Vec3d wi = p < probes().size() ? sampleLobe(probes()[p], wo, s) : sampleCosine(s);
            if (wi.z <= 0) continue;
            const Vec3d f = brdf.eval(wi, wo);
            const double value = (f.x + f.y + f.z) * wi.z, cosine = cosineDensity(wi);
            if (value <= 0) continue;
            double density = cosine;
            for (const SamplingLobe& probe : probes()) density += lobeDensity(probe, wo, wi);
            albedo += value / (density * kSamples);
            trials.push_back({wo, wi, value * value / (density * kSamples), cosine});
        }
    for (std::size_t t = first; t < trials.size(); ++t) trials[t].weight /= albedo * albedo;
}

// Returns the mean over views of the second moment of (f cos) / density, in squared albedos. Sets the lobe's best
// share.
double secondMoment(const std::vector<Trial>& trials, SamplingLobe& lobe) {
    constexpr std::array<double, 3> kShares = {0.5, 0.75, 0.9};
    std::array<double, kShares.size()> sums{};
    for (const Trial& t : trials) {
        const double density = lobeDensity(lobe, t.wo, t.wi);
        for (std::size_t k = 0; k < kShares.size(); ++k)
            sums[k] += t.weight / (kShares[k] * density + (1 - kShares[k]) * t.cosine);
    }
    const auto best = std::min_element(sums.begin(), sums.end());
    lobe.share = kShares[std::size_t(best - sums.begin())];
    return *best;
}

// Lists the family: powers, isotropic half vectors, and for anisotropic materials also half vectors of two widths.
std::vector<SamplingLobe> candidates(bool isotropic) {
    std::vector<SamplingLobe> all;
    for (double exponent = 1; exponent < 1e6; exponent *= 2)
        all.push_back({SamplingLobe::Kind::kPower, exponent, 0, 0});
    for (double x = 0.002; x < 1.2; x *= std::sqrt(2.0)) all.push_back({SamplingLobe::Kind::kHalfVector, x, x, 0});
    if (isotropic) return all;
    for (double x = 0.005; x < 1.2; x *= 1.6)
        for (double y = 0.005; y < 1.2; y *= 1.6)
            if (x != y) all.push_back({SamplingLobe::Kind::kHalfVector, x, y, 0});
    return all;
}

}  // namespace

SamplingLobe fitLobe(const RgbBrdf& brdf) {
    const bool isotropic = brdf.symmetry == BrdfSymmetry::kIsotropic;
    std::vector<Trial> trials;
    for (double z : {0.95, 0.75, 0.45, 0.2})
        for (int azimuth = 0; azimuth < (isotropic ? 1 : 3); ++azimuth)
            addTrials(brdf, onCircle(z, 0.3 + azimuth * std::numbers::pi / 3), trials);
    SamplingLobe best;
    double least = 0;
    for (const Trial& t : trials) least += t.weight / t.cosine;
    least *= 0.95;  // a lobe takes samples from the cosine, so it must be worth it
    for (SamplingLobe lobe : candidates(isotropic))
        if (const double moment = secondMoment(trials, lobe); moment < least) {
            least = moment;
            best = lobe;
        }
    return best;
}

}  // namespace penumbra
