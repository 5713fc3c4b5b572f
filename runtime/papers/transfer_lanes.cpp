// Adds up rows for 16 vertices at a time: transfer_kernel.h has the formula.
#include "runtime/papers/transfer_kernel.h"
#include "sh/lanes.h"

namespace penumbra {

namespace {

template <std::size_t kSums>
inline void addBlock(const TransferRows& in, std::size_t at) {
    Lanes low[kSums], high[kSums];
    for (std::size_t o = 0; o < kSums; ++o) {
        loadFloats(in.out + o * in.out_stride + at, low[o]);
        loadFloats(in.out + o * in.out_stride + at + kLanes, high[o]);
    }
    for (std::size_t i = 0; i < in.count; ++i) {
        Lanes first, second;
        loadFloats(in.rows + i * in.row_stride + at, first);
        loadFloats(in.rows + i * in.row_stride + at + kLanes, second);
        for (std::size_t o = 0; o < kSums; ++o) {
            low[o] += in.factors[i * kSums + o] * first;
            high[o] += in.factors[i * kSums + o] * second;
        }
    }
    for (std::size_t o = 0; o < kSums; ++o) {
        storeFloats(low[o], in.out + o * in.out_stride + at);
        storeFloats(high[o], in.out + o * in.out_stride + at + kLanes);
    }
}

template <std::size_t kSums>
inline void addRows(const TransferRows& in) {
    std::size_t at = 0;
    for (; at + 2 * kLanes <= in.width; at += 2 * kLanes) addBlock<kSums>(in, at);
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

const TransferPath TransferPath::PENUMBRA_TARGET{PENUMBRA_TARGET_NAME, addTransferRows};

}  // namespace penumbra
