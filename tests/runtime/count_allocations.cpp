// This stands in a file of its own, so that no caller sees through operator new and delete. The nothrow form is here
// too: under AddressSanitizer it would not come to ours, but what it gives would still go to our delete.
#include "tests/runtime/count_allocations.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<std::size_t> allocations{0};

}  // namespace

// ThreadSanitizer has operators of its own that do not give way. Under it nothing is counted.
#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define OPERATORS_ARE_TAKEN
#endif
#endif
#ifndef OPERATORS_ARE_TAKEN
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
    ++allocations;
    return std::malloc(size ? size : 1);
}
void* operator new(std::size_t size) {
    if (void* p = operator new(size, std::nothrow)) return p;
    throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete(void* p, const std::nothrow_t&) noexcept { std::free(p); }
#endif

namespace penumbra {
std::size_t allocationCount() { return allocations; }
}  // namespace penumbra
