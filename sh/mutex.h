#pragma once
// A mutex that is there, and costs nothing, where the standard library was built without threads (WebAssembly).
#include <mutex>

namespace penumbra {

#ifdef __wasm__
struct Mutex {
    void lock() {}
    void unlock() {}
};
#else
using Mutex = std::mutex;
#endif

}  // namespace penumbra
