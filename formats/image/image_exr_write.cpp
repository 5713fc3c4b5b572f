// Writes OpenEXR.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>

#include "formats/image/image_codecs.h"

namespace penumbra {

namespace {

class MemoryWriter : public Imf::OStream {
public:
    MemoryWriter() : Imf::OStream("memory") {}
    void write(const char in[], int n) override {
        if (position_ + std::uint64_t(n) > bytes.size()) bytes.resize(position_ + std::uint64_t(n));
        std::memcpy(bytes.data() + position_, in, std::size_t(n));
        position_ += std::uint64_t(n);
    }
    std::uint64_t tellp() override { return position_; }
    void seekp(std::uint64_t position) override { position_ = position; }

    std::vector<std::byte> bytes;

private:
    std::uint64_t position_ = 0;
};

std::vector<half> halfChannel(std::size_t count, const auto& value) {
    std::vector<half> channel(count);
    for (std::size_t i = 0; i < count; ++i) channel[i] = half(std::clamp(value(i), -float(HALF_MAX), float(HALF_MAX)));
    return channel;
}

}  // namespace

std::vector<std::byte> encodeExr(const Image& image) {
    assert(image.width > 0 && image.height > 0 &&
           image.pixels.size() == std::size_t(image.width) * std::size_t(image.height));
    const std::size_t count = image.pixels.size();
    Imf::Header header(image.width, image.height);
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::FrameBuffer buffer;
    std::array<std::vector<half>, 4> channels;
    const auto add = [&](int index, const char* channel_name, const auto& value) {
        channels[std::size_t(index)] = halfChannel(count, value);
        header.channels().insert(channel_name, Imf::Channel(Imf::HALF));
        buffer.insert(channel_name, Imf::Slice(Imf::HALF, reinterpret_cast<char*>(channels[std::size_t(index)].data()),
                                               sizeof(half), sizeof(half) * std::size_t(image.width)));
    };
    add(0, "R", [&](std::size_t i) { return image.pixels[i].x; });
    add(1, "G", [&](std::size_t i) { return image.pixels[i].y; });
    add(2, "B", [&](std::size_t i) { return image.pixels[i].z; });
    if (!image.alpha.empty()) add(3, "A", [&](std::size_t i) { return image.alpha[i]; });
    MemoryWriter writer;
    {
        Imf::OutputFile file(writer, header, /*numThreads=*/0);
        file.setFrameBuffer(buffer);
        file.writePixels(image.height);
    }  // the destructor writes the table of offsets
    return std::move(writer.bytes);
}

}  // namespace penumbra
