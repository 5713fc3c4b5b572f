#pragma once
// The dense loops of the neural fit. Numbers are stored unit by unit: a row holds one number per frame and is padded
// with zeros to a whole number of lanes, so that every loop runs along the frames.
#include <cstddef>
#include <vector>

#include "sh/kernel.h"

namespace penumbra {

constexpr std::size_t kNetLanes = 4;  // doubles in a vector

struct NetKernels {
    static const NetKernels portable, avx2;
    const char* name = "";
    // out[n][f] += sum_i a[n][i] b[i][f]. `a` is [rows, inner] with a_stride numbers from row to row, `b` is [inner,
    // stride] and `out` is [rows, stride]. The stride is a multiple of kNetLanes.
    void (*addProduct)(std::size_t rows, std::size_t inner, std::size_t stride, const double* a, std::size_t a_stride,
                       const double* b, double* out) = nullptr;
    // out[i][j] = sum_f a[i][f] b[j][f]. `a` is [rows, stride], `b` is [columns, stride] and `out` is [rows, columns]
    // with out_stride numbers from row to row.
    void (*innerProducts)(std::size_t rows, std::size_t columns, std::size_t stride, const double* a, const double* b,
                          double* out, std::size_t out_stride) = nullptr;
    // Replaces z by h = tanh(z), within 2e-16, and sets slope = 1 - h^2. `count` is a multiple of kNetLanes.
    void (*tanhAndSlope)(std::size_t count, double* z, double* slope) = nullptr;
};

// Returns the paths that this processor can run, slowest first. PENUMBRA_NO_SIMD leaves only the portable one.
inline std::vector<NetKernels> netKernelPaths() { return pathsOf<NetKernels>(); }

}  // namespace penumbra
