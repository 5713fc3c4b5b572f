#pragma once
// Text of variable length in HDF5 files. HDF5 keeps it in "global heaps", the only structure of a file of HDF5 1.10
// that has no checksum, and HDF5 1.10.8 trusts all sizes and indices in and of them: one changed bit makes it read and
// write outside of its memory. So we walk through the heaps before HDF5 does, and follow references ourselves wherever
// nothing vouches for them. (File format specification 3.0: III.E "Global Heap", IV.A "Data Object Headers".)
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace penumbra {

// `file` in all of these: all bytes, addresses and lengths of 8 bytes, no user block. Messages start with `name`.

// InvalidInput when an object of a heap does not lie inside of it, or when a reference to a large one gives another
// length than the object has.
void checkGlobalHeaps(std::span<const std::byte> file, const std::string& name);

constexpr std::size_t kTextReferenceBytes = 16;
// The text that the reference at `address` stands for; InvalidInput.
std::string textOfReference(std::span<const std::byte> file, std::uint64_t address, const std::string& name);

// The address of the value of an attribute in an object header of version 1, which has no checksum; nothing when the
// header at `object` is of another version (those have). InvalidInput when the attribute is not found.
std::optional<std::uint64_t> uncheckedAttribute(std::span<const std::byte> file, std::uint64_t object,
                                                const std::string& attribute, const std::string& name);

}  // namespace penumbra
