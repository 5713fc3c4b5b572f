// Random access into a deflate stream by copies of the decoder: zlib copies all that it needs to go on from a place.
#include "formats/cache/inflate_index.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <mutex>

#include "formats/common/errors.h"

namespace penumbra {

namespace {

constexpr std::uint64_t kCheckpointDistance = std::uint64_t(1) << 20;  // of output
constexpr std::size_t kInputSize = 16384;
constexpr std::size_t kMostResting = 16;
constexpr int kRawDeflate = -15;

// A decoder that stands at one place of the output.
struct Decoder {
    z_stream z{};
    std::uint64_t in = 0, out = 0;  // bytes consumed, bytes produced

    Decoder() {
        if (inflateInit2(&z, kRawDeflate) != Z_OK) throw std::bad_alloc();
    }
    Decoder(const Decoder& other) : in(other.in), out(other.out) {
        if (inflateCopy(&z, const_cast<z_stream*>(&other.z)) != Z_OK) throw std::bad_alloc();
    }
    Decoder& operator=(const Decoder&) = delete;
    ~Decoder() { inflateEnd(&z); }
};

struct Indexed {
    RandomBytes packed;
    std::uint64_t size = 0;
    std::string what;
    std::vector<std::unique_ptr<Decoder>> checkpoints;  // ascending; the first one stands at the stream's start
    std::mutex lock;
    std::map<std::uint64_t, std::unique_ptr<Decoder>> resting;  // where earlier reads ended, by `out`

    [[noreturn]] void fail(const std::string& problem) const { throw InvalidInput(what + ": " + problem); }
};

Bytef* asZlib(std::byte* bytes) { return reinterpret_cast<Bytef*>(bytes); }

// Fills `out`, unless the stream ends before; returns how many bytes were produced.
std::size_t decode(const Indexed& index, Decoder& decoder, std::span<std::byte> out) {
    std::array<std::byte, kInputSize> input;
    decoder.z.next_out = asZlib(out.data());
    decoder.z.avail_out = uInt(out.size());
    for (int result = Z_OK; result != Z_STREAM_END && decoder.z.avail_out > 0;) {
        const std::uint64_t rest = index.packed.size - decoder.in;
        const std::span<std::byte> part =
            std::span(input).first(std::size_t(std::min<std::uint64_t>(kInputSize, rest)));
        index.packed.read(decoder.in, part);
        decoder.z.next_in = asZlib(part.data());
        decoder.z.avail_in = uInt(part.size());
        result = inflate(&decoder.z, Z_NO_FLUSH);
        decoder.in += part.size() - decoder.z.avail_in;
        if (result == Z_MEM_ERROR) throw std::bad_alloc();
        // Without input left, zlib says Z_BUF_ERROR where it cannot go on.
        if (result != Z_OK && result != Z_STREAM_END) index.fail("its compressed data are damaged");
    }
    const std::size_t produced = out.size() - decoder.z.avail_out;
    decoder.out += produced;
    return produced;
}

void buildIndex(Indexed& index, std::uint32_t crc) {
    Decoder decoder;
    std::vector<std::byte> out(kCheckpointDistance);
    uLong sum = crc32(0, nullptr, 0);
    for (std::size_t produced = out.size(); produced == out.size();) {
        index.checkpoints.push_back(std::make_unique<Decoder>(decoder));
        produced = decode(index, decoder, out);
        sum = crc32(sum, asZlib(out.data()), uInt(produced));
        if (decoder.out > index.size) index.fail("its data are longer than stated");
    }
    if (decoder.out != index.size) index.fail("its data are shorter than stated");
    if (sum != crc) index.fail("its checksum is wrong");
}

// The decoder that has least to skip: where an earlier read ended, or a copy of the last checkpoint before `offset`.
std::unique_ptr<Decoder> takeDecoder(Indexed& index, std::uint64_t offset) {
    const Decoder& checkpoint = *index.checkpoints[std::size_t(offset / kCheckpointDistance)];
    {
        const std::lock_guard lock(index.lock);
        auto found = index.resting.upper_bound(offset);
        if (found != index.resting.begin() && (--found)->first >= checkpoint.out)
            return std::move(index.resting.extract(found).mapped());
    }
    return std::make_unique<Decoder>(checkpoint);
}

void readInflated(Indexed& index, std::uint64_t offset, std::span<std::byte> out) {
    if (out.empty()) return;
    std::unique_ptr<Decoder> decoder = takeDecoder(index, offset);
    std::vector<std::byte> skipped(std::size_t(offset - decoder->out));
    if (decode(index, *decoder, skipped) != skipped.size()) index.fail("changed while it was read");
    while (!out.empty()) {
        const std::span<std::byte> part = out.first(std::min<std::size_t>(out.size(), std::size_t(1) << 30));
        if (decode(index, *decoder, part) != part.size()) index.fail("changed while it was read");
        out = out.subspan(part.size());
    }
    const std::lock_guard lock(index.lock);
    index.resting[decoder->out] = std::move(decoder);
    if (index.resting.size() > kMostResting) index.resting.erase(index.resting.begin());
}

}  // namespace

RandomBytes inflateIndexed(const RandomBytes& packed, std::uint64_t size, std::uint32_t crc, const std::string& what) {
    const auto index = std::make_shared<Indexed>();
    index->packed = packed;
    index->size = size;
    index->what = what;
    buildIndex(*index, crc);
    return {size, [index](std::uint64_t offset, std::span<std::byte> out) { readInflated(*index, offset, out); }};
}

}  // namespace penumbra
