#pragma once
#include <span>
#include <vector>

#include "sh/mirrored_product.h"
#include "sh/visibility_convention.h"

namespace penumbra {

// Multiplies the numbers of one vertex, in any convention, by what others leave visible there.
class CastProduct {
public:
    explicit CastProduct(const Convention& convention);

    // `numbers` [convention.size()] and `mirrored` [kFarNumbers, as CastShadow::evaluate() has them] are in one local
    // frame. E of the product is clamped to [0, 1]. Allocates nothing.
    void operator()(std::span<float> numbers, std::span<const float> mirrored) const;

private:
    Convention convention_;
    MirroredProduct in_mirror_;  // of D
    std::size_t size_;
    std::vector<float> weights_;
    std::vector<double> below_;  // what stands below the horizon of A
    float norm2_ = 0;
    std::vector<int> even_;  // SH index of each mirrored number

    void multiplyInMirror(std::span<float> numbers, std::span<const float> mirrored) const;
    void multiplyAbove(std::span<float> numbers, std::span<const float> mirrored) const;
};

}  // namespace penumbra
