#include "player/composite/compose_picture.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/common/parallel_for.h"

namespace penumbra {

namespace {

struct PixelAddition {
    Vec3 character, ratio;
    float alpha;
    bool isNothing() const { return alpha == 0 && character == Vec3{} && ratio == Vec3{1, 1, 1}; }
};

PixelAddition additionAt(const Addition& addition, std::size_t i) {
    const Image& characters = addition.characters;
    if (characters.pixels.empty()) return {{}, addition.ratio[i], 0};
    return {characters.pixels[i], addition.ratio[i], std::clamp(characters.alpha[i], 0.0f, 1.0f)};
}

void overRows(const Plate& plate, int threads, const auto& body) {
    const auto width = std::size_t(plate.width());
    parallelFor(std::size_t(plate.height()), threads, [&](std::size_t y) {
        for (std::size_t i = y * width; i < (y + 1) * width; ++i) body(i);
    });
}

}  // namespace

Composer::Composer(const CameraResponse& response, float exposure) : response_(response), exposure_(exposure) {
    for (std::size_t c = 0; c < 3; ++c) {
        const std::array<float, 256>& curve = response_.exposure[c];
        for (std::size_t code = 0; code < 256; ++code) back_[c][code] = codeOf(response_, int(c), curve[code]);
        for (std::size_t h = 0; h <= kHints; ++h) {
            // One less, so that rounding never begins too high.
            const float root = std::max(float(h) - 1, 0.0f) / float(kHints);
            const auto above = std::upper_bound(curve.begin(), curve.end(), root * root * curve.back());
            hints_[c][h] = std::uint16_t(above - curve.begin());
        }
    }
}

float Composer::codeAt(int channel, float light) const {
    const std::array<float, 256>& curve = response_.exposure[std::size_t(channel)];
    if (!(light < curve.back())) return light >= curve.back() ? 255 : 0;
    const float root = std::sqrt(std::max(light, 0.0f) / curve.back());
    std::size_t above = hints_[std::size_t(channel)][std::size_t(root * float(kHints))];
    while (curve[above] <= light) ++above;  // the last one is larger
    if (above == 0) return 0;
    const float low = curve[above - 1];
    return float(above - 1) + (light - low) / (curve[above] - low);
}

Vec3 Composer::plateLight(const Plate& plate, std::size_t pixel) const {
    if (plate.isLinear()) return plate.linear.pixels[pixel] * exposure_;
    Vec3 light;
    for (int c = 0; c < 3; ++c)
        light[c] = response_.exposure[std::size_t(c)][plate.codes.rgb[3 * pixel + std::size_t(c)]];
    return light;
}

Image Composer::radianceOf(Plate plate) const {
    if (plate.isLinear()) return std::move(plate.linear);
    Image out{plate.width(), plate.height(), {}, {}};
    const std::size_t pixels = plate.codes.rgb.size() / 3;
    for (std::size_t i = 0; i < pixels; ++i) out.pixels.push_back(plateLight(plate, i) / exposure_);
    return out;
}

TexturePicture Composer::compose(const Plate& plate, const Addition& addition, std::span<const float> grain,
                                 int threads) const {
    TexturePicture out{plate.width(), plate.height(), {}};
    out.rgb.resize(3 * std::size_t(out.width) * std::size_t(out.height));
    overRows(plate, threads, [&](std::size_t i) {
        const PixelAddition added = additionAt(addition, i);
        if (added.isNothing() && !plate.isLinear()) {
            std::copy_n(plate.codes.rgb.begin() + std::ptrdiff_t(3 * i), 3, out.rgb.begin() + std::ptrdiff_t(3 * i));
            return;
        }
        const Vec3 light = composed(added.character * exposure_, added.alpha, plateLight(plate, i), added.ratio);
        for (int c = 0; c < 3; ++c) {
            const std::size_t at = 3 * i + std::size_t(c);
            float code = codeAt(c, light[c]);
            // The flat pieces of the curve lose part of a code. This part is added back where the plate shows.
            if (!plate.isLinear()) {
                const std::uint8_t before = plate.codes.rgb[at];
                code += (float(before) - back_[std::size_t(c)][before]) * (1 - added.alpha);
            }
            if (!grain.empty()) code += grain[at] * added.alpha;
            out.rgb[at] = std::uint8_t(std::clamp(code, 0.0f, 255.0f) + 0.5f);
        }
    });
    return out;
}

Image Composer::composeLinear(const Plate& plate, const Addition& addition, int threads) const {
    Image out{plate.width(), plate.height(), {}, {}};
    out.pixels.resize(std::size_t(out.width) * std::size_t(out.height));
    overRows(plate, threads, [&](std::size_t i) {
        const PixelAddition added = additionAt(addition, i);
        out.pixels[i] = composed(added.character, added.alpha, plateLight(plate, i) / exposure_, added.ratio);
    });
    return out;
}

}  // namespace penumbra
