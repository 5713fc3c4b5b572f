#include "player/composite/plate_grain.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace penumbra {

namespace {

constexpr std::size_t kLevels = 8, kMin = 200;

// SplitMix64 (Steele, Lea and Flood 2014).
std::uint64_t mixed(std::uint64_t x) {
    x += 0x9E3779B97F4A7C15u;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return x ^ (x >> 31);
}

// Box and Muller's normal deviate.
float deviate(std::uint64_t seed) {
    const std::uint64_t bits = mixed(seed);
    const double u = (double(bits >> 40) + 1) / 16777217.0, v = double(bits & 0xFFFFFF) / 16777216.0;
    return float(std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v));
}

// Levels without a measurement take that of the nearest one that has it.
void fillGaps(std::array<float, kLevels>& deviation) {
    const std::array<float, kLevels> measured = deviation;
    for (std::size_t l = 0; l < kLevels; ++l)
        for (std::size_t away = 0; deviation[l] < 0 && away < kLevels; ++away) {
            if (l >= away && measured[l - away] >= 0) deviation[l] = measured[l - away];
            if (l + away < kLevels && measured[l + away] >= 0) deviation[l] = measured[l + away];
        }
    for (float& d : deviation) d = std::max(d, 0.0f);
}

}  // namespace

PlateGrain measureGrain(const TexturePicture& plate) {
    PlateGrain out;
    const auto width = std::ptrdiff_t(plate.width);
    for (std::size_t c = 0; c < 3; ++c) {
        std::array<std::vector<float>, kLevels> sizes;
        const auto at = [&](std::ptrdiff_t i) { return int(plate.rgb[3 * std::size_t(i) + c]); };
        for (std::ptrdiff_t y = 1; y + 1 < plate.height; ++y)
            for (std::ptrdiff_t x = 1; x + 1 < width; ++x) {
                const std::ptrdiff_t i = y * width + x;
                if (at(i) <= 2 || at(i) >= 250) continue;  // clipped
                const int difference = at(i - width - 1) - 2 * at(i - width) + at(i - width + 1) - 2 * at(i - 1) +
                                       4 * at(i) - 2 * at(i + 1) + at(i + width - 1) - 2 * at(i + width) +
                                       at(i + width + 1);
                sizes[std::size_t(at(i)) / 32].push_back(float(std::abs(difference)));
            }
        for (std::size_t l = 0; l < kLevels; ++l) {
            out.deviation[c][l] = -1;
            if (sizes[l].size() < kMin) continue;
            const auto middle = sizes[l].begin() + std::ptrdiff_t(sizes[l].size() / 2);
            std::nth_element(sizes[l].begin(), middle, sizes[l].end());
            constexpr float kMedian = 0.6745f, kMask = 6;  // median of |normal|; root of the sum of the mask's squares
            out.deviation[c][l] = *middle / (kMedian * kMask);
        }
        fillGaps(out.deviation[c]);
    }
    return out;
}

std::vector<float> grainFor(const PlateGrain& grain, const TexturePicture& codes, std::uint64_t number) {
    std::vector<float> out(codes.rgb.size());
    const std::uint64_t seed = mixed(number);
    for (std::size_t i = 0; i < out.size(); ++i) {
        const float level = std::clamp((float(codes.rgb[i]) - 16) / 32, 0.0f, float(kLevels - 1));
        const std::size_t low = std::min(std::size_t(level), kLevels - 2);
        const std::array<float, kLevels>& of = grain.deviation[i % 3];
        const float deviation = of[low] + (level - float(low)) * (of[low + 1] - of[low]);
        if (deviation > 0) out[i] = deviation * deviate(seed + i);
    }
    return out;
}

}  // namespace penumbra
