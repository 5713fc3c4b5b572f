#pragma once
// Measures how long the GPU took for the commands between begin() and end(). The answer comes some frames later,
// without waiting for it. Timers may overlap, since they are pairs of time stamps. Software GL answers too, but not
// with the time that the processor spent: do not show it there.
#include <array>

#include "player/gl/gl_objects.h"

namespace penumbra {

class GpuTimer {
public:
    GpuTimer();
    void begin();
    void end();
    double milliseconds() const { return milliseconds_; }  // time of the last pair that is known; 0 before

private:
    struct Pair {
        GlObject begin, end;
        bool asked = false;
    };
    static constexpr std::size_t kPairs = 4;  // drivers queue at most three frames
    std::array<Pair, kPairs> pairs_;
    std::size_t next_ = 0;
    bool running_ = false;
    double milliseconds_ = 0;
};

}  // namespace penumbra
