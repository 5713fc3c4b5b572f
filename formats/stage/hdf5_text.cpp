#include "formats/stage/hdf5_text.h"

#include <array>
#include <cstring>
#include <utility>

#include "formats/common/errors.h"

namespace penumbra {

namespace {

constexpr std::array<char, 5> kSignature{'G', 'C', 'O', 'L', 1};  // signature and version
constexpr std::size_t kHeaderBytes = 16;  // size of a heap's header (signature, version, size) and of an object's
                                          // (index, uses, size)

template <class T>
T numberAt(std::span<const std::byte> bytes, std::size_t offset) {
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);  // little endian, as every HDF5 file is
    return value;
}

}  // namespace

GlobalHeaps::GlobalHeaps(std::span<const std::byte> file, std::string name) : file_(file), name_(std::move(name)) {}

const GlobalHeaps::Objects& GlobalHeaps::heapAt(std::uint64_t address) {
    if (const auto known = heaps_.find(address); known != heaps_.end()) return known->second;
    const InvalidInput damaged(name_ + ": damaged (global heap)");
    if (address > file_.size() || file_.size() - address < kHeaderBytes) throw damaged;
    std::span<const std::byte> bytes = file_.subspan(address);
    if (std::memcmp(bytes.data(), kSignature.data(), kSignature.size()) != 0) throw damaged;
    const std::uint64_t heap_size = numberAt<std::uint64_t>(bytes, 8);
    if (heap_size < kHeaderBytes || heap_size > bytes.size()) throw damaged;
    bytes = bytes.first(heap_size);

    // Heaps do not overlap. Where they do, a file could make us walk through the same bytes once for each reference.
    if (heap_size > file_.size() - bytes_walked_) throw damaged;
    bytes_walked_ += heap_size;

    Objects objects;
    for (std::size_t at = kHeaderBytes; bytes.size() - at >= kHeaderBytes;) {
        const std::uint16_t index = numberAt<std::uint16_t>(bytes, at);
        const std::uint64_t size = numberAt<std::uint64_t>(bytes, at + 8), rest = bytes.size() - at;
        if (size > rest) throw damaged;
        // Object 0 is the free space at the end, its own header included.
        const std::uint64_t taken = index == 0 ? size : kHeaderBytes + (size + 7) / 8 * 8;
        if (taken < kHeaderBytes || taken > rest) throw damaged;
        if (index != 0) objects.emplace(index, bytes.subspan(at + kHeaderBytes, size));
        at += taken;
    }
    return heaps_.emplace(address, std::move(objects)).first->second;
}

std::string GlobalHeaps::text(std::span<const std::byte, kTextReferenceBytes> reference) {
    const std::uint32_t length = numberAt<std::uint32_t>(reference, 0);
    if (length == 0) return "";
    const Objects& objects = heapAt(numberAt<std::uint64_t>(reference, 4));
    const auto found = objects.find(numberAt<std::uint32_t>(reference, 12));
    if (found == objects.end()) throw InvalidInput(name_ + ": damaged (no such text)");
    if (found->second.size() != length) throw InvalidInput(name_ + ": damaged (length of a text)");
    const char* text = reinterpret_cast<const char*>(found->second.data());
    return std::string(text, ::strnlen(text, length));
}

}  // namespace penumbra
