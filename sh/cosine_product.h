#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

// Turns the moments b of visibility, of order n + 1, into the transfer t_i = integral of V cos y_i of order n. It is
// exact, because the cosine s.N is an SH function of band 1.
class CosineProduct {
public:
    explicit CosineProduct(int order);  // n
    // `moments` has (n + 1)^2 numbers, `transfer` n^2.
    void apply(std::span<const float> moments, Vec3 normal, std::span<float> transfer) const;

private:
    struct Entry {
        std::uint16_t i, j;
        Vec3 value;
    };
    std::vector<Entry> entries_;
};

// Returns the integrals over z >= 0 of z y_i y_j, [rows^2, columns^2], for orders of functions in a local frame. It
// takes the coefficients of a visibility function to its transfer.
std::vector<double> cosineMatrix(int rows, int columns);

}  // namespace penumbra
