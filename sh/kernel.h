#pragma once
// A kernel is a source that CMake compiles once for each kind of processor (penumbra_kernel() in CMakeLists.txt), with
// the name of that as PENUMBRA_TARGET: `portable` for all, `avx2` with FMA and F16C, `avx512` with VNNI and VL besides.
//
// The header of a kernel has a struct of pointers to functions, with
//     static const Path portable, avx2;
// and its source ends with
//     const Path Path::PENUMBRA_TARGET = {...};
// All else in the source has internal linkage and calls nothing inline from the standard library, because the linker
// could keep a copy made for one processor for everyone.
#include <vector>

#define PENUMBRA_TEXT_OF(name) #name
#define PENUMBRA_NAME_OF(target) PENUMBRA_TEXT_OF(target)
#define PENUMBRA_TARGET_NAME PENUMBRA_NAME_OF(PENUMBRA_TARGET)

// Whether this build has more than the portable paths.
#if defined(__x86_64__) && !defined(PENUMBRA_PORTABLE_ALONE)
#define PENUMBRA_X86_PATHS
#endif

namespace penumbra {

#ifdef PENUMBRA_X86_PATHS
// PENUMBRA_NO_SIMD in the environment says no to all, so that tests can take the portable paths.
bool cpuHasAvx2();
bool cpuHasAvx512();
#endif

// Returns the fastest path that this processor can run.
template <class Path>
const Path& fastestPath() {
#ifdef PENUMBRA_X86_PATHS
    if constexpr (requires { Path::avx512; })
        if (cpuHasAvx512()) return Path::avx512;
    if (cpuHasAvx2()) return Path::avx2;
#endif
    return Path::portable;
}

// Returns all paths that this processor can run, slowest first.
template <class Path>
std::vector<Path> pathsOf() {
    std::vector<Path> paths = {Path::portable};
#ifdef PENUMBRA_X86_PATHS
    if (cpuHasAvx2()) paths.push_back(Path::avx2);
    if constexpr (requires { Path::avx512; })
        if (cpuHasAvx512()) paths.push_back(Path::avx512);
#endif
    return paths;
}

}  // namespace penumbra
