#pragma once
// Converts float to IEEE 754 binary16 and back, rounding to nearest even. NaN stays NaN, and too large numbers become
// infinity. _Float16 will not do, because clang 14 has none on x86-64. HDF5's own conversion is 50 times slower.
#include <cstdint>
#include <span>

namespace penumbra {

std::uint16_t floatToHalf(float value);
float halfToFloat(std::uint16_t bits);
// Convert arrays of equal sizes, by F16C where the processor has it.
void floatToHalf(std::span<const float> in, std::span<std::uint16_t> out);
void halfToFloat(std::span<const std::uint16_t> in, std::span<float> out);

}  // namespace penumbra
