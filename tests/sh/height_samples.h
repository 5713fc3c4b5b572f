#pragma once
// Height fields for tests.
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "sh/height/height_field.h"

namespace penumbra {

// Fourier transform of `count` numbers that stand `step` apart, a power of two.
inline void fourier(std::complex<double>* data, std::size_t count, std::size_t step, double sign) {
    std::vector<std::complex<double>> line(count);
    for (std::size_t i = 0, j = 0; i < count; ++i) {
        line[j] = data[i * step];
        std::size_t bit = count / 2;
        for (; bit > 0 && (j & bit); bit /= 2) j ^= bit;
        j |= bit;
    }
    for (std::size_t half = 1; half < count; half *= 2)
        for (std::size_t k = 0; k < half; ++k) {
            const std::complex<double> turn = std::polar(1.0, sign * std::numbers::pi * double(k) / double(half));
            for (std::size_t i = k; i < count; i += 2 * half) {
                const std::complex<double> other = turn * line[i + half];
                line[i + half] = line[i] - other;
                line[i] += other;
            }
        }
    for (std::size_t i = 0; i < count; ++i) data[i * step] = line[i];
}

// The middle of a noise of spectrum f^-beta on a square twice as wide, with a standard deviation of `deviation`.
inline std::vector<float> fractalHeights(int rows, int columns, double beta, double deviation, unsigned seed = 1) {
    std::size_t side = 2;
    while (side < 2 * std::size_t(std::max(rows, columns))) side *= 2;
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::vector<std::complex<double>> noise(side * side);
    for (std::complex<double>& z : noise) z = normal(random);
    const auto transform = [&](double sign) {
        for (std::size_t i = 0; i < side; ++i) fourier(&noise[i * side], side, 1, sign);
        for (std::size_t i = 0; i < side; ++i) fourier(&noise[i], side, side, sign);
    };
    transform(-1);
    const auto frequency = [&](std::size_t i) { return double(std::min(i, side - i)) / double(side); };
    for (std::size_t i = 0; i < side; ++i)
        for (std::size_t j = 0; j < side; ++j)
            if (i + j > 0) noise[i * side + j] /= std::pow(std::hypot(frequency(i), frequency(j)), beta);
    transform(1);
    double mean = 0, square = 0;
    std::vector<double> cut;
    for (int r = 0; r < rows; ++r)
        for (int c = 0; c < columns; ++c) cut.push_back(noise[std::size_t(r) * side + std::size_t(c)].real());
    for (const double z : cut) mean += z / double(cut.size());
    for (const double z : cut) square += (z - mean) * (z - mean) / double(cut.size());
    std::vector<float> out;
    for (const double z : cut) out.push_back(float((z - mean) * deviation / std::sqrt(std::max(square, 1e-30))));
    return out;
}

}  // namespace penumbra
