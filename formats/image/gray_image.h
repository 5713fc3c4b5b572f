#pragma once
// Reads grey PNG pictures as the numbers that they hold, for heights.
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

}  // namespace penumbra
