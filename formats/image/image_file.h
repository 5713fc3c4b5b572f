#pragma once
// Pictures: OpenEXR and Radiance HDR in, OpenEXR and PNG out. RGB, row 0 at the top.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

struct Image {
    int width = 0, height = 0;
    std::vector<Vec3> pixels;  // linear Rec.709, multiplied by alpha
    std::vector<float> alpha;  // empty, or one a pixel
};

// By content, not by name (EXR magic, "#?RADIANCE" / "#?RGBE"). A missing channel, NaN, inf or a size above 32768:
// InvalidInput.
Image readImage(const std::filesystem::path& path);
// The same on a file's bytes; `name` starts every message.
Image decodeImage(std::span<const std::byte> bytes, const std::string& name);
// EXR: half floats, ZIP; A when the image has alpha. Deterministic bytes.
void writeExr(const std::filesystem::path& path, const Image& image);
// PNG: 8 bit, sRGB transfer function of max(0, pixel * exposure / alpha) clamped to 1; alpha as it is.
void writePng(const std::filesystem::path& path, const Image& image, float exposure);
// The bytes of that PNG, row by row: RGB, or RGBA when the image has alpha.
std::vector<std::uint8_t> displayedBytes(const Image& image, float exposure);
// The sRGB transfer function (IEC 61966-2-1) back to linear.
float linearFromSrgb(float srgb);
// By extension; anything but .png and .exr is a UsageError.
void writeImage(const std::filesystem::path& path, const Image& image, float exposure);

// Direction of lat-long coordinates u, v in [0,1] (v = 0 at the top, +y). The middle of the picture is +x and u grows
// towards +z: seen from inside, not mirrored. direction = (sin t cos p, cos t, sin t sin p), t = pi v, p = 2 pi (u -
// 1/2).
Vec3d latLongDirection(double u, double v);
void latLongCoordinates(Vec3d direction, double& u, double& v);

}  // namespace penumbra
