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
constexpr int kTileVectors = 8;  // hide the 4 cycles that a fused multiply-add takes, at 2 a cycle
#else
constexpr int kTileVectors = 4;  // a vector takes two registers
#endif

// Eight or four numbers of a basis or a mean as floats.
inline void load(const float* from, Lanes& out) { loadFloats(from, out); }
inline void load(const std::uint16_t* from, Lanes& out) { loadHalves(from, out); }
template <std::size_t kCount, class Stored>
inline void load(const Stored* from, Lanes& out) {
    if constexpr (kCount == kLanes) return load(from, out);
    Stored some[kLanes] = {};
    __builtin_memcpy(some, from, kCount * sizeof(Stored));
    load(some, out);
}

// Combines kVectors times kCount numbers from `at` on.
template <int kVectors, std::size_t kCount, class Mean, class Basis>
inline void tile(const CombineInput& in, const Mean* mean, const Basis* basis, std::size_t at, float* out) {
    Lanes sum[kVectors], coefficients;
    for (int v = 0; v < kVectors; ++v) load<kCount>(mean + at + 8 * v, sum[v]);
    for (std::size_t k = 0; k < in.components; ++k)
        for (int v = 0; v < kVectors; ++v) {
            load<kCount>(basis + k * in.count + at + 8 * v, coefficients);
            sum[v] += in.weights[k] * coefficients;
        }
    if constexpr (kCount == kLanes)
        for (int v = 0; v < kVectors; ++v) storeFloats(sum[v], out + at + 8 * v);
    else
        __builtin_memcpy(out + at, (const void*)sum, kCount * sizeof(float));
}

template <class Mean, class Basis>
inline void combineWithMean(const CombineInput& in, float* out) {
    const auto* mean = static_cast<const Mean*>(in.mean);
    const auto* basis = static_cast<const Basis*>(in.basis);
    std::size_t at = 0;
    for (; at + 8 * kTileVectors <= in.count; at += 8 * kTileVectors) tile<kTileVectors, 8>(in, mean, basis, at, out);
    for (; at + 8 <= in.count; at += 8) tile<1, 8>(in, mean, basis, at, out);
    if (at < in.count) tile<1, 4>(in, mean, basis, at, out);
}

template <class Basis>
void combine(const CombineInput& in, float* out) {
    (in.mean_is_half ? combineWithMean<std::uint16_t, Basis> : combineWithMean<float, Basis>)(in, out);
}

// Multiplies two bytes of each number by their two weights and adds them to `sum`.
inline void addPairs(const std::int8_t* bytes, std::uint32_t weights, Dots& sum) {
#ifdef __AVX2__
    const DotWords words = (DotWords)_mm256_cvtepi8_epi16(_mm_loadu_si128((const __m128i*)bytes));
#else
    DotWords words;
    loadWords(bytes, words);
#endif
    addDots(words, std::int32_t(weights), sum);
}

// Sums kPairTile numbers, 8 registers at a time. The empty statement keeps these in place: g++ 12 would copy them to
// other registers and back in every round.
inline void sumPairs(const PairInput& in, const std::int8_t* bytes, Dots* out) {
    constexpr std::size_t kCoefficients = sizeof(Dots) / 4, kRegisters = kPairTile / kCoefficients;
    for (std::size_t first = 0; first < kRegisters; first += 8) {
        Dots a = {}, b = {}, c = {}, d = {}, e = {}, f = {}, g = {}, h = {};
        for (std::size_t p = 0; p < in.pairs; ++p) {  // `bytes` may be null where there are none
            const std::int8_t* from = bytes + 2 * kPairTile * p + 2 * kCoefficients * first;
            const std::uint32_t weights = in.weights[p];
            addPairs(from, weights, a);
            addPairs(from + 2 * kCoefficients, weights, b);
            addPairs(from + 4 * kCoefficients, weights, c);
            addPairs(from + 6 * kCoefficients, weights, d);
            addPairs(from + 8 * kCoefficients, weights, e);
            addPairs(from + 10 * kCoefficients, weights, f);
            addPairs(from + 12 * kCoefficients, weights, g);
            addPairs(from + 14 * kCoefficients, weights, h);
#ifdef __SSE2__
            asm("" : "+x"(a), "+x"(b), "+x"(c), "+x"(d), "+x"(e), "+x"(f), "+x"(g), "+x"(h));
#endif
        }
        const Dots sums[8] = {a, b, c, d, e, f, g, h};
        for (std::size_t r = 0; r < 8; ++r) out[first + r] = sums[r];
    }
}

// Sets e to the sums of weight times number of `count` vertices, at most eight.
template <std::size_t kStride>
inline void ambients(const AmbientClamp& clamp, const float* coefficients, std::size_t count, Lanes& e) {
    const std::size_t stride = kStride ? kStride : clamp.stride;
#ifdef __AVX2__
    // Sums of 8 parts (or of 4, where the stride is no whole vectors) add up while they are transposed.
    Lanes sums[8], pairs[4], fours[2], other;
    for (std::size_t v = 0; v < 8; ++v) {
        const float* of = coefficients + (v < count ? v : 0) * stride;
        if constexpr (kStride == 16) {
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
        for (std::size_t i = 0; i < stride; i += 4) sum += loadQuad(clamp.weights + i) * loadQuad(of + i);
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
        const float* of = coefficients + (v < count ? v : 0) * stride;
        float sum = 0;
        for (std::size_t i = 0; i < stride; ++i) sum += clamp.weights[i] * of[i];
        setLane(e, v, sum);
    }
#endif
}

// A vertex whose E lies outside of [0, 1] moves the shortest way back: along the weights (docs/formulas.md, section 4).
// They are few. `kStride` is the stride, or 0 for any.
template <std::size_t kStride>
void clampStrides(const AmbientClamp& weights, float* coefficients, std::size_t vertices) {
    const std::size_t stride = kStride ? kStride : weights.stride;
    for (std::size_t first = 0; first < vertices; first += 8, coefficients += 8 * stride) {
        const std::size_t count = vertices - first < 8 ? vertices - first : 8;
        Lanes e, inside;
        if (count == 8)
            ambients<kStride>(weights, coefficients, 8, e);
        else
            ambients<kStride>(weights, coefficients, count, e);
        inside = e;
        clamp(inside, kZeros, kZeros + 1);
        const Lanes excess = e - inside;
        if (!any((excess < 0) | (excess > 0))) continue;
        const Lanes share = excess / weights.norm2;
        for (std::size_t v = 0; v < count; ++v) {
            if (share[v] == 0) continue;
            for (std::size_t i = 0; i < stride; ++i) coefficients[v * stride + i] -= weights.weights[i] * share[v];
        }
    }
}

void clampAmbients(const AmbientClamp& weights, float* coefficients, std::size_t vertices) {
    (weights.stride == 16 ? clampStrides<16> : clampStrides<0>)(weights, coefficients, vertices);  // 16: D5, A4, B4
}

template <class Mean>
inline void pairTile(const PairInput& in, const std::int8_t* bytes, const Mean* mean, float* out) {
    Ints sums[kPairTile / kLanes];
    sumPairs(in, bytes, (Dots*)sums);
    for (std::size_t i = 0; i < kPairTile / kLanes; ++i) {
        Lanes number, sum;
        load(mean + i * kLanes, number);
        toFloats(sums[i], sum);
        number += in.unit * sum;
        storeFloats(number, out + i * kLanes);
    }
}

// Combines tile by tile, and clamps vertices while the first-level cache still has them.
template <class Mean>
inline void combinePairsWithMean(const PairInput& in, const AmbientClamp& clamp, float* out) {
    constexpr std::size_t kClampAtOnce = 32;
    const auto* mean = static_cast<const Mean*>(in.mean);
    const std::int8_t* bytes = in.bytes;
    std::size_t at = 0, clamped = 0;  // numbers, vertices
    for (; at + kPairTile <= in.count; at += kPairTile, bytes += 2 * kPairTile * in.pairs) {
        if (at >= (clamped + kClampAtOnce) * clamp.stride) {
            clampAmbients(clamp, out + clamped * clamp.stride, kClampAtOnce);
            clamped += kClampAtOnce;
        }
        pairTile(in, bytes, mean + at, out + at);
    }
    // The last tile is not full. Its mean and its result go through buffers, so that nothing beyond the arrays is
    // touched.
    if (at < in.count) {
        Mean last_mean[kPairTile] = {};
        float last[kPairTile];
        __builtin_memcpy(last_mean, mean + at, (in.count - at) * sizeof(Mean));
        pairTile(in, bytes, last_mean, last);
        __builtin_memcpy(out + at, last, (in.count - at) * sizeof(float));
    }
    clampAmbients(clamp, out + clamped * clamp.stride, in.count / clamp.stride - clamped);
}

void combinePairs(const PairInput& in, const AmbientClamp& clamp, float* out) {
    (in.mean_is_half ? combinePairsWithMean<std::uint16_t> : combinePairsWithMean<float>)(in, clamp, out);
}

}  // namespace

const EvaluatorPath EvaluatorPath::PENUMBRA_TARGET{PENUMBRA_TARGET_NAME, combinePairs,  combine<std::uint16_t>,
                                                   combine<float>,       clampAmbients, &FarPath::PENUMBRA_TARGET};

}  // namespace penumbra
