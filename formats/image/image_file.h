#pragma once
// Reads OpenEXR and Radiance HDR pictures, and writes OpenEXR and PNG. RGB, row 0 at the top.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "formats/image/picture_options.h"
#include "sh/vec3.h"

namespace penumbra {

struct Image {
    int width = 0, height = 0;
    std::vector<Vec3> pixels;  // linear Rec.709, multiplied by alpha
    std::vector<float> alpha;  // empty, or one number for each pixel
};

// Reads a picture by its content, not by its name (EXR magic, "#?RADIANCE" / "#?RGBE"). Its colours become linear
// Rec.709, and may be negative then. Throws InvalidInput for a missing channel, NaN, inf or a size above 32768, and
// what openPicture() throws.
Image readImage(const std::filesystem::path& path);
// Does the same with a file's bytes; `name` starts every message.
Image decodeImage(std::span<const std::byte> bytes, const std::string& name, const PictureOptions& options = {});

// Writes EXR: half floats, ZIP, and A when the image has alpha. The bytes are always the same for the same image.
void writeExr(const std::filesystem::path& path, const Image& image);
// Writes PNG: 8 bit, sRGB transfer function of max(0, pixel * exposure / alpha) clamped to 1; alpha as it is.
void writePng(const std::filesystem::path& path, const Image& image, float exposure);
// Returns the bytes of that PNG, row by row: RGB, or RGBA when the image has alpha.
std::vector<std::uint8_t> displayedBytes(const Image& image, float exposure);
// Numbers of 8 bits that are no colours, such as those of a table: nothing is converted, and nothing says sRGB.
struct DataPicture {
    int width = 0, height = 0;
    int channels = 1;                 // 1 (gray), 3 (RGB) or 4 (RGBA)
    std::vector<std::uint8_t> bytes;  // [height, width, channels]
};
// Writes a PNG of them, whole or not at all. Throws IoError.
void writeDataPng(const std::filesystem::path& path, const DataPicture& picture);
// Inverts the sRGB transfer function (IEC 61966-2-1).
float linearFromSrgb(float srgb);
// Writes a picture by its extension. Throws UsageError for anything but .png and .exr.
void writeImage(const std::filesystem::path& path, const Image& image, float exposure);

// Returns the direction of lat-long coordinates u, v in [0,1] (v = 0 at the top, +y). The middle of the picture is
// +x, and u grows towards +z: the sphere is seen from inside and is not mirrored. direction = (sin t cos p, cos t,
// sin t sin p), t = pi v, p = 2 pi (u - 1/2). latLongCoordinates() is its inverse.
Vec3d latLongDirection(double u, double v);
void latLongCoordinates(Vec3d direction, double& u, double& v);

}  // namespace penumbra
