#pragma once
// How long the GPU took for what was drawn between begin() and end(), some frames later and without waiting for it.
// Software GL answers, but not with the time that the processor spent: do not show it there.
#include <array>

#include "player/gl_objects.h"

namespace penumbra {

class GpuTimer {
public:
    GpuTimer();
    void begin();
    void end();
    double milliseconds() const { return milliseconds_; }  // of the last frame that is known, 0 before

private:
    static constexpr std::size_t kQueries = 4;  // drivers queue at most three frames
    std::array<GlObject, kQueries> queries_;
    std::array<bool, kQueries> asked_{};
    std::size_t next_ = 0;
    bool running_ = false;
    double milliseconds_ = 0;
};

}  // namespace penumbra
