// Adds up rows for 16 vertices at a time: transfer_kernel.h has the formula.
//
// transfer_portable.cpp and transfer_avx2.cpp include this source and differ in the processor that they are compiled
// for. Everything has internal linkage and calls nothing inline from the standard library, so that no copy made for one
// processor can end up in the other's path.
#include "runtime/evaluate/transfer_kernel.h"

namespace penumbra {

namespace {

constexpr std::size_t kTransferLanes = 8;
typedef float TransferLanes __attribute__((vector_size(4 * kTransferLanes)));

inline void loadLanes(const float* from, TransferLanes& to) { __builtin_memcpy(&to, from, sizeof to); }
inline void storeLanes(const TransferLanes& from, float* to) { __builtin_memcpy(to, &from, sizeof from); }

template <std::size_t kSums>
inline void addBlock(const TransferRows& in, std::size_t at) {
    TransferLanes low[kSums], high[kSums];
    for (std::size_t o = 0; o < kSums; ++o) {
        loadLanes(in.out + o * in.out_stride + at, low[o]);
        loadLanes(in.out + o * in.out_stride + at + kTransferLanes, high[o]);
    }
    for (std::size_t i = 0; i < in.count; ++i) {
        TransferLanes first, second;
        loadLanes(in.rows + i * in.row_stride + at, first);
        loadLanes(in.rows + i * in.row_stride + at + kTransferLanes, second);
        for (std::size_t o = 0; o < kSums; ++o) {
            low[o] += in.factors[i * kSums + o] * first;
            high[o] += in.factors[i * kSums + o] * second;
        }
    }
    for (std::size_t o = 0; o < kSums; ++o) {
        storeLanes(low[o], in.out + o * in.out_stride + at);
        storeLanes(high[o], in.out + o * in.out_stride + at + kTransferLanes);
    }
}

template <std::size_t kSums>
inline void addRows(const TransferRows& in) {
    std::size_t at = 0;
    for (; at + 2 * kTransferLanes <= in.width; at += 2 * kTransferLanes) addBlock<kSums>(in, at);
    for (; at < in.width; ++at)
        for (std::size_t o = 0; o < kSums; ++o) {
            float sum = in.out[o * in.out_stride + at];
            for (std::size_t i = 0; i < in.count; ++i)
                sum += in.factors[i * kSums + o] * in.rows[i * in.row_stride + at];
            in.out[o * in.out_stride + at] = sum;
        }
}

void addTransferRows(const TransferRows& in) {
    if (in.sums == 1) addRows<1>(in);
    if (in.sums == 3) addRows<3>(in);
    if (in.sums == 4) addRows<4>(in);
}

}  // namespace

}  // namespace penumbra
