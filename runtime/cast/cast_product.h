#pragma once
#include <span>
#include <vector>

#include "sh/far/far_kernel.h"
#include "sh/visibility_convention.h"

namespace penumbra {

// Multiplies the numbers of vertices, in any convention, by what others leave visible there.
class CastProduct {
public:
    explicit CastProduct(const Convention& convention);

    // `coefficients` [vertices, stride] and `mirrored` [vertices, kFarCoefficients, as CastShadow::evaluate() has them]
    // are in the vertices' local frames; stride >= convention.size(). E of the product is clamped to [0, 1]. Allocates
    // nothing.
    void operator()(std::span<float> coefficients, std::size_t stride, std::span<const float> mirrored) const;

private:
    Convention convention_;
    const FarConstants* in_mirror_ = nullptr;  // for convention D
    std::size_t size_;
    std::vector<float> weights_;
    std::vector<double> below_;  // the part of A that lies below the horizon
    float norm2_ = 0;
    std::vector<int> even_;  // SH index of each mirrored number

    void multiplyAbove(std::span<float> coefficients, std::span<const float> mirrored) const;
};

}  // namespace penumbra
