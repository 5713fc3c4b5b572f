#include "formats/image/exif_orientation.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <vector>

namespace penumbra {

namespace {

constexpr std::size_t kHead = 65536;

// Bytes of either order. What lies beyond the end reads as 0.
struct ExifBytes {
    std::span<const std::byte> bytes;
    bool big_endian = true;

    unsigned at(std::size_t place) const { return place < bytes.size() ? unsigned(bytes[place]) : 0; }
    unsigned two(std::size_t place) const {
        const unsigned first = at(place), second = at(place + 1);
        return big_endian ? first << 8 | second : second << 8 | first;
    }
    std::size_t four(std::size_t place) const {
        const std::size_t first = two(place), second = two(place + 2);
        return big_endian ? first << 16 | second : second << 16 | first;
    }
};

// Reads the first directory of a TIFF header.
int orientationOfTiff(std::span<const std::byte> tiff) {
    constexpr unsigned kOrientation = 0x0112;
    ExifBytes in{tiff};
    if (in.two(0) != 0x4949 && in.two(0) != 0x4d4d) return 1;
    in.big_endian = in.two(0) == 0x4d4d;
    const std::size_t directory = in.four(4), entries = in.two(directory);
    for (std::size_t i = 0; i < entries; ++i) {
        const std::size_t entry = directory + 2 + 12 * i;
        if (entry + 12 > tiff.size()) return 1;
        if (in.two(entry) != kOrientation) continue;
        const unsigned value = in.two(entry + 8);
        return value >= 1 && value <= 8 ? int(value) : 1;
    }
    return 1;
}

}  // namespace

int exifOrientation(std::span<const std::byte> jpeg) {
    constexpr unsigned kStart = 0xffd8, kApp1 = 0xffe1, kScan = 0xffda;
    constexpr char kExif[] = "Exif\0";  // the literal adds a second zero at the end
    const ExifBytes in{jpeg};
    if (in.two(0) != kStart) return 1;
    for (std::size_t place = 2; place + 4 <= jpeg.size();) {
        const unsigned marker = in.two(place), length = in.two(place + 2);
        if (marker < 0xff00 || marker == kScan || length < 2) return 1;
        const std::size_t first = place + 4, end = std::min(place + 2 + length, jpeg.size());
        if (marker == kApp1 && end >= first + sizeof kExif && !std::memcmp(&jpeg[first], kExif, sizeof kExif))
            return orientationOfTiff(jpeg.subspan(first + sizeof kExif, end - first - sizeof kExif));
        place += 2 + length;
    }
    return 1;
}

std::string findTurned(std::span<const std::filesystem::path> files) {
    std::vector<std::byte> head(kHead);
    for (const std::filesystem::path& file : files) {
        std::ifstream in(file, std::ios::binary);
        in.read(reinterpret_cast<char*>(head.data()), std::streamsize(head.size()));
        const int value =
            exifOrientation(std::span(head).first(std::size_t(std::max<std::streamsize>(in.gcount(), 0))));
        if (value != 1)
            return file.string() + ": its EXIF says that it is turned (orientation " + std::to_string(value) +
                   "), which is left out: pixels are taken as they are stored";
    }
    return "";
}

}  // namespace penumbra
