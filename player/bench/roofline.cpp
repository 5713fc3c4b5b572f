#include "player/bench/roofline.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>

#include "formats/common/write_file.h"

namespace penumbra {

namespace {

double secondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Is busy for 30 ms: threads that began on one core are on a core each after that.
void spread() {
    const auto start = std::chrono::steady_clock::now();
    while (secondsSince(start) < 0.03) continue;
}

// Returns the shortest of `runs` times that body(thread) takes on all threads, started together. Threads spin, since
// waking one up takes longer than some of what is measured.
template <class Body>
double bestTime(int runs, int threads, const Body& body) {
    std::atomic<int> begun{0}, ended{0};
    std::vector<std::thread> helpers;
    for (int t = 1; t < threads; ++t)
        helpers.emplace_back([&, t] {
            spread();
            for (int run = 1; run <= runs; ++run) {
                while (begun < run) std::this_thread::yield();
                body(t);
                ++ended;
            }
        });
    if (threads > 1) spread();
    double best = 1e30;
    for (int run = 1; run <= runs; ++run) {
        const auto start = std::chrono::steady_clock::now();
        begun = run;
        body(0);
        while (ended < run * (threads - 1)) std::this_thread::yield();
        best = std::min(best, secondsSince(start));
    }
    for (std::thread& helper : helpers) helper.join();
    return best;
}

double peakOf(const RooflinePath& path, int threads, std::vector<float>& sink) {
    constexpr std::size_t kRounds = 20000;  // some 30 us
    const double seconds =
        bestTime(100, threads, [&](int t) { sink[16 * std::size_t(t)] = path.multiply_adds(kRounds); });
    return double(kRounds * path.flop_a_round * std::size_t(threads)) / seconds * 1e-9;
}

Bandwidth bandwidthOf(const RooflinePath& path, int threads, std::size_t bytes, float* numbers,
                      std::vector<float>& sink) {
    const std::size_t third = std::max<std::size_t>(bytes / 4 / 3 / std::size_t(threads) / 64 * 64, 64),
                      share = 3 * third;
    const int runs = int(std::clamp<std::size_t>(std::size_t(1e9) / bytes, 8, 500));
    // small sets go several times, as the clock is not that fine
    const std::size_t passes = std::max<std::size_t>(1, (1 << 20) / bytes);
    const auto rate = [&](double seconds) {
        return double(passes * share * 4 * std::size_t(threads)) / seconds * 1e-9;
    };
    Bandwidth result;
    result.bytes = bytes;
    result.read = rate(bestTime(runs, threads, [&](int t) {
        for (std::size_t p = 0; p < passes; ++p)
            sink[16 * std::size_t(t)] += path.read(numbers + std::size_t(t) * share, share);
    }));
    result.triad = rate(bestTime(runs, threads, [&](int t) {
        float* mine = numbers + std::size_t(t) * share;
        for (std::size_t p = 0; p < passes; ++p) path.triad(mine, mine + third, mine + 2 * third, third);
    }));
    return result;
}

}  // namespace

Roofline measureRoofline(int threads, const std::vector<std::size_t>& working_sets) {
    const RooflinePath& path = fastestPath<RooflinePath>();
    Roofline roofline;
    roofline.path = path.name;
    roofline.threads = threads;
    std::vector<float> sink(16 * std::size_t(threads));  // a cache line a thread
    roofline.peak = peakOf(path, threads, sink);
    std::size_t most = 0;
    for (std::size_t bytes : working_sets) most = std::max(most, bytes);
    std::vector<float> memory(most / 4 + 64 * 3 * std::size_t(threads) + 16, 1.0f);
    float* aligned = memory.data();
    while (reinterpret_cast<std::uintptr_t>(aligned) % 64 != 0) ++aligned;
    for (std::size_t bytes : working_sets) {
        throwIfInterrupted();
        roofline.memory.push_back(bandwidthOf(path, threads, bytes, aligned, sink));
    }
    return roofline;
}

double attainable(const Roofline& roofline, const Bandwidth& memory, double flop_a_byte) {
    return std::min(roofline.peak, flop_a_byte * memory.best());
}

}  // namespace penumbra
