#include "formats/image/picture_kinds.h"

#include <algorithm>
#include <iterator>

#include "formats/image/image_codecs.h"

namespace penumbra {

namespace {

constexpr PictureKind kKinds[] = {
    {.name = "OpenEXR", .looks = looksLikeExr, .light = openExr, .gray = decodeExrChannel},
    {.name = "Radiance HDR", .looks = looksLikeHdr, .light = openHdr},
    {.name = "PNG", .looks = looksLikePng, .gray = decodeGrayPng},
};

}  // namespace

// Here and not beside its codec, so that who links no JPEG library can name what it refuses.
bool looksLikeJpeg(std::span<const std::byte> bytes) {
    return bytes.size() >= 3 && bytes[0] == std::byte(0xFF) && bytes[1] == std::byte(0xD8) &&
           bytes[2] == std::byte(0xFF);
}

const PictureKind* findPictureKind(std::span<const std::byte> bytes) {
    const auto found = std::ranges::find_if(kKinds, [&](const PictureKind& kind) { return kind.looks(bytes); });
    return found == std::end(kKinds) ? nullptr : found;
}

}  // namespace penumbra
