#include "formats/image/exposure.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace penumbra {

namespace {

// Returns the luminance of every pixel that counts.
std::vector<float> litLuminances(const Image& image) {
    std::vector<float> lit;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const float alpha = image.alpha.empty() ? 1 : image.alpha[i];
        if (!(alpha >= 0.5f)) continue;
        const Vec3& color = image.pixels[i];
        const float luminance = (0.2126f * color.x + 0.7152f * color.y + 0.0722f * color.z) / alpha;
        if (luminance > 0 && std::isfinite(luminance)) lit.push_back(luminance);
    }
    return lit;
}

float roundedToFourDigits(float value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", double(value));
    return std::strtof(text, nullptr);
}

}  // namespace

float automaticExposure(const Image& image) {
    std::vector<float> lit = litLuminances(image);
    if (lit.empty()) return 1;
    const double rank = std::ceil(kExposedPercentile / 100 * double(lit.size()));  // counts from 1
    const auto chosen = lit.begin() + std::ptrdiff_t(rank) - 1;
    std::nth_element(lit.begin(), chosen, lit.end());
    // The quotient may overflow, and the bound then holds.
    return roundedToFourDigits(std::clamp(kExposedValue / *chosen, kMinExposure, kMaxExposure));
}

Image overBackground(const Image& image, float exposure, Vec3 background) {
    Image out{image.width, image.height, {}, {}};
    out.pixels.reserve(image.pixels.size());
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const float alpha = image.alpha.empty() ? 1 : image.alpha[i];
        Vec3 color;
        for (int c = 0; c < 3; ++c)
            color[c] = std::clamp(image.pixels[i][c] * exposure, 0.0f, alpha) + (1 - alpha) * background[c];
        out.pixels.push_back(color);
    }
    return out;
}

}  // namespace penumbra
