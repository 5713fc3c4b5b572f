#include "sh/cpu_features.h"

#include <cstdlib>

namespace penumbra {

bool cpuHasAvx2() {
#ifdef __x86_64__
    // F16C came before AVX2, so that every processor with AVX2 has it. clang 14 cannot ask for it.
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && !std::getenv("PENUMBRA_NO_SIMD");
#else
    return false;
#endif
}

bool cpuHasVnni() {
#ifdef __x86_64__
    return cpuHasAvx2() && __builtin_cpu_supports("avx512vnni") && __builtin_cpu_supports("avx512vl");
#else
    return false;
#endif
}

}  // namespace penumbra
