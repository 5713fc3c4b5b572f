#pragma once
// The inner loop of transfer: sums of rows, each times a factor of the pose (transfer_lanes.cpp).
#include <cstddef>
#include <vector>

#include "sh/kernel.h"

namespace penumbra {

// out[o * out_stride + v] += sum over i < count of factors[i * sums + o] * rows[i * row_stride + v], for o < sums and
// v < width. Each number of a row is read once for all sums.
struct TransferRows {
    const float* rows = nullptr;
    std::size_t row_stride = 0, count = 0;
    const float* factors = nullptr;
    std::size_t sums = 1;  // 1, 3 or 4
    std::size_t width = 0;
    float* out = nullptr;
    std::size_t out_stride = 0;
};

struct TransferPath {
    static const TransferPath portable, avx2;
    const char* name = "";
    void (*add)(const TransferRows& rows) = nullptr;
};

// Returns the paths that this processor can run, slowest first. PENUMBRA_NO_SIMD leaves only the portable one.
inline std::vector<TransferPath> transferPaths() { return pathsOf<TransferPath>(); }

}  // namespace penumbra
