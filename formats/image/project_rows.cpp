// Problem: the moments of a row of 16384 pixels, sum f(p) cos mp and sum f(p) sin mp for m < 6, take 11 multiplications
// a pixel and colour.
//
// Here: the four pixels at p, p + pi, -pi - p and -p share their cosines and sines up to signs that depend on whether m
// is odd. So a row is folded twice first, which takes two additions a pixel, and a quarter of the products is left.
// Sums of a row are floats in 8 lanes; rows are added in double.
#include "formats/image/project_rows.h"

#include <cassert>
#include <cmath>
#include <numbers>

namespace penumbra {

using std::numbers::pi;

namespace {

float laneDot(const float* a, const float* b, std::size_t count) {
    constexpr std::size_t kWide = 8;
    std::array<float, kWide> sum{};
    std::size_t i = 0;
    for (; i + kWide <= count; i += kWide)
        for (std::size_t j = 0; j < kWide; ++j) sum[j] += a[i + j] * b[i + j];
    float rest = 0;
    for (; i < count; ++i) rest += a[i] * b[i];
    for (float lane : sum) rest += lane;
    return rest;
}

}  // namespace

RowProjection::RowProjection(PictureSides sides, int order)
    : sides_(sides), order_(order), waves_(wavesOfRow(sides.width, order)) {
    if (sides.width % 4 != 0) return;
    const auto quarter = [&](const std::vector<double>& whole) {
        return std::vector<float>(whole.begin(), whole.begin() + sides.width / 4);
    };
    for (std::size_t m = 0; m < std::size_t(order); ++m) {
        cosine_[m] = quarter(waves_.cosine[m]);
        sine_[m] = quarter(waves_.sine[m]);
    }
    for (auto& of_parity : folded_)
        for (auto& half : of_parity) half.resize(std::size_t(sides.width / 4));
    both_.resize(std::size_t(sides.width / 2));
}

// f(p) +- f(p + pi) is what even and odd m see of both; then x and the pixel that mirrors it, at -pi - p, in which
// cosines of even m and sines of odd m are the same, and the others change their sign.
void RowProjection::fold(const float* row) {
    const std::size_t half = std::size_t(sides_.width / 2), quarter = half / 2;
    for (std::size_t parity = 0; parity < 2; ++parity) {
        float* both = both_.data();
        if (parity == 0)
            for (std::size_t x = 0; x < half; ++x) both[x] = row[x] + row[x + half];
        else
            for (std::size_t x = 0; x < half; ++x) both[x] = row[x] - row[x + half];
        float* sums = folded_[parity][parity].data();
        for (std::size_t x = 0; x < quarter; ++x) sums[x] = both[x] + both[half - 1 - x];
        float* differences = folded_[parity][1 - parity].data();
        for (std::size_t x = 0; x < quarter; ++x) differences[x] = both[x] - both[half - 1 - x];
    }
}

RowMoments RowProjection::foldedMoments(const std::array<const float*, 3>& color) {
    RowMoments moments;
    for (int c = 0; c < 3; ++c) {
        fold(color[std::size_t(c)]);
        for (std::size_t m = 0; m < std::size_t(order_); ++m) {
            const auto& folded = folded_[m % 2];
            moments.cosine[m][c] = double(laneDot(folded[0].data(), cosine_[m].data(), cosine_[m].size()));
            if (m > 0) moments.sine[m][c] = double(laneDot(folded[1].data(), sine_[m].data(), sine_[m].size()));
        }
    }
    return moments;
}

RowMoments RowProjection::plainMoments(const std::array<const float*, 3>& color) const {
    RowMoments moments;
    for (int c = 0; c < 3; ++c)
        for (std::size_t m = 0; m < std::size_t(order_); ++m)
            for (std::size_t x = 0; x < std::size_t(sides_.width); ++x) {
                moments.cosine[m][c] += double(color[std::size_t(c)][x]) * waves_.cosine[m][x];
                moments.sine[m][c] += double(color[std::size_t(c)][x]) * waves_.sine[m][x];
            }
    return moments;
}

void RowProjection::add(int row, const std::array<const float*, 3>& color) {
    const double t0 = pi * row / sides_.height, t1 = pi * (row + 1) / sides_.height;
    const double solid_angle = 2 * pi / sides_.width * (std::cos(t0) - std::cos(t1));
    for (const float* plane : color)
        sum_.energy += solid_angle * double(laneDot(plane, plane, std::size_t(sides_.width)));
    addRowMoments(sides_.width % 4 == 0 ? foldedMoments(color) : plainMoments(color), t0, t1, order_, sum_);
}

}  // namespace penumbra
