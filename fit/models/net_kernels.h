#pragma once
// The dense loops of the neural fit, on numbers stored unit by unit: a row holds one number a frame, padded with zeros
// to a whole number of lanes, so that every loop runs along the frames. A portable path, and the same source for AVX2.
#include <cstddef>
#include <vector>

namespace penumbra {

constexpr std::size_t kNetLanes = 4;  // doubles

struct NetKernels {
    const char* name = "";
    // out[n][f] += sum_i a[n][i] b[i][f]. `a` is [rows, inner] with a_stride between its rows, b [inner, stride], out
    // [rows, stride]; stride is a multiple of kNetLanes.
    void (*addProduct)(std::size_t rows, std::size_t inner, std::size_t stride, const double* a, std::size_t a_stride,
                       const double* b, double* out) = nullptr;
    // out[i][j] = sum_f a[i][f] b[j][f]; a [rows, stride], b [columns, stride], out [rows, columns] with out_stride.
    void (*innerProducts)(std::size_t rows, std::size_t columns, std::size_t stride, const double* a, const double* b,
                          double* out, std::size_t out_stride) = nullptr;
    // h = tanh(z) within 2e-16, in place; slope = 1 - h^2. `count` is a multiple of kNetLanes.
    void (*tanhAndSlope)(std::size_t count, double* z, double* slope) = nullptr;
};

// The paths that this processor can run, slowest first; PENUMBRA_NO_SIMD leaves only the portable one.
std::vector<NetKernels> netKernelPaths();

extern const NetKernels* const kNetKernelsAvx2;  // null where the compiler has no such target

}  // namespace penumbra
