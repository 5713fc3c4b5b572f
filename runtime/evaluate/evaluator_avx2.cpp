// This file is compiled with -mavx2 -mfma -mf16c. Its functions are called only where the processor has these.
#include "runtime/evaluate/combine.h"

#ifdef __AVX2__
#include "runtime/evaluate/combine_x86.h"

namespace penumbra {
namespace {

const EvaluatorPath kPath{"avx2", combinePairs, combine<Half>, combine<Float>, clampAmbients};

}  // namespace
const EvaluatorPath* const kEvaluatorAvx2 = &kPath;
}  // namespace penumbra

#else

namespace penumbra {
const EvaluatorPath* const kEvaluatorAvx2 = nullptr;
}

#endif
