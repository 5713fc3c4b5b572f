#include "formats/common/progress.h"

#include <algorithm>
#include <cstdio>

namespace penumbra {
using std::chrono::steady_clock;

Progress::Progress(ProgressStyle style, std::string what, std::string unit, double total)
    : style_(style), what_(std::move(what)), unit_(std::move(unit)), total_(total), start_(steady_clock::now()) {}

Progress::~Progress() {
    if (printed_ && style_ == ProgressStyle::kBar) std::fputc('\n', stderr);
}

void Progress::update(double done) {
    const steady_clock::time_point now = steady_clock::now();
    const bool finished = done >= total_;
    if (style_ == ProgressStyle::kNone || (printed_ && !finished && now - last_ < std::chrono::milliseconds(250)))
        return;
    last_ = now;
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    const double percent = 100 * std::clamp(done / total_, 0.0, 1.0);
    const double rate = elapsed > 0 ? done / elapsed : 0, left = rate > 0 ? (total_ - done) / rate : 0;
    char rates[96];
    std::snprintf(rates, sizeof rates, "%.3g of %.3g %s, %.3g/s, %.0f s left", done, total_, unit_.c_str(), rate, left);
    switch (style_) {
        case ProgressStyle::kBar:  // to the start of the line; erase what a longer text left
            std::fprintf(stderr, "\r%s %3.0f%%  %s\033[K", what_.c_str(), percent, rates);
            std::fflush(stderr);
            break;
        case ProgressStyle::kOpenJd:
            std::printf("openjd_progress: %.1f\nopenjd_status: %s %s\n", percent, what_.c_str(), rates);
            std::fflush(stdout);
            break;
        default:
            std::printf("ALF_PROGRESS %.0f%%\n", percent);
            std::fflush(stdout);
    }
    printed_ = true;
}

}  // namespace penumbra
