// This file is compiled with AVX-512 VNNI and VL on top of AVX2, FMA and F16C. Its functions are called only where
// the processor has these. vpdpwssd multiplies pairs and adds them in one instruction, and there are twice as many
// registers. They stay 256 bits wide.
#include "runtime/evaluate/combine.h"

#ifdef __AVX512VNNI__
#include "runtime/evaluate/combine_x86.h"

namespace penumbra {
namespace {

const EvaluatorPath kPath{"avx2-vnni", combinePairs, combine<Half>, combine<Float>, clampAmbients};

}  // namespace
const EvaluatorPath* const kEvaluatorVnni = &kPath;
}  // namespace penumbra

#else

namespace penumbra {
const EvaluatorPath* const kEvaluatorVnni = nullptr;
}

#endif
