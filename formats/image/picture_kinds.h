#pragma once
// The kinds of pictures that are read as lights and as heights stand in one table: how their first bytes look, and who
// reads them. A new kind is a row there (picture_kinds.cpp) and a file image_NAME.cpp with its codec. The pictures of
// surfaces have texture_file.cpp, since the player links no JPEG library.
#include <cstddef>
#include <span>
#include <string>

#include "formats/image/gray_image.h"
#include "formats/image/picture_rows.h"

namespace penumbra {

struct PictureKind {
    const char* name;
    bool (*looks)(std::span<const std::byte> bytes);
    // Null where a picture of this kind is nothing of the sort.
    std::unique_ptr<PictureRows> (*light)(const RandomBytes& bytes, const std::string& name,
                                          const PictureOptions& options) = nullptr;
    // Throws InvalidInput where the bytes are damaged or cut short, a side is too long, or the channel is not there or
    // subsampled, and Unsupported for a PNG with colours, alpha, a palette or fewer than 8 bits, and for an EXR whose
    // data window differs from its display window.
    GrayImage (*gray)(std::span<const std::byte> bytes, const std::string& name, const GrayChoice& choice) = nullptr;
};

// Returns the kind that the first bytes tell, or null.
const PictureKind* findPictureKind(std::span<const std::byte> bytes);

}  // namespace penumbra
