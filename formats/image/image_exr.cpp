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

void checkWindow(const Imf::Header& header, const std::string& name) {
    if (header.displayWindow() != header.dataWindow())
        throw Unsupported(name + ": the data window differs from the display window (a cropped or overscan picture)");
    constexpr int kMaxChannels = 256;  // bounds the decoder's buffers, which hold every channel
    int count = 0;
    for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) ++count;
    if (count > kMaxChannels) throw Unsupported(name + ": more than 256 channels");
}

void checkChannel(const Imf::Header& header, const std::string& needed, const std::string& name) {
    const Imf::Channel* channel = header.channels().findChannel(needed);
    if (!channel) throw InvalidInput(name + ": no channel " + needed);
    if (channel->xSampling != 1 || channel->ySampling != 1)
        throw InvalidInput(name + ": channel " + needed + " is subsampled");
}

int widthOf(const Imf::InputFile& file) {
    const Imath::Box2i window = file.header().dataWindow();
    return window.max.x - window.min.x + 1;
}

int heightOf(const Imf::InputFile& file) {
    const Imath::Box2i window = file.header().dataWindow();
    return window.max.y - window.min.y + 1;
}

int bandRows(const Imf::InputFile& file) {
    constexpr int kBandPixels = 1 << 20;
    return std::clamp(kBandPixels / widthOf(file), 1, std::min(256, heightOf(file)));
}

// Decodes rows in bands, and what take() makes of them grows. So a short file that claims a large size fails before it
// takes much memory. insert(add) names the channels by add(channel, first float, stride in bytes), whose memory holds
// bandRows() rows; take(count) copies the first `count` pixels.
void readBands(Imf::InputFile& file, const auto& insert, const auto& take) {
    const Imath::Box2i window = file.header().dataWindow();
    const std::size_t width = std::size_t(widthOf(file));
    const int band_rows = bandRows(file);
    for (int y = window.min.y; y <= window.max.y; y += band_rows) {
        const int last = std::min(y + band_rows - 1, window.max.y);
        Imf::FrameBuffer buffer;
        const Imath::Box2i rows(Imath::V2i(window.min.x, y), Imath::V2i(window.max.x, last));
        insert([&](const std::string& channel, float* first, std::size_t stride) {
            buffer.insert(channel, Imf::Slice::Make(Imf::FLOAT, first, rows, stride, stride * width));
        });
        file.setFrameBuffer(buffer);
        file.readPixels(y, last);
        take(std::ptrdiff_t(width * std::size_t(last - y + 1)));
    }
}

Image readColors(Imf::InputFile& file) {
    Image image;
    image.width = widthOf(file);
    image.height = heightOf(file);
    const bool has_alpha = file.header().channels().findChannel("A") != nullptr;
    std::vector<Vec3> band(std::size_t(image.width) * std::size_t(bandRows(file)));
    std::vector<float> alpha(has_alpha ? band.size() : 0);
    readBands(
        file,
        [&](const auto& add) {
            add("R", &band[0].x, sizeof(Vec3));
            add("G", &band[0].y, sizeof(Vec3));
            add("B", &band[0].z, sizeof(Vec3));
            if (has_alpha) add("A", alpha.data(), sizeof(float));
        },
        [&](std::ptrdiff_t count) {
            image.pixels.insert(image.pixels.end(), band.begin(), band.begin() + count);
            if (has_alpha) image.alpha.insert(image.alpha.end(), alpha.begin(), alpha.begin() + count);
        });
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

// Opens a file, calls read(file), and gives every failure the file's name.
auto decoded(std::span<const std::byte> bytes, const std::string& name, const auto& read) {
    Imf::Header::setMaxImageSize(kMaxImageSide, kMaxImageSide);
    Imf::Header::setMaxTileSize(kMaxImageSide, kMaxImageSide);
    try {
        MemoryReader reader(bytes, name);
        Imf::InputFile file(reader, /*numThreads=*/0);
        checkWindow(file.header(), name);
        return read(file);
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

// Returns the channel that is meant: the wanted one, the only one, or the one that is named as numbers usually are.
std::string channelOf(const Imf::Header& header, const std::string& wanted, const std::string& name) {
    if (!wanted.empty()) return wanted;
    std::vector<std::string> all;
    for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel)
        all.emplace_back(channel.name());
    if (all.size() == 1) return all.front();
    for (const char* usual : {"R", "Y", "Z"})
        if (std::ranges::find(all, usual) != all.end()) return usual;
    throw InvalidInput(name + ": has " + std::to_string(all.size()) +
                       " channels, none of them R, Y or Z; \"array\" says which is meant");
}

}  // namespace

Image decodeExr(std::span<const std::byte> bytes, const std::string& name) {
    return decoded(bytes, name, [&](Imf::InputFile& file) {
        for (const char* needed : {"R", "G", "B"}) checkChannel(file.header(), needed, name);
        Image image = readColors(file);
        toRec709(file.header(), image);
        return image;
    });
}

GrayImage decodeExrChannel(std::span<const std::byte> bytes, const std::string& name, const GrayChoice& choice) {
    return decoded(bytes, name, [&](Imf::InputFile& file) {
        const std::string channel = channelOf(file.header(), choice.channel, name);
        checkChannel(file.header(), channel, name);
        GrayImage image{widthOf(file), heightOf(file), {}};
        std::vector<float> band(std::size_t(image.width) * std::size_t(bandRows(file)));
        readBands(
            file, [&](const auto& add) { add(channel, band.data(), sizeof(float)); },
            [&](std::ptrdiff_t count) {
                image.numbers.insert(image.numbers.end(), band.begin(), band.begin() + count);
            });
        return image;
    });
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
