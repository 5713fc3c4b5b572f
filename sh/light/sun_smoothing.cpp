#include "sh/light/sun_smoothing.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>

namespace penumbra {

namespace {

constexpr double kGone = 1.0 / 256;

double turnBetween(Vec3d a, Vec3d b) { return std::atan2(length(cross(a, b)), dot(a, b)); }

// Goes a part of the way on the great circle. The directions are at most kMaxTurn apart.
Vec3d turned(Vec3d from, Vec3d to, double part) {
    const double angle = turnBetween(from, to);
    if (angle < 1e-9) return to;
    return normalized(std::sin((1 - part) * angle) * from + std::sin(part * angle) * to);
}

}  // namespace

void SunSmoothing::setTimeConstant(double seconds) {
    if (!(seconds >= 0) || !std::isfinite(seconds))
        throw std::invalid_argument("the time constant of the suns must be a finite number of seconds, 0 or more");
    time_constant_ = seconds;
}

void SunSmoothing::take(std::span<const SunD> suns, std::size_t most) {
    count_ = std::min(suns.size(), most);
    for (std::size_t i = 0; i < count_; ++i) suns_[i] = suns[i], brightest_[i] = luminance(suns[i].irradiance);
    started_ = true;
}

// Moves every sun to the nearest of the new ones, or dims it where there is none near. Returns which new ones are known
// now.
std::array<bool, kMaxSuns> SunSmoothing::follow(std::span<const SunD> suns, double part) {
    std::array<bool, kMaxSuns> known{}, moved{};
    for (;;) {
        // 1. The nearest pair of those that are left.
        std::size_t old = kMaxSuns, next = kMaxSuns;
        double nearest = kMaxTurn;
        for (std::size_t i = 0; i < count_; ++i)
            for (std::size_t j = 0; j < suns.size(); ++j) {
                if (moved[i] || known[j]) continue;
                const double turn = turnBetween(suns_[i].direction, suns[j].direction);
                if (turn <= nearest) nearest = turn, old = i, next = j;
            }
        if (old == kMaxSuns) break;
        // 2. One follows the other.
        SunD& sun = suns_[old];
        sun.direction = turned(sun.direction, suns[next].direction, part);
        sun.irradiance += part * (suns[next].irradiance - sun.irradiance);
        sun.radius += part * (suns[next].radius - sun.radius);
        brightest_[old] = std::max(luminance(sun.irradiance), luminance(suns[next].irradiance));
        moved[old] = known[next] = true;
    }
    // 3. The others fade where they are.
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count_; ++i) {
        if (!moved[i]) suns_[i].irradiance *= 1 - part;
        if (!moved[i] && luminance(suns_[i].irradiance) <= kGone * brightest_[i]) continue;
        suns_[kept] = suns_[i], brightest_[kept] = brightest_[i];
        ++kept;
    }
    count_ = kept;
    return known;
}

void SunSmoothing::fadeIn(const SunD& sun, double part) {
    suns_[count_] = sun;
    suns_[count_].irradiance *= part;
    brightest_[count_++] = luminance(sun.irradiance);
}

std::span<const SunD> SunSmoothing::update(std::span<const SunD> suns, std::size_t most, double seconds) {
    assert(suns.size() <= kMaxSuns && most <= kMaxSuns);
    if (!(seconds >= 0) || !std::isfinite(seconds))
        throw std::invalid_argument("suns go on by a finite number of seconds, 0 or more");
    if (!started_ || time_constant_ == 0) {
        take(suns, most);
    } else {
        const double part = -std::expm1(-seconds / time_constant_);
        const std::array<bool, kMaxSuns> known = follow(suns, part);
        for (std::size_t i = 0; i < suns.size(); ++i)
            if (!known[i] && count_ < most && luminance(suns[i].irradiance) > 0) fadeIn(suns[i], part);
    }
    return std::span(suns_).first(count_);
}

}  // namespace penumbra
