#include "formats/common/parallel_for.h"

#include <algorithm>
#include <mutex>
#include <thread>
#ifdef PENUMBRA_STD_THREAD
#include <atomic>
#include <exception>
#include <vector>
#else
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <map>
#include <optional>
#endif

namespace penumbra {

int hardwareThreads() { return std::max(1, int(std::thread::hardware_concurrency())); }

#ifdef PENUMBRA_STD_THREAD

namespace {

void runOnThreads(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
    std::atomic<std::size_t> next{0};
    std::exception_ptr first_error;
    std::mutex guard;
    const auto work = [&] {
        for (std::size_t i = next++; i < count; i = next++) try {
                body(i);
            } catch (...) {
                const std::lock_guard lock(guard);
                if (!first_error) first_error = std::current_exception();
                next = count;
            }
    };
    std::vector<std::thread> helpers;
    for (int t = 1; t < threads; ++t) helpers.emplace_back(work);
    work();
    for (std::thread& helper : helpers) helper.join();
    if (first_error) std::rethrow_exception(first_error);
}

}  // namespace

#else

namespace {

// Keeps an arena for each number of threads. Threads look for work in an arena for a while before they sleep, and
// find that of the next loop only in the same arena. A new arena costs some 0.05 ms of a frame. None is ever
// destroyed, since TBB may be gone first.
tbb::task_arena& arenaOf(int threads) {
    static std::mutex guard;
    static auto& arenas = *new std::map<int, tbb::task_arena>;
    const std::lock_guard lock(guard);
    return arenas.try_emplace(threads, threads).first->second;
}

void runOnThreads(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
    // Without this, TBB would cap every arena at the core count.
    std::optional<tbb::global_control> allow;
    if (threads > hardwareThreads()) allow.emplace(tbb::global_control::max_allowed_parallelism, std::size_t(threads));
    arenaOf(threads).execute([&] { tbb::parallel_for(std::size_t(0), count, body); });
}

}  // namespace

#endif

void parallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
    threads = int(std::min<std::size_t>(threads > 0 ? threads : hardwareThreads(), count));
    if (threads > 1) return runOnThreads(count, threads, body);
    for (std::size_t i = 0; i < count; ++i) body(i);
}

}  // namespace penumbra
