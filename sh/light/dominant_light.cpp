// Finds the dominant directions of a light that is given as SH.
//
// Problem: find the suns of a light, such that the suns and the remainder change continuously with the light, and such
// that the remainder is a light: nowhere negative.
//
// Naive (Nowrouzezahrai 2011 eq. 9-13): the direction and the length of band 1. Any sky has a band 1, so that a uniform
// sky above a dark ground gets a sun of 3.14, and two lamps get one sun between them.
//
// Here: the light is windowed, so that it does not ring. The arg max of its luminance is the direction. A least-squares
// fit gives the irradiance, and a cap keeps the windowed remainder from going below 0. A share c fades the sun out
// before another direction takes over, so nothing jumps. Derivation: docs/formulas.md, section 11.
#include "sh/light/dominant_light.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sh/light/sharpest_window.h"
#include "sh/quadrature.h"

namespace penumbra {

namespace {

using std::numbers::pi;

constexpr std::size_t kGrid = 4096, kBatch = 256;
constexpr float kLobeEdge = 0.02f;                             // where a kernel ends, as a part of its maximum
constexpr double kMinDominance = 0.05, kFullDominance = 0.45;  // the hand-over goes from one to the other
// Two suns are rivals up to the first distance between them, and independent from the second on, in lobes. Between
// rivals nothing depends on where exactly the second one lies: on the rim of a lobe it is as coarse as the grid, 3
// degrees.
constexpr double kTouching = 1.06, kApart = 1.33;

using Basis = std::array<double, coefficientCount(kMaxOrder)>;

double smoothstep(double low, double high, double x) {
    const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

double handOver(double dominance) { return smoothstep(kMinDominance, kFullDominance, dominance); }

double angleBetween(Vec3d a, Vec3d b) { return std::atan2(length(cross(a, b)), dot(a, b)); }

double luminanceAt(int order, std::span<const double> sh, Vec3d direction, Basis& basis) {
    const auto count = std::size_t(coefficientCount(order));
    evalBasis(order, direction, std::span(basis).first(count));
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += basis[i] * luminance(Vec3d{sh[3 * i], sh[3 * i + 1], sh[3 * i + 2]});
    return sum;
}

// Climbs from a point of the grid to the maximum by Newton's method in the tangent plane. The grid is so fine that the
// luminance is concave there unless the light is flat; then the direction stays.
Vec3d climb(int order, std::span<const double> sh, Vec3d at) {
    constexpr double kStep = 1e-3;
    Basis basis;
    for (int i = 0; i < 8; ++i) {
        const Vec3d a = normalized(cross(at, std::abs(at.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0})), b = cross(at, a);
        const auto f = [&](double u, double v) {
            return luminanceAt(order, sh, normalized(at + kStep * u * a + kStep * v * b), basis);
        };
        const double here = f(0, 0), right = f(1, 0), left = f(-1, 0), up = f(0, 1), down = f(0, -1);
        const double ga = (right - left) / 2, gb = (up - down) / 2;
        const double haa = right - 2 * here + left, hbb = up - 2 * here + down,
                     hab = (f(1, 1) - f(1, -1) - f(-1, 1) + f(-1, -1)) / 4;
        const double determinant = haa * hbb - hab * hab;
        if (!(haa < 0 && determinant > 1e-16 * here * here * kStep * kStep)) break;
        double u = kStep * (hab * gb - hbb * ga) / determinant, v = kStep * (hab * ga - haa * gb) / determinant;
        const double size = std::hypot(u, v), most = size > 0.1 ? 0.1 / size : 1;
        at = normalized(at + most * u * a + most * v * b);
        if (size < 1e-10) break;
    }
    return at;
}

}  // namespace

LightFactor::LightFactor(int order, int suns, FactorMode mode) : order_(order), suns_(suns), mode_(mode) {
    assert(order >= 1 && order <= kMaxOrder && suns >= 1 && suns <= kMaxSuns);
    if (order == 1 || mode == FactorMode::kPaper) return;
    // The set of the golden vectors starts half a step farther round.
    const double half_step = pi * (3 - std::sqrt(5.0)) / 2, c = std::cos(half_step), s = std::sin(half_step);
    for (const Vec3d d : fibonacciSphere(kGrid)) directions_.push_back({c * d.x - s * d.y, s * d.x + c * d.y, d.z});
    const auto count = std::size_t(coefficientCount(order));
    basis_.resize(count * kGrid);
    Basis basis;
    for (std::size_t d = 0; d < kGrid; ++d) {
        evalBasis(order, directions_[d], std::span(basis).first(count));
        for (std::size_t i = 0; i < count; ++i) basis_[i * kGrid + d] = float(basis[i]);
    }
    for (std::vector<float>& channel : light_) channel.resize(kGrid);
    for (std::vector<float>& values : kernels_) values.resize(kGrid);
    luminance_.resize(kGrid);
    kernel_peak_ = kernel(1);
    while (lobe_ < pi && kernel(std::cos(lobe_)) > kLobeEdge * kernel_peak_) lobe_ += 1e-3;
}

// The windowed delta of irradiance 1: sum_l w_l (2l+1)/(4pi) P_l(cosine).
double LightFactor::kernel(double cosine) const {
    const std::span<const double> window = sharpestWindow(order_);
    double sum = 1 / (4 * pi), previous = 1, legendre = cosine;
    for (int l = 1; l < order_; ++l) {
        sum += window[std::size_t(l)] * (2 * l + 1) / (4 * pi) * legendre;
        const double next = ((2 * l + 1) * cosine * legendre - l * previous) / (l + 1);
        previous = legendre, legendre = next;
    }
    return sum;
}

FactoredLight LightFactor::factor(std::span<const double> sh) {
    const auto count = std::size_t(coefficientCount(order_));
    assert(sh.size() == 3 * count);
    double largest = 0;
    for (const double value : sh) {
        if (!std::isfinite(value)) throw std::invalid_argument("the light has a coefficient that is not finite");
        largest = std::max(largest, std::abs(value));
    }
    if (order_ == 1 || !(largest > 1e-30)) return {};
    if (mode_ == FactorMode::kPaper) return factorAsPrinted(sh);
    // The largest coefficient becomes 1, so that no light leaves the range of float.
    std::array<double, 3 * coefficientCount(kMaxOrder)> scaled, windowed;
    for (std::size_t i = 0; i < 3 * count; ++i) {
        scaled[i] = sh[i] / largest;
        windowed[i] = scaled[i] * sharpestWindow(order_)[std::size_t(bandOfIndex(int(i / 3)))];
    }
    FactoredLight out;
    evaluateGrid(std::span(windowed).first(3 * count));
    const double next = findPeaks(std::span(windowed).first(3 * count));
    fillShares(next, out);
    fillIrradiance(std::span(scaled).first(3 * count), std::span(windowed).first(3 * count), out);
    for (int i = 0; i < out.count; ++i)
        for (Vec3d* value : {&out.candidates[std::size_t(i)].sun.irradiance,
                             &out.candidates[std::size_t(i)].least_squares, &out.candidates[std::size_t(i)].most})
            *value *= largest;
    return out;
}

// Evaluates the windowed light in all directions of the grid, a batch at a time, so that the sums stay in the cache.
void LightFactor::evaluateGrid(std::span<const double> windowed) {
    const auto count = std::size_t(coefficientCount(order_));
    for (std::size_t first = 0; first < kGrid; first += kBatch) {
        for (std::size_t c = 0; c < 3; ++c) std::fill_n(&light_[c][first], kBatch, 0.0f);
        for (std::size_t i = 0; i < count; ++i) {
            const float* y = &basis_[i * kGrid + first];
            for (std::size_t c = 0; c < 3; ++c) {
                const auto weight = float(windowed[3 * i + c]);
                float* out = &light_[c][first];
                for (std::size_t d = 0; d < kBatch; ++d) out[d] += weight * y[d];
            }
        }
        for (std::size_t d = first; d < first + kBatch; ++d)
            luminance_[d] = luminance(Vec3{light_[0][d], light_[1][d], light_[2][d]});
    }
}

// Finds the brightest direction, then the brightest one outside of its lobe, and so on. Returns the largest luminance
// outside of all lobes, at least 0.
double LightFactor::findPeaks(std::span<const double> windowed) {
    std::array<bool, kGrid> taken{};
    for (count_ = 0;; ++count_) {
        std::size_t best = kGrid;
        for (std::size_t d = 0; d < kGrid; ++d)
            if (!taken[d] && (best == kGrid || luminance_[d] > luminance_[best])) best = d;
        const double height = best < kGrid ? std::max(0.0f, luminance_[best]) : 0;
        if (count_ == suns_ || !(height > 0)) return height;
        Peak& peak = peaks_[std::size_t(count_)];
        peak.direction = climb(order_, windowed, directions_[best]);
        // On the rim of an earlier lobe the climb can lead into it. That is no peak of its own, so it stays on the rim.
        for (int j = 0; j < count_; ++j)
            if (kernel(dot(peak.direction, peaks_[std::size_t(j)].direction)) > kLobeEdge * kernel_peak_)
                peak.direction = directions_[best];
        peak.height = luminanceAt(order_, windowed, peak.direction, peak.basis);
        std::vector<float>& values = kernels_[std::size_t(count_)];
        for (std::size_t d = 0; d < kGrid; ++d) {
            values[d] = float(kernel(dot(directions_[d], peak.direction)) / kernel_peak_);
            taken[d] = taken[d] || values[d] > kLobeEdge;
        }
    }
}

// c_i = h(1 - next / P_i) times, for every other peak j, a + (1 - a) h(1 - P_j / P_i). h is the hand-over, P a height,
// and a goes from 0 to 1 as the lobes of i and j part. So peaks far apart are suns side by side, and peaks close
// together are rivals. The sum is the same when two peaks of one height change places.
void LightFactor::fillShares(double next, FactoredLight& out) const {
    out.count = count_;
    for (int i = 0; i < count_; ++i) {
        const Peak& peak = peaks_[std::size_t(i)];
        SunCandidate& candidate = out.candidates[std::size_t(i)];
        candidate.sun.direction = peak.direction;
        candidate.dominance = peak.height > 0 ? 1 - next / peak.height : 0;
        candidate.share = handOver(candidate.dominance);
        for (int j = 0; j < count_; ++j) {
            if (j == i) continue;
            const Peak& other = peaks_[std::size_t(j)];
            const double apart =
                smoothstep(kTouching * lobe_, kApart * lobe_, angleBetween(peak.direction, other.direction));
            candidate.share *= apart + (1 - apart) * handOver(1 - other.height / peak.height);
        }
    }
}

// Returns the irradiance above which a sun leaves a negative windowed remainder within its lobe.
double LightFactor::mostIrradiance(int peak, int channel, double at_peak) const {
    const std::vector<float>&kernel = kernels_[std::size_t(peak)], &light = light_[std::size_t(channel)];
    double least = at_peak;
    for (std::size_t d = 0; d < kGrid; ++d)
        if (kernel[d] > kLobeEdge) least = std::min(least, double(light[d] / kernel[d]));
    return std::max(0.0, least / kernel_peak_);
}

// Returns the factor <= 1 that all suns of a channel need together, because their lobes overlap at the rims. What
// counts is where they are brighter than the rim of the brightest one's lobe.
double LightFactor::commonScale(int channel, const FactoredLight& out) const {
    const std::vector<float>& light = light_[std::size_t(channel)];
    std::array<float, kMaxSuns> peak{};
    float rim = 0;
    for (std::size_t i = 0; i < std::size_t(out.count); ++i) {
        peak[i] = float(out.candidates[i].sun.irradiance[channel] * kernel_peak_);
        rim = std::max(rim, kLobeEdge * peak[i]);
    }
    float scale = 1;
    for (std::size_t d = 0; d < kGrid; ++d) {
        float sum = 0;
        for (std::size_t i = 0; i < std::size_t(out.count); ++i) sum += peak[i] * kernels_[i][d];
        if (sum > rim) scale = std::min(scale, std::max(0.0f, light[d] / sum));
    }
    return scale;
}

// 1. Fits all suns to bands >= 1 at once: E_i + sum_j c_j g_ij E_j = b_i, where b is the fit of each alone and g their
//    overlap. Band 0 is left to the sky. 2. Caps each. 3. Multiplies by its share, and by what several need together.
void LightFactor::fillIrradiance(std::span<const double> sh, std::span<const double> windowed,
                                 FactoredLight& out) const {
    const auto count = std::size_t(coefficientCount(order_)), suns = std::size_t(out.count);
    const double norm = (order_ * order_ - 1) / (4 * pi);  // sum of y_lm^2 over bands >= 1
    constexpr int kRounds = 24;                            // g is below 0.3, so that the rounds converge to 1e-9
    for (std::size_t c = 0; c < 3; ++c) {
        std::array<double, kMaxSuns> alone{}, joint{};
        std::array<std::array<double, kMaxSuns>, kMaxSuns> overlap{};
        for (std::size_t a = 0; a < suns; ++a) {
            double at_peak = 0;
            for (std::size_t i = 0; i < count; ++i) at_peak += peaks_[a].basis[i] * windowed[3 * i + c];
            for (std::size_t i = 1; i < count; ++i) alone[a] += peaks_[a].basis[i] * sh[3 * i + c] / norm;
            for (std::size_t b = 0; b < suns; ++b)
                for (std::size_t i = 1; a != b && i < count; ++i)
                    overlap[a][b] += peaks_[a].basis[i] * peaks_[b].basis[i] / norm;
            out.candidates[a].most[int(c)] = mostIrradiance(int(a), int(c), at_peak);
        }
        joint = alone;
        for (int round = 0; round < kRounds && suns > 1; ++round) {
            const std::array<double, kMaxSuns> last = joint;
            for (std::size_t a = 0; a < suns; ++a) {
                joint[a] = alone[a];
                for (std::size_t b = 0; b < suns; ++b)
                    joint[a] -= out.candidates[b].share * overlap[a][b] * std::max(0.0, last[b]);
            }
        }
        for (std::size_t a = 0; a < suns; ++a) {
            SunCandidate& candidate = out.candidates[a];
            candidate.least_squares[int(c)] = joint[a];
            candidate.sun.irradiance[int(c)] = candidate.share * std::clamp(joint[a], 0.0, candidate.most[int(c)]);
        }
        const double scale = suns > 1 ? commonScale(int(c), out) : 1;
        for (std::size_t a = 0; a < suns; ++a) out.candidates[a].sun.irradiance[int(c)] *= scale;
    }
}

// Nowrouzezahrai 2011 eq. 9-13 with eq. 10 normalised. Band 1 of a delta is E sqrt(3/4pi) (-y, z, -x) of its direction.
FactoredLight LightFactor::factorAsPrinted(std::span<const double> sh) const {
    Vec3d channels[3], sum;
    for (int c = 0; c < 3; ++c) {
        const auto i = std::size_t(c);
        channels[c] = std::sqrt(4 * pi / 3) * Vec3d{-sh[9 + i], -sh[3 + i], sh[6 + i]};
        sum += luminance(Vec3d{c == 0 ? 1.0 : 0, c == 1 ? 1.0 : 0, c == 2 ? 1.0 : 0}) * channels[c];
    }
    FactoredLight out;
    SunCandidate& candidate = out.candidates[0];
    candidate.sun.direction = normalized(sum);
    if (length(candidate.sun.direction) == 0) return out;
    for (int c = 0; c < 3; ++c) {
        candidate.least_squares[c] = dot(channels[c], candidate.sun.direction);
        candidate.sun.irradiance[c] = std::max(0.0, candidate.least_squares[c]);
    }
    candidate.most = candidate.sun.irradiance;
    candidate.dominance = candidate.share = 1;
    out.count = 1;
    return out;
}

namespace {

template <class T>
void subtract(std::span<const BasicSun<T>> suns, std::span<const T> window, std::span<T> sh) {
    const std::size_t count = sh.size() / 3;
    int order = 1;
    while (std::size_t(coefficientCount(order)) < count) ++order;
    assert(std::size_t(coefficientCount(order)) * 3 == sh.size() && (window.empty() || int(window.size()) == order));
    std::array<T, coefficientCount(kMaxOrder)> basis;
    for (const BasicSun<T>& sun : suns) {
        evalBasis(order, sun.direction, std::span(basis).first(count));
        for (std::size_t i = 0; i < count; ++i) {
            const T y = window.empty() ? basis[i] : basis[i] * window[std::size_t(bandOfIndex(int(i)))];
            for (std::size_t c = 0; c < 3; ++c) sh[3 * i + c] -= sun.irradiance[int(c)] * y;
        }
    }
}

}  // namespace

void subtractSuns(std::span<const Sun> suns, std::span<const float> window, std::span<float> sh) {
    subtract(suns, window, sh);
}
void subtractSuns(std::span<const SunD> suns, std::span<const double> window, std::span<double> sh) {
    subtract(suns, window, sh);
}

}  // namespace penumbra
