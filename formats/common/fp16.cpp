#include "formats/common/fp16.h"

#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdlib>
#include <iterator>
#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace penumbra {

std::uint16_t floatToHalf(float value) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(value), sign = bits >> 16 & 0x8000u;
    const std::uint32_t magnitude = bits & 0x7fffffffu;
    if (magnitude > 0x7f800000u) return std::uint16_t(sign | 0x7e00u | (magnitude >> 13 & 0x3ffu));  // NaN, made quiet
    if (magnitude >= 0x477ff000u) return std::uint16_t(sign | 0x7c00u);  // 65520 and more round to infinity
    if (magnitude < 0x38800000u) {
        // Below 2^-14 halves are multiples of 2^-24, the spacing of floats in [1/2, 1): adding 1/2 rounds.
        const float shifted = std::bit_cast<float>(magnitude) + 0.5f;
        return std::uint16_t(sign | (std::bit_cast<std::uint32_t>(shifted) - 0x3f000000u));
    }
    // 13 bits go: add half of the last place kept, less one unless that place is odd (ties to even); re-bias by 112.
    const std::uint32_t rounded = magnitude + 0xfffu + (magnitude >> 13 & 1u);
    return std::uint16_t(sign | (rounded - 0x38000000u) >> 13);
}

float halfToFloat(std::uint16_t bits) {
    const std::uint32_t sign = std::uint32_t(bits & 0x8000u) << 16, exponent = bits >> 10 & 31u,
                        mantissa = bits & 1023u;
    if (exponent == 31) return std::bit_cast<float>(sign | 0x7f800000u | mantissa << 13 | (mantissa ? 0x400000u : 0u));
    if (exponent > 0) return std::bit_cast<float>(sign | (exponent + 112) << 23 | mantissa << 13);
    return std::bit_cast<float>(sign | std::bit_cast<std::uint32_t>(float(mantissa) * 0x1p-24f));
}

namespace {

void toHalfPortable(std::span<const float> in, std::span<std::uint16_t> out) {
    for (std::size_t i = 0; i < in.size(); ++i) out[i] = floatToHalf(in[i]);
}

void toFloatPortable(std::span<const std::uint16_t> in, std::span<float> out) {
    for (std::size_t i = 0; i < in.size(); ++i) out[i] = halfToFloat(in[i]);
}

#ifdef __x86_64__

// Eight values an instruction; the last ones, fewer than eight, take the portable path.
__attribute__((target("avx,f16c"))) void toHalfF16c(std::span<const float> in, std::span<std::uint16_t> out) {
    std::size_t i = 0;
    for (; i + 8 <= in.size(); i += 8)
        _mm_storeu_si128(reinterpret_cast<__m128i*>(out.data() + i),
                         _mm256_cvtps_ph(_mm256_loadu_ps(in.data() + i), _MM_FROUND_TO_NEAREST_INT));
    toHalfPortable(in.subspan(i), out.subspan(i));
}

__attribute__((target("avx,f16c"))) void toFloatF16c(std::span<const std::uint16_t> in, std::span<float> out) {
    std::size_t i = 0;
    for (; i + 8 <= in.size(); i += 8)
        _mm256_storeu_ps(out.data() + i,
                         _mm256_cvtph_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(in.data() + i))));
    toFloatPortable(in.subspan(i), out.subspan(i));
}

constexpr HalfPath kPaths[] = {{"portable", toHalfPortable, toFloatPortable}, {"f16c", toHalfF16c, toFloatF16c}};

// clang 14 cannot ask for F16C; every processor with AVX2 has it.
bool cpuHasF16c() { return __builtin_cpu_supports("avx2"); }

#else

constexpr HalfPath kPaths[] = {{"portable", toHalfPortable, toFloatPortable}};

bool cpuHasF16c() { return false; }

#endif

// The run time converts short rows in inner loops, so the environment is read only once.
const HalfPath& fastestPath() {
    static const HalfPath& fastest = halfPaths().back();
    return fastest;
}

}  // namespace

std::span<const HalfPath> halfPaths() {
    const bool all = cpuHasF16c() && !std::getenv("PENUMBRA_NO_SIMD");
    return std::span(kPaths).first(all ? std::size(kPaths) : 1);
}

void floatToHalf(std::span<const float> in, std::span<std::uint16_t> out) {
    assert(in.size() == out.size());
    fastestPath().to_half(in, out);
}

void halfToFloat(std::span<const std::uint16_t> in, std::span<float> out) {
    assert(in.size() == out.size());
    fastestPath().to_float(in, out);
}

}  // namespace penumbra
