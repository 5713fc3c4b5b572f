#pragma once
#include <cstddef>
#include <functional>

namespace penumbra {

// Calls body(i) once for every i in [0, count), on up to `threads` threads (0: all cores). The order is unspecified: a
// body writes only to places of its own i. The first exception is rethrown here after all running bodies have ended.
// TBB behind it, or std::thread with PENUMBRA_STD_THREAD. More threads than cores really run (global_control is
// raised).
void parallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

int hardwareThreads();

}  // namespace penumbra
