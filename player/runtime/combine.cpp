#include "player/runtime/combine.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>

#include "formats/fp16.h"
#include "player/runtime/shade_kernel.h"

namespace penumbra {

namespace {

constexpr std::size_t kTile = 64;  // numbers; the sums of a tile stay in the first-level cache

void load(const std::int8_t* from, std::span<float> to) { std::copy_n(from, to.size(), to.begin()); }
void load(const std::uint16_t* from, std::span<float> to) { halfToFloat({from, to.size()}, to); }
void load(const float* from, std::span<float> to) { std::copy_n(from, to.size(), to.begin()); }

template <class Stored>
void combine(const CombineInput& in, float* out) {
    std::array<float, kTile> buffer;
    for (std::size_t at = 0; at < in.count; at += kTile) {
        const std::size_t n = std::min(kTile, in.count - at);
        const std::span<float> sum(out + at, n), component(buffer.data(), n);
        if (in.mean_is_half)
            load(static_cast<const std::uint16_t*>(in.mean) + at, sum);
        else
            load(static_cast<const float*>(in.mean) + at, sum);
        for (std::size_t k = 0; k < in.components; ++k) {
            load(static_cast<const Stored*>(in.basis) + k * in.count + at, component);
            for (std::size_t i = 0; i < n; ++i) sum[i] += in.weights[k] * component[i];
        }
    }
}

}  // namespace

std::vector<EvaluatorPath> evaluatorPaths() {
    std::vector<EvaluatorPath> paths = {{"portable", combine<std::int8_t>, combine<std::uint16_t>, combine<float>}};
    if (kEvaluatorAvx2 && cpuHasAvx2() && !std::getenv("PENUMBRA_NO_SIMD")) paths.push_back(*kEvaluatorAvx2);
    return paths;
}

}  // namespace penumbra
