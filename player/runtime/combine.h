#pragma once
// The evaluator's inner loop: numbers = mean + sum_k weight_k basis_k over all numbers of a cluster, in one pass over
// the stored arrays. A tile of numbers stays in registers while the components go by.
#include <cstddef>
#include <vector>

namespace penumbra {

struct CombineInput {
    const void* mean = nullptr;  // [count], float or half
    bool mean_is_half = false;
    const void* basis = nullptr;     // [components, count], precision as the function's name says
    const float* weights = nullptr;  // [components]; for I8 the component's scale is in it
    std::size_t components = 0, count = 0;
};
using Combine = void (*)(const CombineInput& input, float* out);

struct EvaluatorPath {
    const char* name = "";
    Combine i8 = nullptr, f16 = nullptr, f32 = nullptr;
};

// The paths that this processor can run, slowest first; tests hold each to the first. With PENUMBRA_NO_SIMD in the
// environment there is only the portable one.
std::vector<EvaluatorPath> evaluatorPaths();

// evaluator_avx2.cpp: AVX2, FMA and F16C. Null where the compiler has no such target.
extern const EvaluatorPath* const kEvaluatorAvx2;

}  // namespace penumbra
