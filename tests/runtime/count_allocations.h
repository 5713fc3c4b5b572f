#pragma once
#include <cstddef>

namespace penumbra {

// Returns the calls of operator new by this program so far, on all threads. count_allocations.cpp replaces that
// operator.
std::size_t allocationCount();

}  // namespace penumbra
