#pragma once
// Where an HDF5 dataset says that its numbers lie, found out before HDF5 opens it: opening a virtual dataset makes HDF5
// 1.10.8 decode the list of its sources, and it trusts all sizes in there.
// (File format specification 3.0: IV.A "Data Object Headers".)
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace penumbra {

// True when the object at `address` is a virtual dataset or one with external files. `file`: all bytes, addresses and
// lengths of 8 bytes, no user block. InvalidInput, which starts with `name`, when its header is damaged.
bool storedElsewhere(std::span<const std::byte> file, std::uint64_t address, const std::string& name);

}  // namespace penumbra
