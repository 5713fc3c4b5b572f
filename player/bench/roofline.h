#pragma once
// What this machine can do, measured beside what it is compared with: multiply-adds on registers alone, and bytes from
// memory for working sets of several sizes, which tells the caches apart. (S. Williams, A. Waterman, D. Patterson,
// "Roofline", CACM 52(4), 2009; J. McCalpin's STREAM triad.)
#include <cstddef>
#include <vector>

namespace penumbra {

// The kernels of one kind of processor; counts are multiples of 64 floats, arrays aligned to 64 bytes.
struct RooflinePath {
    const char* name = "";
    float (*multiply_adds)(std::size_t rounds) = nullptr;  // the result is of no use but keeps them from going away
    std::size_t flop_a_round = 0;
    float (*read)(const float* from, std::size_t count) = nullptr;
    void (*triad)(const float* b, const float* c, float* a, std::size_t count) = nullptr;  // a = b + 0.5 c
};
extern const RooflinePath* const kRooflineAvx2;  // roofline_avx2.cpp; null where the compiler has no such target

struct Bandwidth {
    std::size_t bytes = 0;       // the working set of all threads together
    double read = 0, triad = 0;  // GB/s; of the triad 8 bytes read and 4 written a number
    double best() const { return read > triad ? read : triad; }
};

struct Roofline {
    const char* path = "";
    int threads = 1;
    double peak = 0;  // GFLOP/s, a multiply-add counted as two
    std::vector<Bandwidth> memory;
};

// The fastest path of this processor, PENUMBRA_NO_SIMD respected, on `threads` threads, each with its own share of the
// working set. The best of several runs that all threads begin together.
Roofline measureRoofline(int threads, const std::vector<std::size_t>& working_sets);

// GFLOP/s that can be attained with `flop_a_byte` on a working set that `memory` was measured for: the lower of peak
// and flop_a_byte times bandwidth.
double attainable(const Roofline& roofline, const Bandwidth& memory, double flop_a_byte);

}  // namespace penumbra
