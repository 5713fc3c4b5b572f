// A deflate stream can be entered at any block's start, given its bit offset and the 32 KB of output before it.
#include "formats/cache/inflate_index.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <memory>
#include <mutex>

#include "formats/common/errors.h"

namespace penumbra {

constexpr std::uint64_t kCheckpointDistance = std::uint64_t(1) << 20;  // of output
constexpr std::size_t kWindowSize = 32768;
constexpr std::size_t kInputSize = 16384;
constexpr std::size_t kIdleStreams = 16;
constexpr int kRawDeflate = -15;

namespace {
// A decoder that stands at one place of the output.
struct Stream {
    z_stream z{};
    std::uint64_t in = 0, out = 0;  // bytes consumed (buffered ones included), bytes produced
    std::array<std::byte, kInputSize> input;

    Stream() {
        if (inflateInit2(&z, kRawDeflate) != Z_OK) throw std::bad_alloc();
    }
    ~Stream() { inflateEnd(&z); }
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;
};

struct Checkpoint {
    std::uint64_t in = 0, out = 0;
    int bits = 0;  // of the byte before `in` that belong to the next block
    std::vector<std::byte> window;
};

struct Indexed {
    RandomBytes packed;
    std::uint64_t size = 0;
    std::string what;
    std::vector<Checkpoint> checkpoints;  // ascending; the first one is the stream's start
    std::mutex lock;
    std::vector<std::unique_ptr<Stream>> idle;

    [[noreturn]] void fail(const std::string& problem) const { throw InvalidInput(what + ": " + problem); }
};

Bytef* asZlib(std::byte* bytes) { return reinterpret_cast<Bytef*>(bytes); }

// Runs the decoder into `out` until that is full, the stream ends or, with Z_BLOCK, a block ends. False at the end.
bool step(const Indexed& index, Stream& stream, std::span<std::byte> out, int flush, std::size_t& produced) {
    if (stream.z.avail_in == 0) {
        const std::size_t more = std::size_t(std::min<std::uint64_t>(kInputSize, index.packed.size - stream.in));
        index.packed.read(stream.in, std::span(stream.input).first(more));
        stream.in += more;
        stream.z.next_in = asZlib(stream.input.data());
        stream.z.avail_in = uInt(more);
    }
    stream.z.next_out = asZlib(out.data());
    stream.z.avail_out = uInt(out.size());
    const uInt before = stream.z.avail_in;
    const int result = inflate(&stream.z, flush);
    produced = out.size() - stream.z.avail_out;
    stream.out += produced;
    if (result == Z_STREAM_END) return false;
    if (result == Z_MEM_ERROR) throw std::bad_alloc();
    const bool stuck = produced == 0 && stream.z.avail_in == before && stream.in == index.packed.size;
    if ((result != Z_OK && result != Z_BUF_ERROR) || stuck) index.fail("its compressed data are damaged");
    return true;
}

Checkpoint checkpointOf(Stream& stream) {
    Checkpoint point{stream.in - stream.z.avail_in, stream.out, stream.z.data_type & 7, {}};
    point.window.resize(kWindowSize);
    uInt filled = 0;
    inflateGetDictionary(&stream.z, asZlib(point.window.data()), &filled);
    point.window.resize(filled);
    return point;
}

void buildIndex(Indexed& index, std::uint32_t crc) {
    Stream stream;
    std::vector<std::byte> out(std::size_t(1) << 18);
    uLong sum = crc32(0, nullptr, 0);
    index.checkpoints.push_back({});
    for (bool more = true; more;) {
        std::size_t produced = 0;
        more = step(index, stream, out, Z_BLOCK, produced);
        sum = crc32(sum, asZlib(out.data()), uInt(produced));
        if (stream.out > index.size) index.fail("its data are longer than stated");
        const bool block_starts = (stream.z.data_type & 128) != 0 && (stream.z.data_type & 64) == 0;
        if (more && block_starts && stream.out - index.checkpoints.back().out >= kCheckpointDistance)
            index.checkpoints.push_back(checkpointOf(stream));
    }
    if (stream.out != index.size) index.fail("its data are shorter than stated");
    if (sum != crc) index.fail("its checksum is wrong");
}

std::unique_ptr<Stream> streamAt(const Indexed& index, const Checkpoint& point) {
    auto stream = std::make_unique<Stream>();
    stream->in = point.in;
    stream->out = point.out;
    if (point.bits != 0) {
        std::byte last;
        index.packed.read(point.in - 1, std::span(&last, 1));
        inflatePrime(&stream->z, point.bits, int(last) >> (8 - point.bits));
    }
    if (!point.window.empty())
        inflateSetDictionary(&stream->z, reinterpret_cast<const Bytef*>(point.window.data()),
                             uInt(point.window.size()));
    return stream;
}

// The idle decoder that has least to skip, or a new one at the last checkpoint before `offset`.
std::unique_ptr<Stream> takeStream(Indexed& index, std::uint64_t offset) {
    const auto after = std::upper_bound(index.checkpoints.begin(), index.checkpoints.end(), offset,
                                        [](std::uint64_t o, const Checkpoint& p) { return o < p.out; });
    const Checkpoint& point = *(after - 1);
    {
        const std::lock_guard lock(index.lock);
        auto best = index.idle.end();
        for (auto it = index.idle.begin(); it != index.idle.end(); ++it)
            if ((*it)->out <= offset && (*it)->out >= point.out &&
                (best == index.idle.end() || (*it)->out > (*best)->out))
                best = it;
        if (best != index.idle.end()) {
            std::unique_ptr<Stream> stream = std::move(*best);
            index.idle.erase(best);
            return stream;
        }
    }
    return streamAt(index, point);
}

void readInflated(Indexed& index, std::uint64_t offset, std::span<std::byte> out) {
    if (out.empty()) return;
    std::unique_ptr<Stream> stream = takeStream(index, offset);
    std::vector<std::byte> skipped(std::size_t(std::min<std::uint64_t>(offset - stream->out, std::size_t(1) << 16)));
    while (!out.empty()) {
        std::size_t produced = 0;
        const std::uint64_t left = offset - std::min(offset, stream->out);
        const bool skips = left > 0;
        const std::span<std::byte> to =
            skips ? std::span(skipped).first(std::size_t(std::min<std::uint64_t>(left, skipped.size())))
                  : out.first(std::min<std::size_t>(out.size(), std::size_t(1) << 30));
        const bool more = step(index, *stream, to, Z_NO_FLUSH, produced);
        if (!skips) out = out.subspan(produced);
        if (!more && !out.empty()) index.fail("changed while it was read");
        if (!more) return;  // a decoder at the end cannot go on
    }
    const std::lock_guard lock(index.lock);
    if (index.idle.size() == kIdleStreams) index.idle.erase(index.idle.begin());
    index.idle.push_back(std::move(stream));
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
