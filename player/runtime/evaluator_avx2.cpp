// Compiled with -mavx2 -mfma -mf16c, called only where the processor has them. Nothing inline from the standard library
// may be used here: the linker could keep this file's copy for everyone.
#include "player/runtime/combine.h"

#ifdef __AVX2__
#include <immintrin.h>

#include <cstdint>

namespace penumbra {

namespace {

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

// 8 Registers numbers from `at` on. 8 accumulators hide the 4 cycles of a fused multiply-add at 2 a cycle.
template <class Basis, int Registers>
void tile(const CombineInput& in, std::size_t at, float* out) {
    const auto* basis = static_cast<const typename Basis::Stored*>(in.basis) + at;
    __m256 sum[Registers];
    for (int r = 0; r < Registers; ++r) sum[r] = loadMean(in.mean, in.mean_is_half, at + 8 * r);
    for (std::size_t k = 0; k < in.components; ++k, basis += in.count) {
        const __m256 weight = _mm256_broadcast_ss(in.weights + k);
        for (int r = 0; r < Registers; ++r) sum[r] = _mm256_fmadd_ps(weight, Basis::load(basis + 8 * r), sum[r]);
    }
    for (int r = 0; r < Registers; ++r) _mm256_storeu_ps(out + at + 8 * r, sum[r]);
}

// The last 4 numbers of an odd multiple of 4: reads and writes nothing beyond them.
template <class Basis>
void lastFour(const CombineInput& in, std::size_t at, float* out) {
    const auto* basis = static_cast<const typename Basis::Stored*>(in.basis) + at;
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

// Of 8 numbers: two bytes each times their two weights, added to what is there.
__m256i addPairs(__m256i sum, const std::int8_t* bytes, __m256i weights) {
    const __m256i words = _mm256_cvtepi8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes)));
    return _mm256_add_epi32(sum, _mm256_madd_epi16(words, weights));
}

struct Sums {
    __m256i a, b, c, d;  // of kPairTile numbers
};
Sums sumPairs(const PairInput& in, const std::int8_t* bytes) {
    Sums s{_mm256_setzero_si256(), _mm256_setzero_si256(), _mm256_setzero_si256(), _mm256_setzero_si256()};
    for (std::size_t p = 0; p < in.pairs; ++p, bytes += 2 * kPairTile) {
        const __m256i weights = _mm256_set1_epi32(int(in.weights[p]));
        s.a = addPairs(s.a, bytes, weights);
        s.b = addPairs(s.b, bytes + 16, weights);
        s.c = addPairs(s.c, bytes + 32, weights);
        s.d = addPairs(s.d, bytes + 48, weights);
    }
    return s;
}

void combinePairs(const PairInput& in, float* out) {
    static_assert(kPairTile == 32);
    const __m256 unit = _mm256_set1_ps(in.unit);
    const std::int8_t* bytes = in.bytes;
    const auto results = [&](const void* mean, std::size_t at, const Sums& s, float* to) {
        const __m256i sums[4] = {s.a, s.b, s.c, s.d};
        for (int r = 0; r < 4; ++r)
            _mm256_storeu_ps(to + 8 * r, _mm256_fmadd_ps(unit, _mm256_cvtepi32_ps(sums[r]),
                                                         loadMean(mean, in.mean_is_half, at + 8 * std::size_t(r))));
    };
    std::size_t at = 0;
    for (; at + kPairTile <= in.count; at += kPairTile, bytes += 2 * kPairTile * in.pairs)
        results(in.mean, at, sumPairs(in, bytes), out + at);
    if (at == in.count) return;
    const std::size_t left = in.count - at, number_bytes = in.mean_is_half ? 2 : 4;
    alignas(32) float mean[kPairTile] = {}, last[kPairTile];
    __builtin_memcpy(mean, static_cast<const char*>(in.mean) + at * number_bytes, left * number_bytes);
    results(mean, 0, sumPairs(in, bytes), last);
    __builtin_memcpy(out + at, last, left * sizeof(float));
}

// Partial sums of E of one vertex. Octs: the stride in eights, or 0 for any multiple of 4.
template <std::size_t Octs>
__m256 weighted(const AmbientClamp& clamp, const float* v) {
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

// Sums of the 8 numbers of each of 8, transposed on the way.
__m256 addAcross(const __m256* s) {
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

// Eight vertices at a time; those few that are out of range one by one.
template <std::size_t Octs>
void clampEights(const AmbientClamp& clamp, float* numbers, std::size_t vertices) {
    const std::size_t stride = Octs ? 8 * Octs : clamp.stride;
    const __m256 zero = _mm256_setzero_ps(), one = _mm256_set1_ps(1);
    for (std::size_t first = 0; first < vertices; first += 8) {
        __m256 sums[8];
        for (std::size_t i = 0; i < 8; ++i)
            sums[i] = weighted<Octs>(clamp, numbers + (first + i < vertices ? first + i : first) * stride);
        const __m256 e = addAcross(sums);
        const __m256 excess = _mm256_sub_ps(e, _mm256_min_ps(_mm256_max_ps(e, zero), one));
        if (_mm256_movemask_ps(_mm256_cmp_ps(excess, zero, _CMP_NEQ_UQ)) == 0) continue;
        alignas(32) float share[8];
        _mm256_store_ps(share, _mm256_div_ps(excess, _mm256_set1_ps(clamp.norm2)));
        for (std::size_t i = 0; i < 8 && first + i < vertices; ++i) {
            if (share[i] == 0) continue;
            float* v = numbers + (first + i) * stride;
            for (std::size_t n = 0; n < stride; ++n) v[n] -= clamp.weights[n] * share[i];
        }
    }
}

void clampAmbients(const AmbientClamp& clamp, float* numbers, std::size_t vertices) {
    if (clamp.stride == 16)  // D5, A4, B4
        clampEights<2>(clamp, numbers, vertices);
    else
        clampEights<0>(clamp, numbers, vertices);
}

const EvaluatorPath kPath{"avx2", combinePairs, combine<Half>, combine<Float>, clampAmbients};

}  // namespace

const EvaluatorPath* const kEvaluatorAvx2 = &kPath;

}  // namespace penumbra

#else

namespace penumbra {
const EvaluatorPath* const kEvaluatorAvx2 = nullptr;
}

#endif
