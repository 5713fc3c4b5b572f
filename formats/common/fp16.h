#pragma once
// float <-> IEEE 754 binary16, round to nearest even; NaN stays NaN, too large becomes infinity. Not _Float16: clang 14
// has none on x86-64. Not HDF5's own conversion: 50 times slower.
#include <cstdint>
#include <span>

namespace penumbra {

std::uint16_t floatToHalf(float value);
float halfToFloat(std::uint16_t bits);
// Arrays, by the path that was the fastest at the first call. Both arrays have the same size.
void floatToHalf(std::span<const float> in, std::span<std::uint16_t> out);
void halfToFloat(std::span<const std::uint16_t> in, std::span<float> out);

struct HalfPath {
    const char* name;
    void (*to_half)(std::span<const float> in, std::span<std::uint16_t> out);
    void (*to_float)(std::span<const std::uint16_t> in, std::span<float> out);
};
// The paths that this processor can run, slowest first; PENUMBRA_NO_SIMD leaves only the portable one. All of them give
// the same bits.
std::span<const HalfPath> halfPaths();

}  // namespace penumbra
