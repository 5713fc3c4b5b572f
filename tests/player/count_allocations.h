#pragma once
#include <cstddef>

namespace penumbra {

// Calls of operator new by this program so far, on all threads. count_allocations.cpp replaces it.
std::size_t allocationCount();

}  // namespace penumbra
