#include "formats/image/image_file.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <numbers>

#include "formats/common/check_readable.h"
#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "formats/image/file_picture.h"
#include "formats/image/image_codecs.h"

namespace penumbra {

std::vector<std::byte> readImageBytes(const std::filesystem::path& path) {
    checkReadable(path);
    std::ifstream in(path, std::ios::binary);
    if (!in) throw IoError(path.string() + ": cannot read: " + std::strerror(errno));
    std::vector<std::byte> bytes;
    std::vector<char> buffer(1 << 20);
    do {
        in.read(buffer.data(), std::ptrdiff_t(buffer.size()));
        const auto* first = reinterpret_cast<const std::byte*>(buffer.data());
        bytes.insert(bytes.end(), first, first + in.gcount());
    } while (in);
    if (in.bad()) throw IoError(path.string() + ": cannot read");
    return bytes;
}

Image decodeImage(std::span<const std::byte> bytes, const std::string& name, const PictureOptions& options) {
    const std::unique_ptr<PictureRows> rows = openPicture(bytesOf(bytes), name, options);
    FilePicture picture = readFilePicture(*rows, name, options);
    convertColors(picture.info.to_rec709, picture.image);
    return std::move(picture.image);
}

Image readImage(const std::filesystem::path& path) {
    PictureOptions options;
    options.any_shape = true;
    return decodeImage(readImageBytes(path), path.string(), options);
}

void writeExr(const std::filesystem::path& path, const Image& image) { writeWholeFile(path, encodeExr(image)); }

void writePng(const std::filesystem::path& path, const Image& image, float exposure) {
    writeWholeFile(path, encodePng(image, exposure));
}

void writeImage(const std::filesystem::path& path, const Image& image, float exposure) {
    if (path.extension() == ".exr")
        writeExr(path, image);
    else if (path.extension() == ".png")
        writePng(path, image, exposure);
    else
        throw BadOption("output", path.string() + ": a picture must be named .png or .exr");
}

Vec3d latLongDirection(double u, double v) {
    const double t = std::numbers::pi * v, p = 2 * std::numbers::pi * (u - 0.5);
    return {std::sin(t) * std::cos(p), std::cos(t), std::sin(t) * std::sin(p)};
}

void latLongCoordinates(Vec3d direction, double& u, double& v) {
    u = std::atan2(direction.z, direction.x) / (2 * std::numbers::pi) + 0.5;
    v = std::atan2(std::hypot(direction.x, direction.z), direction.y) / std::numbers::pi;
}

}  // namespace penumbra
