#pragma once
// Text of variable length in HDF5 files. HDF5 keeps it in "global heaps", the only structure of a file of HDF5 1.10
// that has no checksum, and HDF5 1.10.8 trusts all sizes and indices in them and in the references to them: one changed
// bit makes it read and write outside of its memory. So HDF5 hands us the references, and we read the heaps ourselves.
// The rest of a file is never searched for heaps. (File format specification 3.0: III.E "Global Heap".)
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>

namespace penumbra {

// A dataset holds references in the place of texts. A reference gives the length of the text (4 bytes), the address of
// its heap (8) and its number in the heap (4).
constexpr std::size_t kTextReferenceBytes = 16;

class GlobalHeaps {
public:
    // `file`: all bytes of a file with addresses and lengths of 8 bytes and without a user block. `name` starts
    // messages.
    GlobalHeaps(std::span<const std::byte> file, std::string name);

    // InvalidInput when the heap is damaged, when it has no such text, or when the text has another length. Each heap
    // is walked through once, and all of them together are no longer than the file, whatever the references say.
    std::string text(std::span<const std::byte, kTextReferenceBytes> reference);

    std::uint64_t bytesWalked() const { return bytes_walked_; }

private:
    using Objects = std::map<std::uint32_t, std::span<const std::byte>>;  // by their numbers
    const Objects& heapAt(std::uint64_t address);

    std::span<const std::byte> file_;
    std::string name_;
    std::map<std::uint64_t, Objects> heaps_;  // by their addresses
    std::uint64_t bytes_walked_ = 0;
};

}  // namespace penumbra
