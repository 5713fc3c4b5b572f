#pragma once
// Vectors of 8 numbers, one for each of 8 receivers. Part of far_lanes.h. They go by reference (shade_lanes.h tells
// why).
#ifdef __AVX2__
#include <immintrin.h>
#endif

#include "sh/far/far_kernel.h"
#include "sh/far/far_visibility.h"

namespace penumbra {

namespace {

constexpr int kOrder = 6, kFull = 36, kEven = 21, kRow = 40, kDistance = 36;
constexpr int kMaxEven = 36;                           // numbers of a mirrored function of order kMaxOrder
constexpr int kPaddedEven = 24, kPaddedMostEven = 40;  // whole vectors of them
constexpr float kRootOfSphere = 3.5449077f;            // sqrt(4 pi): the coefficient of the function 1

typedef float Lanes __attribute__((vector_size(4 * kFarLanes)));
typedef std::int32_t Ints __attribute__((vector_size(4 * kFarLanes)));
typedef signed char Bytes __attribute__((vector_size(kFarLanes)));

const Lanes kZeros = {};
inline void choose(const Ints& mask, const Lanes& yes, const Lanes& no, Lanes& out) {
#ifdef __AVX2__
    out = (Lanes)_mm256_blendv_ps((__m256)no, (__m256)yes, (__m256)mask);
#else
    out = (Lanes)((mask & (Ints)yes) | (~mask & (Ints)no));
#endif
}
// The smaller and the larger of the two; b where a is not a number.
inline void least(const Lanes& a, const Lanes& b, Lanes& out) {
#ifdef __AVX2__
    out = (Lanes)_mm256_min_ps((__m256)a, (__m256)b);
#else
    choose(a < b, a, b, out);
#endif
}
inline void most(const Lanes& a, const Lanes& b, Lanes& out) {
#ifdef __AVX2__
    out = (Lanes)_mm256_max_ps((__m256)a, (__m256)b);
#else
    choose(a > b, a, b, out);
#endif
}
inline void clamp(Lanes& x, const Lanes& low, const Lanes& high) {
    most(x, low, x);
    least(x, high, x);
}
inline bool any(const Ints& mask) {
#ifdef __AVX2__
    return !_mm256_testz_si256((__m256i)mask, (__m256i)mask);
#else
    std::int32_t bits = 0;
    for (std::size_t i = 0; i < kFarLanes; ++i) bits |= mask[i];
    return bits != 0;
#endif
}
inline void root(Lanes& x) {
#ifdef __AVX2__
    x = (Lanes)_mm256_sqrt_ps((__m256)x);
#else
    for (std::size_t i = 0; i < kFarLanes; ++i) x[i] = __builtin_sqrtf(x[i]);
#endif
}
inline void loadBytes(const std::int8_t* at, Lanes& out) {
#ifdef __AVX2__
    out = (Lanes)_mm256_cvtepi32_ps(_mm256_cvtepi8_epi32(_mm_loadl_epi64((const __m128i*)at)));
#else
    Bytes bytes;
    __builtin_memcpy(&bytes, at, sizeof bytes);
    out = __builtin_convertvector(bytes, Lanes);
#endif
}
inline void loadFloats(const float* at, Lanes& out) { __builtin_memcpy(&out, at, sizeof out); }

// Turns 8 rows of 8 numbers into columns, or columns into rows.
inline void transpose(const float* rows, std::size_t row, Lanes* out) {
    Lanes a[8], b[8];
    for (std::size_t i = 0; i < 8; ++i) loadFloats(rows + i * row, a[i]);
    for (std::size_t i = 0; i < 8; i += 2) {
        b[i] = __builtin_shufflevector(a[i], a[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
        b[i + 1] = __builtin_shufflevector(a[i], a[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
    }
    for (std::size_t i = 0; i < 8; i += 4)
        for (std::size_t h = 0; h < 2; ++h) {
            a[i + 2 * h] = __builtin_shufflevector(b[i + h], b[i + h + 2], 0, 1, 8, 9, 4, 5, 12, 13);
            a[i + 2 * h + 1] = __builtin_shufflevector(b[i + h], b[i + h + 2], 2, 3, 10, 11, 6, 7, 14, 15);
        }
    for (std::size_t i = 0; i < 4; ++i) {
        out[i] = __builtin_shufflevector(a[i], a[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
        out[i + 4] = __builtin_shufflevector(a[i], a[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
    }
}

// Rows of up to kMaxEven numbers, one for each lane.
struct Rows {
    static constexpr int kColumns = kPaddedMostEven / 8;
    Lanes rows[kFarLanes][kColumns];
};
// Reads `size` numbers of each of `lanes` rows. What lies beyond is undefined.
inline void loadRows(const float* from, std::size_t stride, int size, std::size_t lanes, Lanes* out) {
    Rows r;
    for (std::size_t lane = 0; lane < kFarLanes; ++lane)
        __builtin_memcpy((void*)r.rows[lane], from + (lane < lanes ? lane : 0) * stride,
                         std::size_t(size) * sizeof(float));
    for (int c = 0; 8 * c < size; ++c) transpose((const float*)&r.rows[0][c], 8 * Rows::kColumns, out + 8 * c);
}
inline void storeRows(const Lanes* from, std::size_t stride, int size, std::size_t lanes, float* out) {
    Rows r;
    for (int c = 0; 8 * c < size; ++c) {
        Lanes rows[kFarLanes];
        transpose((const float*)(from + 8 * c), kFarLanes, rows);
        for (std::size_t lane = 0; lane < kFarLanes; ++lane) r.rows[lane][c] = rows[lane];
    }
    for (std::size_t lane = 0; lane < lanes; ++lane)
        __builtin_memcpy(out + lane * stride, (const void*)r.rows[lane], std::size_t(size) * sizeof(float));
}

}  // namespace

}  // namespace penumbra
