// The inner loops of the evaluator, which combine.h declares.
//
// Problem: every frame each of V vertices needs `stride` numbers = mean + sum over K components of score times basis.
// That is the product of a matrix and a vector, whose matrix (the basis) is by far the largest thing that a frame
// reads.
//
// Naive: for each component add its row to the result. The result then goes through the cache K times.
//
// Here: the numbers go by in tiles. The sums of a tile stay in registers while all components pass, so that the basis
// is read once and the result is written once. A basis of bytes is multiplied as whole numbers, two components at a
// time, without turning bytes into floats first. The model that this evaluates is in section 4 of docs/formulas.md.
#include "runtime/evaluate/combine.h"
#include "sh/lanes.h"

namespace penumbra {

namespace {

#ifdef __AVX2__
using Sums = Ints;
constexpr int kTileVectors = 8;  // hide the 4 cycles that a fused multiply-add takes, at 2 a cycle
#else
using Sums = IntQuad;
constexpr int kTileVectors = 4;  // a vector takes two registers
#endif

// Up to eight numbers of a basis or a mean as floats. Nothing beyond them is touched.
inline void load(const float* from, Lanes& out) { loadFloats(from, out); }
inline void load(const std::uint16_t* from, Lanes& out) { loadHalves(from, out); }
template <class Stored>
inline void load(const Stored* from, std::size_t count, Lanes& out) {
    if (count == kLanes) return load(from, out);
    Stored some[kLanes] = {};
    __builtin_memcpy(some, from, count * sizeof(Stored));
    load(some, out);
}
inline void loadMean(const void* mean, bool is_half, std::size_t at, std::size_t count, Lanes& out) {
    if (is_half)
        load(static_cast<const std::uint16_t*>(mean) + at, count, out);
    else
        load(static_cast<const float*>(mean) + at, count, out);
}
inline void store(const Lanes& from, std::size_t count, float* out) {
    if (count == kLanes) return storeFloats(from, out);
    __builtin_memcpy(out, (const void*)&from, count * sizeof(float));
}

// Combines `vectors` times `count` numbers from `at` on.
template <class Basis, int kVectors>
inline void tile(const CombineInput& in, std::size_t at, std::size_t count, float* out) {
    Lanes sum[kVectors], numbers;
    for (int v = 0; v < kVectors; ++v) loadMean(in.mean, in.mean_is_half, at + 8 * v, count, sum[v]);
    for (std::size_t k = 0; k < in.components; ++k) {
        const Basis* basis = static_cast<const Basis*>(in.basis) + k * in.count + at;
        for (int v = 0; v < kVectors; ++v) {
            load(basis + 8 * v, count, numbers);
            sum[v] += in.weights[k] * numbers;
        }
    }
    for (int v = 0; v < kVectors; ++v) store(sum[v], count, out + at + 8 * v);
}

template <class Basis>
void combine(const CombineInput& in, float* out) {
    std::size_t at = 0;
    for (; at + 8 * kTileVectors <= in.count; at += 8 * kTileVectors) tile<Basis, kTileVectors>(in, at, 8, out);
    for (; at + 8 <= in.count; at += 8) tile<Basis, 1>(in, at, 8, out);
    if (at < in.count) tile<Basis, 1>(in, at, in.count - at, out);
}

// Multiplies two bytes of each number by their two weights and adds them to `sum`.
inline void addPairs(const std::int8_t* bytes, std::uint32_t weights, Sums& sum) {
#ifdef __AVX2__
    const __m256i words = _mm256_cvtepi8_epi16(_mm_loadu_si128((const __m128i*)bytes));
    const __m256i both = _mm256_set1_epi32(int(weights));
#ifdef __AVX512VNNI__
    sum = (Sums)_mm256_dpwssd_epi32((__m256i)sum, words, both);
#else
    sum += (Sums)_mm256_madd_epi16(words, both);
#endif
#else
    Words words;
    loadWords(bytes, words);
#ifdef __SSE2__
    sum += (Sums)_mm_madd_epi16((__m128i)words, _mm_set1_epi32(int(weights)));
#else
    const Sums pairs = (Sums)words;
    sum += ((pairs << 16) >> 16) * std::int16_t(weights) + (pairs >> 16) * std::int16_t(weights >> 16);
#endif
#endif
}

// Sums kPairTile numbers, 8 registers at a time. The empty statement keeps these in place: g++ 12 would copy them to
// other registers and back in every round.
inline void sumPairs(const PairInput& in, const std::int8_t* bytes, Sums* out) {
    constexpr std::size_t kNumbers = sizeof(Sums) / 4, kRegisters = kPairTile / kNumbers;
    for (std::size_t first = 0; first < kRegisters; first += 8, bytes += 16 * kNumbers) {
        Sums a = {}, b = {}, c = {}, d = {}, e = {}, f = {}, g = {}, h = {};
        const std::int8_t* from = bytes;
        for (std::size_t p = 0; p < in.pairs; ++p, from += 2 * kPairTile) {
            const std::uint32_t weights = in.weights[p];
            addPairs(from, weights, a);
            addPairs(from + 2 * kNumbers, weights, b);
            addPairs(from + 4 * kNumbers, weights, c);
            addPairs(from + 6 * kNumbers, weights, d);
            addPairs(from + 8 * kNumbers, weights, e);
            addPairs(from + 10 * kNumbers, weights, f);
            addPairs(from + 12 * kNumbers, weights, g);
            addPairs(from + 14 * kNumbers, weights, h);
#ifdef __SSE2__
            asm("" : "+x"(a), "+x"(b), "+x"(c), "+x"(d), "+x"(e), "+x"(f), "+x"(g), "+x"(h));
#endif
        }
        const Sums sums[8] = {a, b, c, d, e, f, g, h};
        for (std::size_t r = 0; r < 8; ++r) out[first + r] = sums[r];
    }
}

// Sets e to the sums of weight times number of `count` vertices, at most eight.
inline void ambients(const AmbientClamp& clamp, const float* numbers, std::size_t count, Lanes& e) {
#ifdef __AVX2__
    // Sums of 8 parts (or of 4, where the stride is no whole vectors) add up while they are transposed.
    Lanes sums[8], pairs[4], fours[2], other;
    for (std::size_t v = 0; v < 8; ++v) {
        const float* of = numbers + (v < count ? v : 0) * clamp.stride;
        if (clamp.stride == 16) {  // D5, A4, B4
            Lanes weights, number;
            loadFloats(clamp.weights, weights);
            loadFloats(of, number);
            sums[v] = weights * number;
            loadFloats(clamp.weights + 8, weights);
            loadFloats(of + 8, number);
            sums[v] += weights * number;
            continue;
        }
        Quad sum = {};
        for (std::size_t i = 0; i < clamp.stride; i += 4) sum += loadQuad(clamp.weights + i) * loadQuad(of + i);
        sums[v] = __builtin_shufflevector(sum, Quad{}, 0, 1, 2, 3, 4, 5, 6, 7);
    }
    for (int i = 0; i < 4; ++i) {
        pick<0, 1>(sums[2 * i], sums[2 * i + 1], pairs[i]);
        pick<2, 3>(sums[2 * i], sums[2 * i + 1], other);
        pairs[i] += other;
    }
    for (int i = 0; i < 2; ++i) {
        pick<0, 2>(pairs[2 * i], pairs[2 * i + 1], fours[i]);
        pick<1, 3>(pairs[2 * i], pairs[2 * i + 1], other);
        fours[i] += other;
    }
    e = __builtin_shufflevector(fours[0], fours[1], 0, 1, 2, 3, 8, 9, 10, 11) +
        __builtin_shufflevector(fours[0], fours[1], 4, 5, 6, 7, 12, 13, 14, 15);
#else
    for (std::size_t v = 0; v < 8; ++v) {
        const float* of = numbers + (v < count ? v : 0) * clamp.stride;
        float sum = 0;
        for (std::size_t i = 0; i < clamp.stride; ++i) sum += clamp.weights[i] * of[i];
        setLane(e, v, sum);
    }
#endif
}

// A vertex whose E lies outside of [0, 1] moves the shortest way back: along the weights (docs/formulas.md, section 4).
// They are few.
void clampAmbients(const AmbientClamp& weights, float* numbers, std::size_t vertices) {
    const std::size_t stride = weights.stride;
    for (std::size_t first = 0; first < vertices; first += 8, numbers += 8 * stride) {
        const std::size_t count = vertices - first < 8 ? vertices - first : 8;
        Lanes e, inside;
        ambients(weights, numbers, count, e);
        inside = e;
        clamp(inside, kZeros, kZeros + 1);
        const Lanes excess = e - inside;
        if (!any((excess < 0) | (excess > 0))) continue;
        const Lanes share = excess / weights.norm2;
        for (std::size_t v = 0; v < count; ++v) {
            if (share[v] == 0) continue;
            for (std::size_t i = 0; i < stride; ++i) numbers[v * stride + i] -= weights.weights[i] * share[v];
        }
    }
}

// Combines tile by tile, and clamps vertices while the first-level cache still has them.
void combinePairs(const PairInput& in, const AmbientClamp& clamp, float* out) {
    constexpr std::size_t kClampAtOnce = 32;
    const std::int8_t* bytes = in.bytes;
    std::size_t clamped = 0;  // vertices
    for (std::size_t at = 0; at < in.count; at += kPairTile, bytes += 2 * kPairTile * in.pairs) {
        if (at >= (clamped + kClampAtOnce) * clamp.stride) {
            clampAmbients(clamp, out + clamped * clamp.stride, kClampAtOnce);
            clamped += kClampAtOnce;
        }
        Ints sums[kPairTile / kLanes];
        sumPairs(in, bytes, (Sums*)sums);
        for (std::size_t i = 0; i < kPairTile && at + i < in.count; i += kLanes) {
            const std::size_t count = in.count - at - i < kLanes ? in.count - at - i : kLanes;
            Lanes mean, sum;
            loadMean(in.mean, in.mean_is_half, at + i, count, mean);
            toFloats(sums[i / kLanes], sum);
            mean += in.unit * sum;
            store(mean, count, out + at + i);
        }
    }
    clampAmbients(clamp, out + clamped * clamp.stride, in.count / clamp.stride - clamped);
}

}  // namespace

const EvaluatorPath EvaluatorPath::PENUMBRA_TARGET{PENUMBRA_TARGET_NAME, combinePairs,  combine<std::uint16_t>,
                                                   combine<float>,       clampAmbients, &FarPath::PENUMBRA_TARGET};

}  // namespace penumbra
