#pragma once
// What this processor can run. Fast paths ask here; PENUMBRA_NO_SIMD in the environment says no to all of them, so that
// tests can take the portable ones.

namespace penumbra {

bool cpuHasAvx2();  // with FMA and F16C
bool cpuHasVnni();  // and with AVX-512 VNNI and VL

}  // namespace penumbra
