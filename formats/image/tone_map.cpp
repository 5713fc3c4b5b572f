#include "formats/image/tone_map.h"

#include <algorithm>

namespace penumbra {

namespace {

float toneMapped(float c, ToneMap tone) {
    c = std::max(c, 0.0f);
    switch (tone) {
        case ToneMap::kReinhard:
            return c / (1 + c);
        case ToneMap::kFilmic:
            return std::min(c * (2.51f * c + 0.03f) / (c * (2.43f * c + 0.59f) + 0.14f), 1.0f);
        case ToneMap::kOff:
            break;
    }
    return c;
}

}  // namespace

Vec3 toneMapped(Vec3 exposed, ToneMap tone) {
    return {toneMapped(exposed.x, tone), toneMapped(exposed.y, tone), toneMapped(exposed.z, tone)};
}

Image toneMapped(Image image, float exposure, ToneMap tone) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const float alpha = image.alpha.empty() ? 1 : image.alpha[i];
        image.pixels[i] = alpha > 0 ? toneMapped(image.pixels[i] * (exposure / alpha), tone) * alpha : Vec3{};
    }
    return image;
}

}  // namespace penumbra
