#pragma once
// Vectors of 8 numbers for kernels (sh/kernel.h), one for each of 8 receivers: registers of 32 bytes with AVX2, and two
// of 16 elsewhere, which SSE2, NEON and WebAssembly have. They go by reference, because passing 32 bytes by value has
// no fixed ABI without AVX.
#include <cstddef>
#include <cstdint>
#ifdef __SSE2__
#include <immintrin.h>
#elif defined(__wasm_simd128__)
#include <wasm_simd128.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

#include "sh/vec3.h"

namespace penumbra {

namespace {

constexpr std::size_t kLanes = 8;

// Registers of 16 bytes. A LooseQuad may lie anywhere in an array of floats.
typedef float Quad __attribute__((vector_size(16)));
typedef float LooseQuad __attribute__((vector_size(16), aligned(4), may_alias));
typedef signed char Bytes __attribute__((vector_size(16)));
typedef std::int16_t Words __attribute__((vector_size(16)));
typedef std::int32_t IntQuad __attribute__((vector_size(16)));
typedef long long Longs __attribute__((vector_size(16)));

inline Quad loadQuad(const float* at) { return *(const LooseQuad*)at; }

// Operations on eight floats, with AVX2 and without:
//   choose    mask ? yes : no
//   least     the smaller of two, b where a is not a number; most: the larger
//   toInts    towards 0; roundDown: of numbers that toInts can tell
//   loadQuads four numbers from each of two places
//   loadHalves finite numbers of 16 bits (formats/common/fp16.h)
//   pick      (a_I, a_J, b_I, b_J) of the lower four numbers, and of the upper four
//   addDots   adds a_2i b_0 + a_2i+1 b_1 to number i of `sum`; `pair` has b_0 in its lower 16 bits and b_1 above
#ifdef __AVX2__
typedef float Lanes __attribute__((vector_size(32)));
typedef float LooseLanes __attribute__((vector_size(32), aligned(4), may_alias));
typedef std::int32_t Ints __attribute__((vector_size(32)));

inline void choose(const Ints& mask, const Lanes& yes, const Lanes& no, Lanes& out) { out = mask ? yes : no; }
inline void least(const Lanes& a, const Lanes& b, Lanes& out) { out = (Lanes)_mm256_min_ps((__m256)a, (__m256)b); }
inline void most(const Lanes& a, const Lanes& b, Lanes& out) { out = (Lanes)_mm256_max_ps((__m256)a, (__m256)b); }
inline void root(Lanes& x) { x = (Lanes)_mm256_sqrt_ps((__m256)x); }
inline bool any(const Ints& mask) { return !_mm256_testz_si256((__m256i)mask, (__m256i)mask); }
inline unsigned bitsOf(const Ints& mask) { return unsigned(_mm256_movemask_ps((__m256)mask)); }
inline void toInts(const Lanes& from, Ints& out) { out = __builtin_convertvector(from, Ints); }
inline void toFloats(const Ints& from, Lanes& out) { out = __builtin_convertvector(from, Lanes); }
inline void roundDown(Lanes& x) { x = (Lanes)_mm256_floor_ps((__m256)x); }
inline void loadFloats(const float* at, Lanes& out) { out = *(const LooseLanes*)at; }
inline void storeFloats(const Lanes& from, float* at) { *(LooseLanes*)at = from; }
inline void loadQuads(const float* low, const float* high, Lanes& out) {
    out = __builtin_shufflevector(loadQuad(low), loadQuad(high), 0, 1, 2, 3, 4, 5, 6, 7);
}
inline void loadBytes(const std::int8_t* at, Lanes& out) {
    out = (Lanes)_mm256_cvtepi32_ps(_mm256_cvtepi8_epi32(_mm_loadl_epi64((const __m128i*)at)));
}
inline void loadHalves(const std::uint16_t* at, Lanes& out) {
    out = (Lanes)_mm256_cvtph_ps(_mm_loadu_si128((const __m128i*)at));
}
inline void gather(const float* from, const Ints& at, Lanes& out) {
    out = (Lanes)_mm256_i32gather_ps(from, (__m256i)at, 4);
}
typedef std::int16_t DotWords __attribute__((vector_size(32)));
using Dots = Ints;
inline void addDots(const DotWords& words, std::int32_t pair, Dots& sum) {
#ifdef __AVX512VNNI__
    sum = (Dots)_mm256_dpwssd_epi32((__m256i)sum, (__m256i)words, _mm256_set1_epi32(pair));
#else
    sum += (Dots)_mm256_madd_epi16((__m256i)words, _mm256_set1_epi32(pair));
#endif
}
template <int I, int J>
inline void pick(const Lanes& a, const Lanes& b, Lanes& out) {
    out = __builtin_shufflevector(a, b, I, J, I + 8, J + 8, I + 4, J + 4, I + 12, J + 12);
}
#else
template <class T>
struct Halves {
    typedef T Half __attribute__((vector_size(16)));
    Half low, high;

    Halves() = default;
    Halves(T x) : low{x, x, x, x}, high{x, x, x, x} {}
    Halves(const Half& a, const Half& b) : low(a), high(b) {}
    T operator[](std::size_t lane) const { return lane < 4 ? low[lane] : high[lane - 4]; }
    Halves operator-() const { return {-low, -high}; }
    Halves operator~() const { return {~low, ~high}; }
#define PENUMBRA_COMPARES(op)                                                   \
    friend Halves<std::int32_t> operator op(const Halves& a, const Halves& b) { \
        return {a.low op b.low, a.high op b.high};                              \
    }
#define PENUMBRA_COMPUTES(op)                                                                                  \
    friend Halves operator op(const Halves& a, const Halves& b) { return {a.low op b.low, a.high op b.high}; } \
    Halves& operator op##=(const Halves& b) { return *this = *this op b; }
    PENUMBRA_COMPARES(<)
    PENUMBRA_COMPARES(<=)
    PENUMBRA_COMPARES(>)
    PENUMBRA_COMPARES(>=)
    PENUMBRA_COMPUTES(+)
    PENUMBRA_COMPUTES(-)
    PENUMBRA_COMPUTES(*)
    PENUMBRA_COMPUTES(/)
    PENUMBRA_COMPUTES(&)
    PENUMBRA_COMPUTES(|)
#undef PENUMBRA_COMPARES
#undef PENUMBRA_COMPUTES
};
using Lanes = Halves<float>;
using Ints = Halves<std::int32_t>;

#ifdef __SSE2__  // g++ 12 does not see that these are instructions
inline Quad least(Quad a, Quad b) { return (Quad)_mm_min_ps((__m128)a, (__m128)b); }
inline Quad most(Quad a, Quad b) { return (Quad)_mm_max_ps((__m128)a, (__m128)b); }
inline Quad root(Quad x) { return (Quad)_mm_sqrt_ps((__m128)x); }
#elif defined(__wasm_simd128__)
inline Quad least(Quad a, Quad b) { return (Quad)wasm_f32x4_pmin((v128_t)b, (v128_t)a); }
inline Quad most(Quad a, Quad b) { return (Quad)wasm_f32x4_pmax((v128_t)b, (v128_t)a); }
inline Quad root(Quad x) { return (Quad)wasm_f32x4_sqrt((v128_t)x); }
#else
inline Quad least(Quad a, Quad b) { return a < b ? a : b; }
inline Quad most(Quad a, Quad b) { return a > b ? a : b; }
inline Quad root(Quad x) {
    return Quad{__builtin_sqrtf(x[0]), __builtin_sqrtf(x[1]), __builtin_sqrtf(x[2]), __builtin_sqrtf(x[3])};
}
#endif
inline void choose(const Ints& mask, const Lanes& yes, const Lanes& no, Lanes& out) {
    out = {mask.low ? yes.low : no.low, mask.high ? yes.high : no.high};
}
inline void least(const Lanes& a, const Lanes& b, Lanes& out) { out = {least(a.low, b.low), least(a.high, b.high)}; }
inline void most(const Lanes& a, const Lanes& b, Lanes& out) { out = {most(a.low, b.low), most(a.high, b.high)}; }
inline void root(Lanes& x) { x = {root(x.low), root(x.high)}; }
inline bool any(const Ints& mask) {
#ifdef __wasm_simd128__
    return wasm_v128_any_true((v128_t)(mask.low | mask.high));
#else
    const Longs bits = (Longs)(mask.low | mask.high);
    return (bits[0] | bits[1]) != 0;
#endif
}
inline unsigned bitsOf(const IntQuad& mask) {
#ifdef __SSE2__
    return unsigned(_mm_movemask_ps((__m128)mask));
#elif defined(__wasm_simd128__)
    return wasm_i32x4_bitmask((v128_t)mask);
#else
    return (mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8);
#endif
}
inline unsigned bitsOf(const Ints& mask) { return bitsOf(mask.low) | bitsOf(mask.high) << 4; }
inline void toInts(const Lanes& from, Ints& out) {
    out = {__builtin_convertvector(from.low, IntQuad), __builtin_convertvector(from.high, IntQuad)};
}
inline void toFloats(const Ints& from, Lanes& out) {
    out = {__builtin_convertvector(from.low, Quad), __builtin_convertvector(from.high, Quad)};
}
inline void roundDown(Lanes& x) {
    Ints whole;
    Lanes rounded;
    toInts(x, whole);
    toFloats(whole, rounded);
    choose(rounded > x, rounded - 1, rounded, x);
}
inline void loadQuads(const float* low, const float* high, Lanes& out) { out = {loadQuad(low), loadQuad(high)}; }
inline void loadFloats(const float* at, Lanes& out) { loadQuads(at, at + 4, out); }
inline void storeFloats(const Lanes& from, float* at) {
    *(LooseQuad*)at = from.low;
    *(LooseQuad*)(at + 4) = from.high;
}
// Eight bytes as numbers of 16 bits, and eight of those as numbers of 32.
inline void loadWords(const std::int8_t* at, Words& out) {
    long long eight;
    __builtin_memcpy(&eight, at, sizeof eight);
    const Bytes bytes = (Bytes)Longs{eight, 0};
    out = (Words)__builtin_shufflevector(bytes, bytes, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7) >> 8;
}
inline void widen(const Words& words, Ints& out) {
    out = {(IntQuad)__builtin_shufflevector(words, words, 0, 0, 1, 1, 2, 2, 3, 3) >> 16,
           (IntQuad)__builtin_shufflevector(words, words, 4, 4, 5, 5, 6, 6, 7, 7) >> 16};
}
inline void loadBytes(const std::int8_t* at, Lanes& out) {
    Words words;
    Ints ints;
    loadWords(at, words);
    widen(words, ints);
    toFloats(ints, out);
}
inline Quad fromHalves(IntQuad half) {
    const IntQuad size = half & 0x7fff, normal = (size << 13) + (112 << 23);
    const IntQuad tiny = (IntQuad)(__builtin_convertvector(size, Quad) * 0x1p-24f);
    return (Quad)((size < 0x400 ? tiny : normal) | (half & INT32_MIN));
}
inline void loadHalves(const std::uint16_t* at, Lanes& out) {
    Words words;
    Ints ints;
    __builtin_memcpy(&words, at, sizeof words);
    widen(words, ints);
    out = {fromHalves(ints.low), fromHalves(ints.high)};
}
inline void gather(const float* from, const Ints& at, Lanes& out) {
    out = {Quad{from[at[0]], from[at[1]], from[at[2]], from[at[3]]},
           Quad{from[at[4]], from[at[5]], from[at[6]], from[at[7]]}};
}
using DotWords = Words;
using Dots = IntQuad;
inline void addDots(const DotWords& words, std::int32_t pair, Dots& sum) {
#ifdef __SSE2__
    sum += (Dots)_mm_madd_epi16((__m128i)words, _mm_set1_epi32(pair));
#elif defined(__wasm_simd128__)
    sum += (Dots)wasm_i32x4_dot_i16x8((v128_t)words, wasm_i32x4_splat(pair));
#elif defined(__aarch64__)
    const int16x8_t a = (int16x8_t)words, b = (int16x8_t)vdupq_n_s32(pair);
    sum += (Dots)vpaddq_s32(vmull_s16(vget_low_s16(a), vget_low_s16(b)), vmull_high_s16(a, b));
#else
    const Dots pairs = (Dots)words;
    sum += ((pairs << 16) >> 16) * std::int16_t(pair) + (pairs >> 16) * (pair >> 16);
#endif
}
template <int I, int J>
inline void pick(const Lanes& a, const Lanes& b, Lanes& out) {
    out = {__builtin_shufflevector(a.low, b.low, I, J, I + 4, J + 4),
           __builtin_shufflevector(a.high, b.high, I, J, I + 4, J + 4)};
}
#endif

const Lanes kZeros = {};
inline void clamp(Lanes& x, const Lanes& low, const Lanes& high) {
    most(x, low, x);
    least(x, high, x);
}
inline void setLane(Lanes& x, std::size_t lane, float value) { ((float*)&x)[lane] = value; }
inline void setLane(Lanes* xyz, std::size_t lane, const Vec3& value) {
    setLane(xyz[0], lane, value.x);
    setLane(xyz[1], lane, value.y);
    setLane(xyz[2], lane, value.z);
}
// Turns 8 rows of 8 numbers into columns, or columns into rows.
inline void transpose(const float* rows, std::size_t row, Lanes* out) {
    for (std::size_t c = 0; c < 8; c += 4) {
        Lanes a[4], b[4];
        for (std::size_t i = 0; i < 4; ++i) loadQuads(rows + i * row + c, rows + (i + 4) * row + c, a[i]);
        for (std::size_t i = 0; i < 4; i += 2) {
            pick<0, 1>(a[i], a[i + 1], b[i]);
            pick<2, 3>(a[i], a[i + 1], b[i + 1]);
        }
        for (std::size_t i = 0; i < 2; ++i) {
            pick<0, 2>(b[i], b[i + 2], out[c + 2 * i]);
            pick<1, 3>(b[i], b[i + 2], out[c + 2 * i + 1]);
        }
    }
}

// Rows of up to 40 numbers, one for each lane.
struct Rows {
    static constexpr int kColumns = 5;
    Lanes rows[kLanes][kColumns];
};
// Reads `size` numbers of each of `lanes` rows. What lies beyond is undefined.
inline void loadRows(const float* from, std::size_t stride, int size, std::size_t lanes, Lanes* out) {
    Rows r;
    for (std::size_t lane = 0; lane < kLanes; ++lane)
        __builtin_memcpy((void*)r.rows[lane], from + (lane < lanes ? lane : 0) * stride,
                         std::size_t(size) * sizeof(float));
    for (int c = 0; 8 * c < size; ++c) transpose((const float*)&r.rows[0][c], 8 * Rows::kColumns, out + 8 * c);
}
inline void storeRows(const Lanes* from, std::size_t stride, int size, std::size_t lanes, float* out) {
    Rows r;
    for (int c = 0; 8 * c < size; ++c) {
        Lanes rows[kLanes];
        transpose((const float*)(from + 8 * c), kLanes, rows);
        for (std::size_t lane = 0; lane < kLanes; ++lane) r.rows[lane][c] = rows[lane];
    }
    for (std::size_t lane = 0; lane < lanes; ++lane)
        __builtin_memcpy(out + lane * stride, (const void*)r.rows[lane], std::size_t(size) * sizeof(float));
}

}  // namespace

}  // namespace penumbra
