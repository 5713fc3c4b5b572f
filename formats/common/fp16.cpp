#include "formats/common/fp16.h"

#include <bit>
#include <cassert>
#include <cstddef>
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

#ifdef __x86_64__

__attribute__((target("avx,f16c"))) static std::size_t toHalfF16c(const float* in, std::uint16_t* out,
                                                                  std::size_t count) {
    std::size_t i = 0;
    for (; i + 8 <= count; i += 8)
        _mm_storeu_si128(reinterpret_cast<__m128i*>(out + i),
                         _mm256_cvtps_ph(_mm256_loadu_ps(in + i), _MM_FROUND_TO_NEAREST_INT));
    return i;
}

__attribute__((target("avx,f16c"))) static std::size_t toFloatF16c(const std::uint16_t* in, float* out,
                                                                   std::size_t count) {
    std::size_t i = 0;
    for (; i + 8 <= count; i += 8)
        _mm256_storeu_ps(out + i, _mm256_cvtph_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(in + i))));
    return i;
}

namespace {

bool hasF16c() {
    // clang 14 cannot ask for F16C; every processor with AVX2 has it.
    static const bool has = __builtin_cpu_supports("avx2");
    return has;
}

}  // namespace

#else

namespace {

std::size_t toHalfF16c(const float*, std::uint16_t*, std::size_t) { return 0; }
std::size_t toFloatF16c(const std::uint16_t*, float*, std::size_t) { return 0; }
bool hasF16c() { return false; }

}  // namespace

#endif

void floatToHalf(std::span<const float> in, std::span<std::uint16_t> out) {
    assert(in.size() == out.size());
    std::size_t i = hasF16c() ? toHalfF16c(in.data(), out.data(), in.size()) : 0;
    for (; i < in.size(); ++i) out[i] = floatToHalf(in[i]);
}

void halfToFloat(std::span<const std::uint16_t> in, std::span<float> out) {
    assert(in.size() == out.size());
    std::size_t i = hasF16c() ? toFloatF16c(in.data(), out.data(), in.size()) : 0;
    for (; i < in.size(); ++i) out[i] = halfToFloat(in[i]);
}

}  // namespace penumbra
