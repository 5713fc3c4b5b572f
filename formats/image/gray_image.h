#pragma once
// Reads pictures of one channel as the numbers that they hold, for heights.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace penumbra {

struct GrayImage {
    int width = 0, height = 0;
    std::vector<std::uint16_t> numbers;  // [height, width], as stored: 0..255 or 0..65535
};

bool looksLikePng(std::span<const std::byte> bytes);
// `name` starts every message. Throws InvalidInput where the bytes are damaged or cut short or a side is above `most`,
// and Unsupported for colours, an alpha channel, palettes and fewer than 8 bits.
GrayImage decodeGrayPng(std::span<const std::byte> bytes, const std::string& name, int most);

struct FloatImage {
    int width = 0, height = 0;
    std::vector<float> numbers;  // [height, width], as stored: NaN and infinity, too
};

bool looksLikeExr(std::span<const std::byte> bytes);
// Reads one channel of an OpenEXR picture: the wanted one; without one ("") the only channel, or R, else Y, else Z.
// `name` starts every message. Throws InvalidInput where the bytes are damaged or cut short or the channel is not there
// or subsampled, and Unsupported where the data window differs from the display window.
FloatImage decodeExrChannel(std::span<const std::byte> bytes, const std::string& name, const std::string& wanted);

}  // namespace penumbra
