// Reads OpenEXR: scan lines and tiles, any compression, half, float or uint channels, layers and parts, luminance, and
// luminance with chroma of half the resolution.
#include <ImathBox.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticities.h>
#include <OpenEXR/ImfEnvmap.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfStandardAttributes.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "formats/common/fp16.h"
#include "formats/image/color_space.h"
#include "formats/image/image_codecs.h"
#include "formats/image/image_exr_file.h"
#include "formats/image/picture_shape.h"

namespace penumbra {

bool looksLikeExr(std::span<const std::byte> bytes) {
    constexpr std::array<unsigned char, 4> kMagic{0x76, 0x2f, 0x31, 0x01};
    return bytes.size() >= kMagic.size() && std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) == 0;
}

namespace {

int widthOf(const Imath::Box2i& window) { return window.max.x - window.min.x + 1; }
int heightOf(const Imath::Box2i& window) { return window.max.y - window.min.y + 1; }

std::string describeWindow(const Imath::Box2i& window) {
    return std::to_string(widthOf(window)) + " x " + std::to_string(heightOf(window)) + " at (" +
           std::to_string(window.min.x) + ", " + std::to_string(window.min.y) + ")";
}

void checkChannel(const Imf::Header& header, const std::string& needed, const std::string& name) {
    const Imf::Channel* channel = header.channels().findChannel(needed);
    if (!channel) throw InvalidInput(name + ": no channel " + needed);
    if (channel->xSampling != 1 || channel->ySampling != 1)
        throw InvalidInput(name + ": channel " + needed + " is subsampled");
}

bool contains(const Imath::Box2i& outer, const Imath::Box2i& inner) {
    return outer.min.x <= inner.min.x && outer.min.y <= inner.min.y && outer.max.x >= inner.max.x &&
           outer.max.y >= inner.max.y;
}

// Chooses the pixels that are the picture: the display window, or the data window where only that has the shape of a
// layout (a cropped or padded file around a whole picture). What the display window has and the file lacks needs a
// colour.
Imath::Box2i chooseWindow(const Imf::Header& header, const std::string& name, const PictureOptions& options,
                          PictureNotes& notes) {
    const Imath::Box2i data = header.dataWindow(), display = header.displayWindow();
    if (data == display) return data;
    const auto whole = [&](const Imath::Box2i& window) {
        return options.any_shape || hasLayoutShape({widthOf(window), heightOf(window)}, options.layout);
    };
    const std::string both =
        "the data window, " + describeWindow(data) + ", is not the display window, " + describeWindow(display);
    if (!whole(display) && whole(data)) {
        notes.lines.push_back(both + ": the data window is a whole picture and is read");
        return data;
    }
    if (contains(data, display)) {
        notes.lines.push_back(both + ": what lies outside of the display window is cut off");
        return display;
    }
    if (!options.fill)
        throw Unsupported(name + ": " + both + ": no colour is given to fill the pixels that the file lacks");
    const double missing =
        1 - double(std::max(0, std::min(data.max.x, display.max.x) + 1 - std::max(data.min.x, display.min.x))) *
                std::max(0, std::min(data.max.y, display.max.y) + 1 - std::max(data.min.y, display.min.y)) /
                (double(widthOf(display)) * heightOf(display));
    if (missing == 1) {
        notes.warnings.push_back(both +
                                 ", and they do not meet: every pixel is filled, and nothing of the file is seen");
        return display;
    }
    char share[32];
    std::snprintf(share, sizeof share, "%.3g%%", 100 * missing);
    notes.lines.push_back(both + ": " + share + " of the pixels are filled");
    return display;
}

// Reads rows of some channels as floats. Half floats come as they are stored, because our conversion is faster.
class ExrPlanes {
public:
    ExrPlanes(Imf::MultiPartInputFile& file, int part, std::vector<std::string> channels)
        : part_(file, part), channels_(std::move(channels)), window_(part_.header().dataWindow()) {
        for (const std::string& channel : channels_)
            all_half_ = all_half_ && part_.header().channels()[channel.c_str()].type == Imf::HALF;
    }
    const Imath::Box2i& window() const { return window_; }
    // Reads rows first..last of the data window, [channels][rows, width of the data window].
    void read(int first, int last, std::vector<std::vector<float>>& planes) {
        const std::size_t width = std::size_t(widthOf(window_)), count = width * std::size_t(last - first + 1);
        planes.resize(channels_.size());
        halves_.resize(all_half_ ? channels_.size() : 0);
        const Imath::Box2i rows(Imath::V2i(window_.min.x, first), Imath::V2i(window_.max.x, last));
        Imf::FrameBuffer buffer;
        for (std::size_t i = 0; i < channels_.size(); ++i) {
            planes[i].resize(count);
            if (all_half_) halves_[i].resize(count);
            void* start = all_half_ ? static_cast<void*>(halves_[i].data()) : planes[i].data();
            const std::size_t size = all_half_ ? sizeof(std::uint16_t) : sizeof(float);
            buffer.insert(channels_[i],
                          Imf::Slice::Make(all_half_ ? Imf::HALF : Imf::FLOAT, start, rows, size, size * width));
        }
        part_.setFrameBuffer(buffer);
        part_.readPixels(first, last);
        for (std::size_t i = 0; i < halves_.size(); ++i) halfToFloat(halves_[i], planes[i]);
    }

private:
    Imf::InputPart part_;
    std::vector<std::string> channels_;
    Imath::Box2i window_;
    bool all_half_ = true;
    std::vector<std::vector<std::uint16_t>> halves_;
};

// Y with chroma, which OpenEXR's own filters make colours of.
class ExrChroma {
public:
    ExrChroma(Imf::IStream& stream, const std::string& layer) : file_(stream, layer, /*numThreads=*/0) {}
    void read(int first, int last, std::vector<std::vector<float>>& planes) {
        const Imath::Box2i window = file_.dataWindow();
        const std::size_t width = std::size_t(widthOf(window)), count = width * std::size_t(last - first + 1);
        pixels_.resize(count);
        file_.setFrameBuffer(pixels_.data() - (std::ptrdiff_t(first) * std::ptrdiff_t(width) + window.min.x), 1, width);
        file_.readPixels(first, last);
        planes.assign(4, std::vector<float>(count));
        for (std::size_t i = 0; i < count; ++i) {
            planes[0][i] = pixels_[i].r;
            planes[1][i] = pixels_[i].g;
            planes[2][i] = pixels_[i].b;
            planes[3][i] = pixels_[i].a;
        }
    }

private:
    Imf::RgbaInputFile file_;
    std::vector<Imf::Rgba> pixels_;
};

std::optional<Primaries> statedPrimaries(const Imf::Header& header) {
    if (!Imf::hasChromaticities(header)) return std::nullopt;
    const Imf::Chromaticities& c = Imf::chromaticities(header);
    const auto point = [](Imath::V2f at) { return Chromaticity{double(at.x), double(at.y)}; };
    return Primaries{point(c.red), point(c.green), point(c.blue), point(c.white)};
}

const char* layoutOf(Imf::Envmap envmap, const std::string& name) {
    if (envmap == Imf::ENVMAP_CUBE) return "cube";
    if (envmap == Imf::ENVMAP_LATLONG) return "latlong";
    throw InvalidInput(name + ": its attribute envmap is " + std::to_string(int(envmap)) +
                       ", neither lat-long (0) nor a cube (1)");
}

class ExrRows : public PictureRows {
public:
    ExrRows(const RandomBytes& bytes, const std::string& name, const PictureOptions& options)
        : name_(name), stream_(bytes, name), file_(stream_, /*numThreads=*/0), fill_(options.fill.value_or(Vec3{})) {
        checkExrParts(file_, name);
        layer_ = chooseLayer(file_, options.layer, name);
        const Imf::Header& header = file_.header(layer_.part);
        window_ = chooseWindow(header, name, options, info_.notes);
        data_ = header.dataWindow();
        y_ = window_.min.y;
        info_.width = widthOf(window_);
        info_.height = heightOf(window_);
        info_.has_alpha = !layer_.alpha.empty();
        if (Imf::hasEnvmap(header)) info_.layout = layoutOf(Imf::envmap(header), name);
        if (!layer_.shown.empty()) info_.notes.lines.push_back("layer " + layer_.shown);
        chooseColors(statedPrimaries(header), options, name, info_);
        openChannels(bytes, header);
    }

    void next(PictureBand& band) override {
        withExrErrors(name_, [&] { readBand(band); });
    }

private:
    void openChannels(const RandomBytes& bytes, const Imf::Header& header) {
        if (layer_.has_chroma) {
            if (layer_.part > 0) throw Unsupported(name_ + ": luminance with chroma in another part than the first");
            chroma_stream_.emplace(bytes, name_);
            chroma_.emplace(*chroma_stream_, layer_.prefix);
            return;
        }
        std::vector<std::string> channels(layer_.color.begin(), layer_.color.end());
        if (channels[0] == channels[1]) channels.resize(1);
        if (!layer_.alpha.empty()) channels.push_back(layer_.alpha);
        for (const std::string& channel : channels) checkChannel(header, channel, name_);
        planes_.emplace(file_, layer_.part, channels);
    }

    // Rows are decoded in bands, so that a short file that claims a large size fails before it takes much memory.
    void readBand(PictureBand& band) {
        constexpr int kBandPixels = 1 << 18;
        const std::size_t width = std::size_t(info_.width);
        band.rows = std::min(std::clamp(kBandPixels / info_.width, 16, 256), window_.max.y - y_ + 1);
        const int last = y_ + band.rows - 1;
        for (int c = 0; c < 3; ++c) band.color[std::size_t(c)].assign(width * std::size_t(band.rows), fill_[c]);
        band.alpha.assign(info_.has_alpha ? width * std::size_t(band.rows) : 0, 1);
        const int first_there = std::max(y_, data_.min.y), last_there = std::min(last, data_.max.y);
        if (first_there <= last_there) {
            if (chroma_)
                chroma_->read(first_there, last_there, read_);
            else
                planes_->read(first_there, last_there, read_);
            const bool gray = !chroma_ && layer_.color[0] == layer_.color[1];
            for (std::size_t c = 0; c < 3; ++c) place(read_[gray ? 0 : c], first_there, last_there, band.color[c]);
            if (info_.has_alpha) place(read_[gray ? 1 : 3], first_there, last_there, band.alpha);
        }
        y_ = last + 1;
    }

    // Copies what lies in both windows.
    void place(const std::vector<float>& from, int first, int last, std::vector<float>& to) const {
        const int left = std::max(window_.min.x, data_.min.x), right = std::min(window_.max.x, data_.max.x);
        if (left > right) return;
        for (int y = first; y <= last; ++y)
            std::copy_n(from.begin() + std::ptrdiff_t(y - first) * widthOf(data_) + (left - data_.min.x),
                        right - left + 1, to.begin() + std::ptrdiff_t(y - y_) * info_.width + (left - window_.min.x));
    }

    std::string name_;
    ExrBytes stream_;
    Imf::MultiPartInputFile file_;
    Vec3 fill_;
    ExrLayer layer_;
    Imath::Box2i window_, data_;  // the pixels that are the picture; those that the file has
    int y_ = 0;                   // the next row
    std::optional<ExrPlanes> planes_;
    std::optional<ExrBytes> chroma_stream_;
    std::optional<ExrChroma> chroma_;
    std::vector<std::vector<float>> read_;
};

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

std::unique_ptr<PictureRows> openExr(const RandomBytes& bytes, const std::string& name, const PictureOptions& options) {
    limitExr();
    return withExrErrors(name, [&] { return std::make_unique<ExrRows>(bytes, name, options); });
}

GrayImage decodeExrChannel(std::span<const std::byte> bytes, const std::string& name, const GrayChoice& choice) {
    limitExr();
    return withExrErrors(name, [&] {
        ExrBytes stream(bytesOf(bytes), name);
        Imf::MultiPartInputFile file(stream, /*numThreads=*/0);
        checkExrParts(file, name);
        const Imf::Header& header = file.header(0);
        if (header.displayWindow() != header.dataWindow())
            throw Unsupported(name +
                              ": the data window differs from the display window (a cropped or overscan picture)");
        const std::string channel = channelOf(header, choice.channel, name);
        checkChannel(header, channel, name);
        ExrPlanes planes(file, 0, {channel});
        const Imath::Box2i& window = planes.window();
        GrayImage image{widthOf(window), heightOf(window), {}};
        const int band_rows = std::clamp((1 << 20) / image.width, 1, 256);
        std::vector<std::vector<float>> band;
        for (int y = window.min.y; y <= window.max.y; y += band_rows) {
            planes.read(y, std::min(y + band_rows - 1, window.max.y), band);
            image.numbers.insert(image.numbers.end(), band[0].begin(), band[0].end());
        }
        return image;
    });
}

}  // namespace penumbra
