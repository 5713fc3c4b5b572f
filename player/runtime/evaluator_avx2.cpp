// Compiled with -mavx2 -mfma -mf16c, called only where the processor has them. Nothing inline from the standard library
// may be used here: the linker could keep this file's copy for everyone.
#include "player/runtime/combine.h"

#ifdef __AVX2__
#include <immintrin.h>

#include <cstdint>

namespace penumbra {

namespace {

struct Int8 {
    using Stored = std::int8_t;
    static __m256 load(const Stored* p) {
        return _mm256_cvtepi32_ps(_mm256_cvtepi8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p))));
    }
    static __m256 load4(const Stored* p) { return _mm256_cvtepi32_ps(_mm256_cvtepi8_epi32(_mm_loadu_si32(p))); }
};
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

__m256 loadMean(const CombineInput& in, std::size_t at) {
    return in.mean_is_half ? Half::load(static_cast<const std::uint16_t*>(in.mean) + at)
                           : Float::load(static_cast<const float*>(in.mean) + at);
}

// 8 Registers numbers from `at` on. 8 accumulators hide the 4 cycles of a fused multiply-add at 2 a cycle.
template <class Basis, int Registers>
void tile(const CombineInput& in, std::size_t at, float* out) {
    const auto* basis = static_cast<const typename Basis::Stored*>(in.basis) + at;
    __m256 sum[Registers];
    for (int r = 0; r < Registers; ++r) sum[r] = loadMean(in, at + 8 * r);
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

const EvaluatorPath kPath{"avx2", combine<Int8>, combine<Half>, combine<Float>};

}  // namespace

const EvaluatorPath* const kEvaluatorAvx2 = &kPath;

}  // namespace penumbra

#else

namespace penumbra {
const EvaluatorPath* const kEvaluatorAvx2 = nullptr;
}

#endif
