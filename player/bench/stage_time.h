#pragma once
// Measures how long something takes. It repeats, because other programs run beside us.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

#include "formats/common/write_file.h"

namespace penumbra {

using Clock = std::chrono::steady_clock;

inline double millisecondsSince(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

inline double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
    return values[values.size() / 2];
}

// Times in milliseconds.
struct StageTime {
    double median = 0, best = 0;
};

// Collects the times that `body(run)` takes in so many runs. prepare(run) comes before each and is not timed. One run
// before the first does not count.
template <class Prepare, class Body>
void collectRuns(int runs, const Prepare& prepare, const Body& body, std::vector<double>& times) {
    for (int run = -1; run < runs; ++run) {
        throwIfInterrupted();
        prepare(std::size_t(run + 1));
        const Clock::time_point start = Clock::now();
        body(std::size_t(run + 1));
        if (run >= 0) times.push_back(millisecondsSince(start));
    }
}

inline StageTime summaryOf(const std::vector<double>& times) {
    return {median(times), *std::min_element(times.begin(), times.end())};
}

template <class Prepare, class Body>
StageTime timeRuns(int runs, const Prepare& prepare, const Body& body) {
    std::vector<double> times;
    collectRuns(runs, prepare, body, times);
    return summaryOf(times);
}

template <class Body>
StageTime timeRuns(int runs, const Body& body) {
    return timeRuns(
        runs, [](std::size_t) {}, body);
}

}  // namespace penumbra
