#pragma once
// Measures what this machine can do, beside what is compared with it: multiply-adds on registers alone, and bytes
// from memory for working sets of several sizes, which tells the caches apart. (S. Williams, A. Waterman, D.
// Patterson, "Roofline", CACM 52(4), 2009; J. McCalpin's STREAM triad.)
#include <cstddef>
#include <vector>

#include "sh/kernel.h"

namespace penumbra {

// The kernels for one kind of processor (roofline_kernels.cpp). Counts are multiples of 64 floats, and arrays are
// aligned to 64 bytes.
struct RooflinePath {
    static const RooflinePath portable, avx2;
    const char* name = "";
    // nobody needs the result, but it keeps compilers from removing the loop
    float (*multiply_adds)(std::size_t rounds) = nullptr;
    std::size_t flop_a_round = 0;
    float (*read)(const float* from, std::size_t count) = nullptr;
    void (*triad)(const float* b, const float* c, float* a, std::size_t count) = nullptr;  // a = b + 0.5 c
};

struct Bandwidth {
    std::size_t bytes = 0;       // the working set of all threads together
    double read = 0, triad = 0;  // GB/s; the triad reads 8 bytes and writes 4 for each number
    double best() const { return read > triad ? read : triad; }
};

struct Roofline {
    const char* path = "";
    int threads = 1;
    double peak = 0;  // GFLOP/s, a multiply-add counted as two
    std::vector<Bandwidth> memory;
};

// Measures by the fastest path of this processor (respecting PENUMBRA_NO_SIMD) on `threads` threads, each of which
// has its own share of the working set. It takes the best of several runs that all threads begin together.
Roofline measureRoofline(int threads, const std::vector<std::size_t>& working_sets);

// Returns the GFLOP/s that can be attained with `flop_a_byte` on a working set for which `memory` was measured: the
// lower of peak and flop_a_byte times bandwidth.
double attainable(const Roofline& roofline, const Bandwidth& memory, double flop_a_byte);

}  // namespace penumbra
