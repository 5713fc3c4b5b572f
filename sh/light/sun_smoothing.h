#pragma once
// Smooths suns over time. The light of a moving camera or of a video flickers, and shadows with edges show it.
#include <array>
#include <span>

#include "sh/light/dominant_light.h"

namespace penumbra {

// Follows suns with an exponential filter: after t seconds the difference that is left is exp(-t / time_constant). A
// sun that moves is followed on the great circle. A sun that jumps by more than kMaxTurn, or vanishes, fades out where
// it is, and the other fades in where it is. The light stays whole: the remainder is the light of this moment less the
// filtered suns (subtractSuns()).
class SunSmoothing {
public:
    static constexpr double kMaxTurn = 0.35;  // radians between two updates; 20 degrees

    // In seconds, >= 0 and finite; 0 switches the filter off. Throws std::invalid_argument otherwise.
    void setTimeConstant(double seconds);
    // Forgets all suns. The next update() takes its suns as they are.
    void reset() { *this = SunSmoothing(time_constant_); }
    // Goes on by `seconds` >= 0 towards `suns`, at most kMaxSuns, and returns what is there then: at most `most` <=
    // kMaxSuns suns. Where all places are taken, a new sun waits until an old one has faded. The span is valid until
    // the next call. Allocates nothing. Throws std::invalid_argument for seconds that are negative or not finite.
    std::span<const SunD> update(std::span<const SunD> suns, std::size_t most, double seconds);

    explicit SunSmoothing(double seconds = 0.1) { setTimeConstant(seconds); }

private:
    double time_constant_ = 0.1;
    bool started_ = false;
    std::size_t count_ = 0;
    std::array<SunD, kMaxSuns> suns_;
    std::array<double, kMaxSuns> brightest_{};  // luminance of each at its best; what is 1/256 of it is gone

    void take(std::span<const SunD> suns, std::size_t most);
    std::array<bool, kMaxSuns> follow(std::span<const SunD> suns, double part);
    void fadeIn(const SunD& sun, double part);
};

}  // namespace penumbra
