#include "formats/image/texture_file.h"

#include <algorithm>
#include <string_view>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "formats/image/image_codecs.h"

namespace penumbra {

namespace {

// Returns "is WebP, " and the like for kinds of pictures that materials often have and that are not read.
std::string otherKind(std::span<const std::byte> bytes) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), std::min<std::size_t>(bytes.size(), 16));
    if (text.starts_with("RIFF") && text.substr(std::min<std::size_t>(8, text.size())).starts_with("WEBP"))
        return "is WebP, ";
    if (text.starts_with("\xabKTX 20")) return "is KTX2, ";
    if (text.starts_with("DDS ")) return "is DDS, ";
    return "";
}

}  // namespace

TexturePicture decodeTexture(std::span<const std::byte> bytes, const std::string& name) {
    if (looksLikePng(bytes)) return decodePng(bytes, name);
    if (looksLikeJpeg(bytes)) return decodeJpeg(bytes, name);
    throw Unsupported(name + ": " + otherKind(bytes) + "neither a PNG nor a JPEG picture");
}

TexturePicture readTexture(const std::filesystem::path& path, const std::string& name) {
    return decodeTexture(readImageBytes(path), name);
}

std::vector<std::byte> readTextureBytes(const std::filesystem::path& path) { return readImageBytes(path); }

void checkTextureSize(std::uint64_t width, std::uint64_t height, std::uint64_t most_pixels, const std::string& name) {
    const std::string size = std::to_string(width) + " x " + std::to_string(height) + " pixels";
    if (width == 0 || height == 0 || width > kMaxTextureSide || height > kMaxTextureSide)
        throw InvalidInput(name + ": has " + size + "; a side has 1.." + std::to_string(kMaxTextureSide));
    if (width * height > most_pixels) throw InvalidInput(name + ": is cut short: too few bytes for " + size);
}

void writeTexturePng(const std::filesystem::path& path, const TexturePicture& picture) {
    writeWholeFile(path, encodePng(picture));
}

}  // namespace penumbra
