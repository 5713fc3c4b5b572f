#pragma once
// HDF5 keeps text of variable length in "global heaps", the only structure of a file of HDF5 1.10 that has no checksum,
// and HDF5 1.10.8 trusts the sizes in it: one changed bit makes it read and write outside of its memory. So we walk
// through all of them before HDF5 does. (File format specification 3.0, III.E "Global Heap".)
#include <cstddef>
#include <span>
#include <string>

namespace penumbra {

// `file`: all bytes, addresses and lengths of 8 bytes, no user block. InvalidInput, starting with `name`, when an
// object of a heap does not lie inside of it, or when a reference to one gives another length than the object has.
void checkGlobalHeaps(std::span<const std::byte> file, const std::string& name);

}  // namespace penumbra
