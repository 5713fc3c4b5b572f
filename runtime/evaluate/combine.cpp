// The portable loops of the evaluator.
//
// Problem: every frame each of V vertices needs `stride` numbers = mean + sum over K components of score times basis.
// That is the product of a matrix and a vector, whose matrix (the basis) is by far the largest thing that a frame
// reads.
//
// Naive: for each component add its row to the result. The result then goes through the cache K times.
//
// Here: the numbers go by in tiles. The sums of a tile stay in registers (or the first-level cache) while all
// components pass, so that the basis is read once and the result is written once. A basis of bytes is multiplied as
// whole numbers, two components at a time, without turning bytes into floats first. combine_x86.h does the same with
// vector instructions. The model that this evaluates is in section 4 of docs/formulas.md.
#include "runtime/evaluate/combine.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "formats/common/fp16.h"
#include "sh/cpu_features.h"

namespace penumbra {

namespace {

constexpr std::size_t kTile = 64;  // numbers; the sums of a tile stay in the first-level cache

void load(const std::uint16_t* from, std::span<float> to) { halfToFloat({from, to.size()}, to); }
void load(const float* from, std::span<float> to) { std::copy_n(from, to.size(), to.begin()); }

void loadMean(const void* mean, bool is_half, std::size_t at, std::span<float> to) {
    if (is_half)
        load(static_cast<const std::uint16_t*>(mean) + at, to);
    else
        load(static_cast<const float*>(mean) + at, to);
}

// Combines a basis of halves or floats tile by tile. CombineInput tells the shapes.
template <class Stored>
void combine(const CombineInput& in, float* out) {
    std::array<float, kTile> buffer;
    for (std::size_t at = 0; at < in.count; at += kTile) {
        const std::size_t n = std::min(kTile, in.count - at);
        const std::span<float> sum(out + at, n), component(buffer.data(), n);
        loadMean(in.mean, in.mean_is_half, at, sum);
        for (std::size_t k = 0; k < in.components; ++k) {
            load(static_cast<const Stored*>(in.basis) + k * in.count + at, component);
            for (std::size_t i = 0; i < n; ++i) sum[i] += in.weights[k] * component[i];
        }
    }
}

// A vertex whose E lies outside of [0, 1] moves the shortest way back: along the weights (docs/formulas.md, section
// 4).
void clampAmbients(const AmbientClamp& clamp, float* numbers, std::size_t vertices) {
    for (float* v = numbers; v < numbers + vertices * clamp.stride; v += clamp.stride) {
        float e = 0;
        for (std::size_t i = 0; i < clamp.stride; ++i) e += clamp.weights[i] * v[i];
        const float excess = e < 0 ? e : e > 1 ? e - 1 : 0;
        if (excess == 0) continue;
        for (std::size_t i = 0; i < clamp.stride; ++i) v[i] -= clamp.weights[i] * (excess / clamp.norm2);
    }
}

// Combines a basis of bytes in the layout of PairInput, in 32-bit whole numbers, and scales the sums by the unit at
// the end.
void combinePairs(const PairInput& in, const AmbientClamp& clamp, float* out) {
    const std::int8_t* bytes = in.bytes;
    for (std::size_t at = 0; at < in.count; at += kPairTile) {
        std::array<std::int32_t, kPairTile> sum{};
        for (std::size_t p = 0; p < in.pairs; ++p, bytes += 2 * kPairTile) {
            const auto first = std::int16_t(in.weights[p]), second = std::int16_t(in.weights[p] >> 16);
            for (std::size_t i = 0; i < kPairTile; ++i) sum[i] += first * bytes[2 * i] + second * bytes[2 * i + 1];
        }
        const std::size_t n = std::min(kPairTile, in.count - at);
        loadMean(in.mean, in.mean_is_half, at, {out + at, n});
        for (std::size_t i = 0; i < n; ++i) out[at + i] += in.unit * float(sum[i]);
    }
    clampAmbients(clamp, out, in.count / clamp.stride);
}

}  // namespace

std::size_t pairBytes(std::size_t components, std::size_t count) {
    return (count + kPairTile - 1) / kPairTile * kPairTile * ((components + 1) / 2 * 2);
}

void appendPairs(const std::int8_t* basis, std::size_t components, std::size_t count, std::vector<std::int8_t>& out) {
    const std::size_t first = out.size(), pairs = (components + 1) / 2;
    out.resize(first + pairBytes(components, count));
    for (std::size_t k = 0; k < components; ++k)
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t tile = i / kPairTile * pairs + k / 2;
            out[first + 2 * (tile * kPairTile + i % kPairTile) + k % 2] = basis[k * count + i];
        }
}

float packWeights(std::span<const float> weights, std::span<std::uint32_t> pairs) {
    assert(pairs.size() == (weights.size() + 1) / 2);
    float most = 0, sum = 0;
    for (float w : weights) {
        most = std::max(most, std::abs(w));
        sum += std::abs(w);
    }
    constexpr float kMaxSum = 16e6f;  // times 128 this is below 2^31
    // The unit is fine enough that the largest weight uses all 16 bits, unless the 32-bit sum could overflow then.
    const float unit = std::max(most / 32767, sum / kMaxSum);
    const auto rounded = [&](std::size_t k) {
        return k < weights.size() && unit > 0 ? std::uint32_t(std::lrint(weights[k] / unit)) & 0xffffu : 0u;
    };
    for (std::size_t p = 0; p < pairs.size(); ++p) pairs[p] = rounded(2 * p) | rounded(2 * p + 1) << 16;
    return unit;
}

std::vector<EvaluatorPath> evaluatorPaths() {
    std::vector<EvaluatorPath> paths = {
        {"portable", combinePairs, combine<std::uint16_t>, combine<float>, clampAmbients, &kFarPortable}};
    const auto add = [&](const EvaluatorPath* path, const FarPath* far) {
        if (!path || !far) return;
        paths.push_back(*path);
        paths.back().far = far;
    };
    if (cpuHasAvx2()) add(kEvaluatorAvx2, kFarAvx2);
    if (cpuHasVnni()) add(kEvaluatorVnni, kFarAvx512);
    return paths;
}

}  // namespace penumbra
