#pragma once
// The evaluator's inner loops (combine_lanes.cpp). They compute numbers = mean + sum_k weight_k basis_k for all numbers
// of a cluster in one pass over the arrays, and clamp the ambient term. A tile of numbers stays in registers while the
// components go by.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sh/far/far_kernel.h"
#include "sh/kernel.h"

namespace penumbra {

struct CombineInput {
    const void* mean = nullptr;  // [count], float or half
    bool mean_is_half = false;
    const void* basis = nullptr;     // [components, count], in the precision that the function's name says
    const float* weights = nullptr;  // [components]
    std::size_t components = 0, count = 0;
};
using Combine = void (*)(const CombineInput& input, float* out);

// A basis of bytes, which the evaluator lays out anew when it is made. Two components stand beside each other, so
// that one instruction (pmaddwd) multiplies both by their weights and adds them up, with weights of 16 bits and sums
// of 32. Turning bytes into floats instead would take as long as two of those instructions, on processors that turn 8
// in a cycle.
//   bytes: [tile of kPairTile numbers][pair of components][number][2], zeros beyond the last number and component
//   weights: [pair] the lower half belongs to the first component, the upper half to the second, in units of `unit`
constexpr std::size_t kPairTile = 64;
struct PairInput {
    const void* mean = nullptr;
    bool mean_is_half = false;
    const std::int8_t* bytes = nullptr;
    const std::uint32_t* weights = nullptr;
    float unit = 0;
    std::size_t pairs = 0, count = 0;
};

// Appends [components, count] bytes to `out` in this layout. pairBytes() returns how many bytes that takes.
void appendPairs(const std::int8_t* basis, std::size_t components, std::size_t count, std::vector<std::int8_t>& out);
std::size_t pairBytes(std::size_t components, std::size_t count);
// Rounds weights to 16 bits and returns the unit, which is the least that keeps a weight within 16 bits and a sum
// within 32. Rounding changes a sum by at most half a unit times 127 for each component: 1/516 of a step of a byte of
// the largest one.
float packWeights(std::span<const float> weights, std::span<std::uint32_t> pairs);

// Clamps E = sum of weight times number of a vertex to [0, 1], as clampAmbient() (sh/visibility_convention.h) does.
struct AmbientClamp {
    const float* weights = nullptr;  // [stride], zeros in the padding
    std::size_t stride = 0;          // a multiple of 4
    float norm2 = 0;                 // sum of squared weights
};
using ClampAmbients = void (*)(const AmbientClamp& clamp, float* coefficients, std::size_t vertices);
// Combines and then clamps; count is a multiple of the stride.
using CombinePairs = void (*)(const PairInput& input, const AmbientClamp& clamp, float* out);

// One implementation of the loops, for one kind of processor.
struct EvaluatorPath {
    static const EvaluatorPath portable, avx2, avx512;
    const char* name = "";
    CombinePairs i8 = nullptr;
    Combine f16 = nullptr, f32 = nullptr;
    ClampAmbients clamp = nullptr;
    const FarPath* far = nullptr;  // the far parts of composed assets
};

// Returns the paths that this processor can run, slowest first. Tests compare each of them with the first. With
// PENUMBRA_NO_SIMD in the environment there is only the portable one.
inline std::vector<EvaluatorPath> evaluatorPaths() { return pathsOf<EvaluatorPath>(); }

}  // namespace penumbra
