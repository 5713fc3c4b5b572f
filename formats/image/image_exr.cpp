// Reads OpenEXR: scan lines and tiles, any compression, half, float or uint channels, and of several parts the first.
#include <ImathBox.h>
#include <ImathMatrix.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticities.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>

#include "formats/common/errors.h"
#include "formats/image/image_codecs.h"

namespace penumbra {

namespace {

class MemoryReader : public Imf::IStream {
public:
    MemoryReader(std::span<const std::byte> bytes, const std::string& name)
        : Imf::IStream(name.c_str()), bytes_(bytes) {}
    bool read(char out[], int n) override {
        if (n < 0 || std::uint64_t(n) > bytes_.size() - position_) throw InvalidInput("cut short");
        std::memcpy(out, bytes_.data() + position_, std::size_t(n));
        position_ += std::uint64_t(n);
        return position_ < bytes_.size();
    }
    std::uint64_t tellg() override { return position_; }
    void seekg(std::uint64_t position) override {
        if (position > bytes_.size()) throw InvalidInput("cut short");
        position_ = position;
    }

private:
    std::span<const std::byte> bytes_;
    std::uint64_t position_ = 0;
};

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

}  // namespace

bool looksLikeExr(std::span<const std::byte> bytes) {
    constexpr std::array<unsigned char, 4> kMagic{0x76, 0x2f, 0x31, 0x01};
    return bytes.size() >= kMagic.size() && std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) == 0;
}

namespace {

void checkHeader(const Imf::Header& header, const std::string& name) {
    if (header.displayWindow() != header.dataWindow())
        throw Unsupported(name + ": the data window differs from the display window (a cropped or overscan picture)");
    constexpr int kMostChannels = 256;  // bounds the decoder's buffers, which hold every channel
    int count = 0;
    for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) ++count;
    if (count > kMostChannels) throw Unsupported(name + ": more than 256 channels");
    for (const char* needed : {"R", "G", "B"}) {
        const Imf::Channel* channel = header.channels().findChannel(needed);
        if (!channel) throw InvalidInput(name + ": no channel " + needed);
        if (channel->xSampling != 1 || channel->ySampling != 1)
            throw InvalidInput(name + ": channel " + needed + " is subsampled");
    }
}

// Decodes rows in bands, and the picture grows with them. So a short file that claims a large size fails before it
// takes much memory.
Image readRows(Imf::InputFile& file) {
    constexpr int kBandPixels = 1 << 20;
    const Imath::Box2i window = file.header().dataWindow();
    Image image;
    image.width = window.max.x - window.min.x + 1;
    image.height = window.max.y - window.min.y + 1;
    const bool has_alpha = file.header().channels().findChannel("A") != nullptr;
    const std::size_t width = std::size_t(image.width);
    const int band_rows = std::clamp(kBandPixels / image.width, 1, std::min(256, image.height));
    std::vector<Vec3> band(width * std::size_t(band_rows));
    std::vector<float> alpha(has_alpha ? band.size() : 0);
    for (int y = window.min.y; y <= window.max.y; y += band_rows) {
        const int last = std::min(y + band_rows - 1, window.max.y);
        Imf::FrameBuffer buffer;
        const Imath::Box2i rows(Imath::V2i(window.min.x, y), Imath::V2i(window.max.x, last));
        const auto insert = [&](const char* channel, float* first, std::size_t stride) {
            buffer.insert(channel, Imf::Slice::Make(Imf::FLOAT, first, rows, stride, stride * width));
        };
        insert("R", &band[0].x, sizeof(Vec3));
        insert("G", &band[0].y, sizeof(Vec3));
        insert("B", &band[0].z, sizeof(Vec3));
        if (has_alpha) insert("A", alpha.data(), sizeof(float));
        file.setFrameBuffer(buffer);
        file.readPixels(y, last);
        const std::size_t count = width * std::size_t(last - y + 1);
        image.pixels.insert(image.pixels.end(), band.begin(), band.begin() + std::ptrdiff_t(count));
        if (has_alpha) image.alpha.insert(image.alpha.end(), alpha.begin(), alpha.begin() + std::ptrdiff_t(count));
    }
    return image;
}

// Converts files that state other primaries than Rec.709. White points are not adapted.
void toRec709(const Imf::Header& header, Image& image) {
    if (!Imf::hasChromaticities(header)) return;
    const Imf::Chromaticities from = Imf::chromaticities(header), rec709;
    const auto differs = [](Imath::V2f a, Imath::V2f b) { return (a - b).length() > 1e-3f; };
    if (!differs(from.red, rec709.red) && !differs(from.green, rec709.green) && !differs(from.blue, rec709.blue) &&
        !differs(from.white, rec709.white))
        return;
    const Imath::M44f matrix = Imf::RGBtoXYZ(from, 1) * Imf::XYZtoRGB(rec709, 1);  // row vectors
    for (Vec3& p : image.pixels) {
        const Imath::V3f out = Imath::V3f(p.x, p.y, p.z) * matrix;
        p = {out.x, out.y, out.z};
    }
}

}  // namespace

Image decodeExr(std::span<const std::byte> bytes, const std::string& name) {
    Imf::Header::setMaxImageSize(kMaxImageSide, kMaxImageSide);
    Imf::Header::setMaxTileSize(kMaxImageSide, kMaxImageSide);
    try {
        MemoryReader reader(bytes, name);
        Imf::InputFile file(reader, /*numThreads=*/0);
        checkHeader(file.header(), name);
        Image image = readRows(file);
        toRec709(file.header(), image);
        return image;
    } catch (const Unsupported&) {
        throw;
    } catch (const InvalidInput& error) {
        const std::string what = error.what();
        throw InvalidInput(what.starts_with(name) ? what : name + ": " + what);
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        throw InvalidInput(name + ": not a readable OpenEXR picture: " + error.what());
    }
}

namespace {

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
