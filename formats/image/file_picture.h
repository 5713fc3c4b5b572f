#pragma once
// Whole pictures as files have them, before their colours are converted.
#include "formats/image/image_file.h"
#include "formats/image/picture_rows.h"

namespace penumbra {

// A whole picture in the colours of its file, before they are converted: no pixel has NaN or infinity.
struct FilePicture {
    Image image;
    PictureInfo info;
};
FilePicture readFilePicture(PictureRows& rows, const std::string& name, const PictureOptions& options);
// Converts colours; a matrix of none leaves them.
void convertColors(const std::optional<Mat3d>& to_rec709, Image& image);
// Throws InvalidInput, which names the pixel, for NaN or infinity.
void requireFinite(const Image& image, const std::string& name);
// Replaces pixels with NaN or infinity by the mean of the finite ones among the 8 around them. Larger spots are closed
// from their rims inwards. Rows continue at their other ends where the picture `goes_around`, as lat-long does. Counts
// what it did. Throws InvalidInput where no pixel is finite.
enum class RowEnds { kStop, kGoAround };
void repairPixels(Image& image, RowEnds ends, const std::string& name, PictureNotes& notes);

}  // namespace penumbra
