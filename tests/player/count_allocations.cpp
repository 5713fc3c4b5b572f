// In a file of its own, so that no caller sees through operator new and delete.
#include "tests/player/count_allocations.h"

#include <atomic>
#include <cstdlib>
#include <new>

static std::atomic<std::size_t> allocations{0};

void* operator new(std::size_t size) {
    ++allocations;
    if (void* p = std::malloc(size ? size : 1)) return p;
    throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }

namespace penumbra {
std::size_t allocationCount() { return allocations; }
}  // namespace penumbra
