#pragma once
// The evaluator's inner loops: numbers = mean + sum_k weight_k basis_k over all numbers of a cluster, in one pass over
// the arrays, and the clamp of the ambient term. A tile of numbers stays in registers while the components go by.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace penumbra {

struct CombineInput {
    const void* mean = nullptr;  // [count], float or half
    bool mean_is_half = false;
    const void* basis = nullptr;     // [components, count], precision as the function's name says
    const float* weights = nullptr;  // [components]
    std::size_t components = 0, count = 0;
};
using Combine = void (*)(const CombineInput& input, float* out);

// A basis of bytes, made ready when the asset is opened: two components beside each other, so that one instruction
// (pmaddwd) multiplies both by their weights and adds, with weights of 16 bits and sums of 32. Turning bytes into
// floats takes as long as two of those, on processors that can turn 8 a cycle.
//   bytes: [tile of kPairTile numbers][pair of components][number][2], zeros beyond the last number and component
//   weights: [pair] the lower half of the first component, the upper of the second, in units of `unit`
constexpr std::size_t kPairTile = 64;
struct PairInput {
    const void* mean = nullptr;
    bool mean_is_half = false;
    const std::int8_t* bytes = nullptr;
    const std::uint32_t* weights = nullptr;
    float unit = 0;
    std::size_t pairs = 0, count = 0;
};

// The layout above of [components, count] bytes, appended to `out`.
void appendPairs(const std::int8_t* basis, std::size_t components, std::size_t count, std::vector<std::int8_t>& out);
std::size_t pairBytes(std::size_t components, std::size_t count);
// Rounds weights to 16 bits; returns the unit: the least that keeps a weight within 16 bits and a sum within 32. What
// rounding changes is at most half a unit times 127 a component, 1/516 of a step of a byte of the largest one.
float packWeights(std::span<const float> weights, std::span<std::uint32_t> pairs);

// E = sum of weight times number of a vertex, brought into [0, 1] as clampAmbient() (sh/visibility_convention.h) does.
struct AmbientClamp {
    const float* weights = nullptr;  // [stride], zeros in the padding
    std::size_t stride = 0;          // a multiple of 4
    float norm2 = 0;                 // sum of squared weights
};
using ClampAmbients = void (*)(const AmbientClamp& clamp, float* numbers, std::size_t vertices);
// Clamps what it has combined; count is a multiple of the stride.
using CombinePairs = void (*)(const PairInput& input, const AmbientClamp& clamp, float* out);

struct EvaluatorPath {
    const char* name = "";
    CombinePairs i8 = nullptr;
    Combine f16 = nullptr, f32 = nullptr;
    ClampAmbients clamp = nullptr;
};

// The paths that this processor can run, slowest first; tests hold each to the first. With PENUMBRA_NO_SIMD in the
// environment there is only the portable one.
std::vector<EvaluatorPath> evaluatorPaths();

// evaluator_avx2.cpp: AVX2, FMA and F16C; evaluator_vnni.cpp: with AVX-512 VNNI and VL. Null where the compiler has no
// such target.
extern const EvaluatorPath* const kEvaluatorAvx2;
extern const EvaluatorPath* const kEvaluatorVnni;

}  // namespace penumbra
