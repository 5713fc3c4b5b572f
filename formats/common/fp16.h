#pragma once
// float <-> IEEE 754 binary16, round to nearest even; NaN stays NaN, too large becomes infinity. Not _Float16: clang 14
// has none on x86-64. Not HDF5's own conversion: 50 times slower.
#include <cstdint>
#include <span>

namespace penumbra {

std::uint16_t floatToHalf(float value);
float halfToFloat(std::uint16_t bits);
// Same sizes; F16C where the processor has it.
void floatToHalf(std::span<const float> in, std::span<std::uint16_t> out);
void halfToFloat(std::span<const std::uint16_t> in, std::span<float> out);

}  // namespace penumbra
