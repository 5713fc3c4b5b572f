#include "player/bench/roofline.h"

namespace penumbra {

namespace {

#ifdef __AVX2__
constexpr std::size_t kRoofLanes = 8;
#else
constexpr std::size_t kRoofLanes = 4;
#endif
typedef float RoofLanes __attribute__((vector_size(4 * kRoofLanes)));

inline float anyOf(const RoofLanes* sums, int count) {
    RoofLanes sum = sums[0];
    for (int i = 1; i < count; ++i) sum += sums[i];
    return sum[0];
}

// There are as many chains as registers, except those of the factors. They hide the 4 cycles of a fused multiply-add
// at 2 a cycle, and the 7 of a multiplication and an addition.
constexpr int kChains = 14;
float multiplyAdds(std::size_t rounds) {
    RoofLanes a[kChains];
    for (int i = 0; i < kChains; ++i) a[i] = RoofLanes{} + 0.1f * float(i);
    const RoofLanes factor = RoofLanes{} + 0.999f, term = RoofLanes{} + 0.001f;
    for (std::size_t r = 0; r < rounds; ++r)
        for (int i = 0; i < kChains; ++i) a[i] = a[i] * factor + term;
    return anyOf(a, kChains);
}

float readAll(const float* from, std::size_t count) {
    RoofLanes a[8] = {};
    const auto* p = reinterpret_cast<const RoofLanes*>(from);
    for (const RoofLanes* end = p + count / kRoofLanes; p < end; p += 8)
        for (int i = 0; i < 8; ++i) a[i] += p[i];
    return anyOf(a, 8);
}

void addHalf(const float* b, const float* c, float* a, std::size_t count) {
    const auto *pb = reinterpret_cast<const RoofLanes*>(b), *pc = reinterpret_cast<const RoofLanes*>(c);
    auto* pa = reinterpret_cast<RoofLanes*>(a);
    for (std::size_t i = 0; i < count / kRoofLanes; ++i) pa[i] = pb[i] + 0.5f * pc[i];
}

}  // namespace

const RooflinePath RooflinePath::PENUMBRA_TARGET{PENUMBRA_TARGET_NAME, multiplyAdds, 2 * kChains* kRoofLanes, readAll,
                                                 addHalf};

}  // namespace penumbra
