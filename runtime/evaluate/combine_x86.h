// The source of both x86 paths. evaluator_avx2.cpp and evaluator_vnni.cpp include it and differ in the processor that
// they are compiled for. Everything has internal linkage, and nothing inline from the standard library is used: the
// linker could otherwise keep a copy made for one processor for everyone.
#include <immintrin.h>

#include <cstdint>

#include "runtime/evaluate/combine.h"

namespace penumbra {

namespace {

// Loads of a basis or mean: eight values, or four with zeros above, as floats.
struct Half {
    using Stored = std::uint16_t;
    static __m256 load(const Stored* p) {
        return _mm256_cvtph_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));
    }
    static __m256 load4(const Stored* p) {
        return _mm256_cvtph_ps(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p)));
    }
};
struct Float {
    using Stored = float;
    static __m256 load(const Stored* p) { return _mm256_loadu_ps(p); }
    static __m256 load4(const Stored* p) { return _mm256_castps128_ps256(_mm_loadu_ps(p)); }
};

__m256 loadMean(const void* mean, bool is_half, std::size_t at) {
    return is_half ? Half::load(static_cast<const std::uint16_t*>(mean) + at)
                   : Float::load(static_cast<const float*>(mean) + at);
}

// Combines 8 Registers numbers from `at` on. 8 accumulators hide the 4 cycles that a fused multiply-add takes, at 2 a
// cycle.
template <class Basis, int Registers>
void tile(const CombineInput& in, std::size_t at, float* out) {
    // A cluster without components has no basis.
    const auto* basis = in.components > 0 ? static_cast<const typename Basis::Stored*>(in.basis) + at : nullptr;
    __m256 sum[Registers];
    for (int r = 0; r < Registers; ++r) sum[r] = loadMean(in.mean, in.mean_is_half, at + 8 * r);
    for (std::size_t k = 0; k < in.components; ++k, basis += in.count) {
        const __m256 weight = _mm256_broadcast_ss(in.weights + k);
        for (int r = 0; r < Registers; ++r) sum[r] = _mm256_fmadd_ps(weight, Basis::load(basis + 8 * r), sum[r]);
    }
    for (int r = 0; r < Registers; ++r) _mm256_storeu_ps(out + at + 8 * r, sum[r]);
}

// Combines the last 4 numbers of an odd multiple of 4. It reads and writes nothing beyond them.
template <class Basis>
void lastFour(const CombineInput& in, std::size_t at, float* out) {
    // A cluster without components has no basis.
    const auto* basis = in.components > 0 ? static_cast<const typename Basis::Stored*>(in.basis) + at : nullptr;
    __m256 sum = in.mean_is_half ? Half::load4(static_cast<const std::uint16_t*>(in.mean) + at)
                                 : Float::load4(static_cast<const float*>(in.mean) + at);
    for (std::size_t k = 0; k < in.components; ++k, basis += in.count)
        sum = _mm256_fmadd_ps(_mm256_broadcast_ss(in.weights + k), Basis::load4(basis), sum);
    _mm_storeu_ps(out + at, _mm256_castps256_ps128(sum));
}

template <class Basis>
void combine(const CombineInput& in, float* out) {
    std::size_t at = 0;
    for (; at + 64 <= in.count; at += 64) tile<Basis, 8>(in, at, out);
    for (; at + 8 <= in.count; at += 8) tile<Basis, 1>(in, at, out);
    if (at < in.count) lastFour<Basis>(in, at, out);
}

// Multiplies two bytes of each of 8 numbers by their two weights and adds them to `sum`.
inline __m256i addPairs(__m256i sum, const std::int8_t* bytes, __m256i weights) {
    const __m256i words = _mm256_cvtepi8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes)));
#ifdef __AVX512VNNI__
    return _mm256_dpwssd_epi32(sum, words, weights);
#else
    return _mm256_add_epi32(sum, _mm256_madd_epi16(words, weights));
#endif
}

// Stores mean + unit * sum for 8 numbers.
template <class Mean>
inline void storeEight(const void* mean, __m256i sum, __m256 unit, std::size_t at, float* out) {
    const __m256 start = Mean::load(static_cast<const typename Mean::Stored*>(mean) + at);
    _mm256_storeu_ps(out + at, _mm256_fmadd_ps(unit, _mm256_cvtepi32_ps(sum), start));
}

// Combines kPairTile numbers. The sums have names of their own, and the empty statement keeps them in place: g++ 12
// would copy them to other registers and back in every round.
template <class Mean>
inline void pairTile(const PairInput& in, const std::int8_t* bytes, const void* mean, float* out) {
    static_assert(kPairTile == 64);
    __m256i a = _mm256_setzero_si256(), b = a, c = a, d = a, e = a, f = a, g = a, h = a;
    for (std::size_t p = 0; p < in.pairs; ++p) {
        const __m256i weights = _mm256_set1_epi32(int(in.weights[p]));
        a = addPairs(a, bytes, weights);
        b = addPairs(b, bytes + 16, weights);
        c = addPairs(c, bytes + 32, weights);
        d = addPairs(d, bytes + 48, weights);
        e = addPairs(e, bytes + 64, weights);
        f = addPairs(f, bytes + 80, weights);
        g = addPairs(g, bytes + 96, weights);
        h = addPairs(h, bytes + 112, weights);
        bytes += 2 * kPairTile;
        asm("" : "+x"(a), "+x"(b), "+x"(c), "+x"(d), "+x"(e), "+x"(f), "+x"(g), "+x"(h));
    }
    const __m256 unit = _mm256_set1_ps(in.unit);
    storeEight<Mean>(mean, a, unit, 0, out);
    storeEight<Mean>(mean, b, unit, 8, out);
    storeEight<Mean>(mean, c, unit, 16, out);
    storeEight<Mean>(mean, d, unit, 24, out);
    storeEight<Mean>(mean, e, unit, 32, out);
    storeEight<Mean>(mean, f, unit, 40, out);
    storeEight<Mean>(mean, g, unit, 48, out);
    storeEight<Mean>(mean, h, unit, 56, out);
}

void clampAmbients(const AmbientClamp& clamp, float* numbers, std::size_t vertices);

// Combines tile by tile, and clamps vertices while the first-level cache still has them.
template <class Mean>
void combineWithMean(const PairInput& in, const AmbientClamp& clamp, float* out) {
    constexpr std::size_t kClampAtOnce = 32;
    const auto* mean = static_cast<const typename Mean::Stored*>(in.mean);
    const std::int8_t* bytes = in.bytes;
    std::size_t at = 0, clamped = 0;  // numbers, vertices
    for (; at + kPairTile <= in.count; at += kPairTile, bytes += 2 * kPairTile * in.pairs) {
        if (at >= (clamped + kClampAtOnce) * clamp.stride) {
            clampAmbients(clamp, out + clamped * clamp.stride, kClampAtOnce);
            clamped += kClampAtOnce;
        }
        pairTile<Mean>(in, bytes, mean + at, out + at);
    }
    // The last tile is not full. Its mean and its result go through buffers, so that nothing beyond the arrays is
    // touched.
    if (at < in.count) {
        const std::size_t left = in.count - at;
        typename Mean::Stored last_mean[kPairTile] = {};
        float last[kPairTile];
        __builtin_memcpy(last_mean, mean + at, left * sizeof(last_mean[0]));
        pairTile<Mean>(in, bytes, last_mean, last);
        __builtin_memcpy(out + at, last, left * sizeof(float));
    }
    clampAmbients(clamp, out + clamped * clamp.stride, in.count / clamp.stride - clamped);
}

void combinePairs(const PairInput& in, const AmbientClamp& clamp, float* out) {
    (in.mean_is_half ? combineWithMean<Half> : combineWithMean<Float>)(in, clamp, out);
}

// Returns partial sums of E of one vertex. Octs is the stride in eights, or 0 for any multiple of 4.
template <std::size_t Octs>
inline __m256 weighted(const AmbientClamp& clamp, const float* v) {
    if constexpr (Octs > 0) {
        __m256 sum = _mm256_mul_ps(_mm256_loadu_ps(clamp.weights), _mm256_loadu_ps(v));
        for (std::size_t i = 8; i < 8 * Octs; i += 8)
            sum = _mm256_fmadd_ps(_mm256_loadu_ps(clamp.weights + i), _mm256_loadu_ps(v + i), sum);
        return sum;
    }
    __m128 sum = _mm_setzero_ps();
    for (std::size_t i = 0; i < clamp.stride; i += 4)
        sum = _mm_fmadd_ps(_mm_loadu_ps(clamp.weights + i), _mm_loadu_ps(v + i), sum);
    return _mm256_zextps128_ps256(sum);
}

// Returns the sums of the 8 numbers of each of 8 vectors. Adding transposes them on the way.
inline __m256 addAcross(const __m256* s) {
    __m256 pairs[4], fours[2];
    for (int i = 0; i < 4; ++i)
        pairs[i] =
            _mm256_add_ps(_mm256_unpacklo_ps(s[2 * i], s[2 * i + 1]), _mm256_unpackhi_ps(s[2 * i], s[2 * i + 1]));
    for (int i = 0; i < 2; ++i) {
        const __m256d a = _mm256_castps_pd(pairs[2 * i]), b = _mm256_castps_pd(pairs[2 * i + 1]);
        fours[i] =
            _mm256_add_ps(_mm256_castpd_ps(_mm256_unpacklo_pd(a, b)), _mm256_castpd_ps(_mm256_unpackhi_pd(a, b)));
    }
    return _mm256_add_ps(_mm256_permute2f128_ps(fours[0], fours[1], 0x20),
                         _mm256_permute2f128_ps(fours[0], fours[1], 0x31));
}

// Clamps vertices [0, count), at most eight. The few that are out of range are corrected one by one.
template <std::size_t Octs>
inline void clampEight(const AmbientClamp& clamp, float* numbers, std::size_t count) {
    const std::size_t stride = Octs ? 8 * Octs : clamp.stride;
    const __m256 zero = _mm256_setzero_ps(), one = _mm256_set1_ps(1);
    __m256 sums[8];
    for (std::size_t i = 0; i < 8; ++i) sums[i] = weighted<Octs>(clamp, numbers + (i < count ? i : 0) * stride);
    const __m256 e = addAcross(sums);
    const __m256 excess = _mm256_sub_ps(e, _mm256_min_ps(_mm256_max_ps(e, zero), one));
    if (_mm256_movemask_ps(_mm256_cmp_ps(excess, zero, _CMP_NEQ_UQ)) == 0) return;
    alignas(32) float share[8];
    _mm256_store_ps(share, _mm256_div_ps(excess, _mm256_set1_ps(clamp.norm2)));
    for (std::size_t i = 0; i < count; ++i) {
        if (share[i] == 0) continue;
        float* v = numbers + i * stride;
        for (std::size_t n = 0; n < stride; ++n) v[n] -= clamp.weights[n] * share[i];
    }
}

template <std::size_t Octs>
void clampEights(const AmbientClamp& clamp, float* numbers, std::size_t vertices) {
    std::size_t v = 0;
    for (; v + 8 <= vertices; v += 8) clampEight<Octs>(clamp, numbers + v * clamp.stride, 8);
    if (v < vertices) clampEight<Octs>(clamp, numbers + v * clamp.stride, vertices - v);
}

void clampAmbients(const AmbientClamp& clamp, float* numbers, std::size_t vertices) {
    if (clamp.stride == 16)  // D5, A4, B4
        clampEights<2>(clamp, numbers, vertices);
    else
        clampEights<0>(clamp, numbers, vertices);
}

}  // namespace

}  // namespace penumbra
