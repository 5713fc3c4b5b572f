#include "sh/kernel.h"

#include <cstdlib>

namespace penumbra {

#ifdef PENUMBRA_X86_PATHS

bool cpuHasAvx2() {
    // F16C came before AVX2, so that every processor with AVX2 has it. clang 14 cannot ask for it.
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && !std::getenv("PENUMBRA_NO_SIMD");
}

bool cpuHasAvx512() {
    return cpuHasAvx2() && __builtin_cpu_supports("avx512vnni") && __builtin_cpu_supports("avx512vl");
}

#endif

}  // namespace penumbra
