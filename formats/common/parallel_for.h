#pragma once
#include <cstddef>
#include <functional>

namespace penumbra {

// Calls body(i) once for every i in [0, count), on up to `threads` threads (0: all cores), in any order. So a body
// may write only to places of its own i. When all running bodies have ended, the first exception is thrown again
// here. TBB does the work, or std::thread with PENUMBRA_STD_THREAD. More threads than cores really run
// (global_control is raised).
void parallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

int hardwareThreads();

}  // namespace penumbra
