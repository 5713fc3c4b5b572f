#include "formats/hdf5_heap_check.h"

#include <array>
#include <cstdint>
#include <cstring>

#include "formats/errors.h"

namespace penumbra {

constexpr std::array<char, 5> kSignature{'G', 'C', 'O', 'L', 1};  // and the version
constexpr std::size_t kHeaderBytes = 16;  // of a heap (signature, version, size) and of an object (index, uses, size)
constexpr std::size_t kSmallestHeap = 4096;

// HDF5 rounds the buffer that an object is read into up to this; larger objects overrun it when a reference to them
// gives too small a length.
constexpr std::uint64_t kSafeBytes = 4096;

template <class T>
static T valueAt(std::span<const std::byte> bytes, std::size_t offset) {
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);  // little endian, as every HDF5 file is
    return value;
}

static std::size_t find(std::span<const std::byte> bytes, std::size_t from, const void* pattern, std::size_t size) {
    const void* found = ::memmem(bytes.data() + from, bytes.size() - from, pattern, size);
    return found ? std::size_t(static_cast<const std::byte*>(found) - bytes.data()) : bytes.size();
}

// A reference is the length (4 bytes), the heap's address (8) and the object's index (4).
static void checkReferences(std::span<const std::byte> file, std::uint64_t heap, std::uint32_t index,
                            std::uint64_t size, const std::string& name) {
    std::array<std::byte, 12> target;
    std::memcpy(target.data(), &heap, 8);
    std::memcpy(target.data() + 8, &index, 4);
    for (std::size_t at = find(file, 4, target.data(), 12); at < file.size();
         at = find(file, at + 1, target.data(), 12))
        if (valueAt<std::uint32_t>(file, at - 4) != size) throw InvalidInput(name + ": damaged (length of a text)");
}

static void checkHeap(std::span<const std::byte> bytes, std::span<const std::byte> file, std::uint64_t heap,
                      const std::string& name) {
    const InvalidInput damaged(name + ": damaged (global heap)");
    for (std::size_t at = kHeaderBytes; bytes.size() - at >= kHeaderBytes;) {
        const std::uint16_t index = valueAt<std::uint16_t>(bytes, at);
        const std::uint64_t size = valueAt<std::uint64_t>(bytes, at + 8), rest = bytes.size() - at;
        if (size > rest) throw damaged;
        // Object 0 is the free space at the end, its own header included.
        const std::uint64_t taken = index == 0 ? size : kHeaderBytes + (size + 7) / 8 * 8;
        if (taken < kHeaderBytes || taken > rest) throw damaged;
        if (index != 0 && size > kSafeBytes) checkReferences(file, heap, index, size, name);
        at += taken;
    }
}

void checkGlobalHeaps(std::span<const std::byte> file, const std::string& name) {
    for (std::size_t at = find(file, 0, kSignature.data(), kSignature.size()); at < file.size();
         at = find(file, at + 1, kSignature.data(), kSignature.size())) {
        // HDF5 refuses heaps of other sizes; this also sorts out chance occurrences in stored numbers.
        if (file.size() - at < kSmallestHeap) return;
        const std::uint64_t size = valueAt<std::uint64_t>(file, at + 8);
        if (size >= kSmallestHeap && size <= file.size() - at) checkHeap(file.subspan(at, size), file, at, name);
    }
}

}  // namespace penumbra
