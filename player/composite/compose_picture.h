#pragma once
// Puts characters and their shadows into a photograph.
#include <array>
#include <cstdint>
#include <span>

#include "formats/image/image_file.h"
#include "formats/image/texture_file.h"
#include "sh/camera_response.h"

namespace penumbra {

// The composite of one pixel in linear light, per channel: characters + (1 - alpha) plate ratio.
constexpr Vec3 composed(Vec3 character, float alpha, Vec3 plate, Vec3 ratio) {
    return character + plate * ratio * (1 - alpha);
}

// A photograph: codes of a camera, or linear light, which is radiance that no exposure was applied to.
struct Plate {
    TexturePicture codes;  // its size is that of `linear` where that is there, and it is empty then
    Image linear;          // empty: codes
    bool isLinear() const { return !linear.pixels.empty(); }
    int width() const { return isLinear() ? linear.width : codes.width; }
    int height() const { return isLinear() ? linear.height : codes.height; }
};

// The pictures that are composed with a plate: characters as radiance times coverage (empty pixels: nobody) and the
// ratio [height, width].
struct Addition {
    const Image& characters;
    std::span<const Vec3> ratio;
};

class Composer {
public:
    // Light of 1 times `exposure` has the highest code.
    Composer(const CameraResponse& response, float exposure);
    // Composes codes. Where nothing is added the plate's codes stay the very ones that they were. `grain` is added to
    // the codes of characters [height, width, 3] as far as they cover; it may be empty.
    TexturePicture compose(const Plate& plate, const Addition& addition, std::span<const float> grain,
                           int threads) const;
    // Composes radiance: the light of codes over the exposure.
    Image composeLinear(const Plate& plate, const Addition& addition, int threads) const;

    // Returns the radiance of a picture: the light of codes over the exposure.
    Image radianceOf(Plate plate) const;

private:
    CameraResponse response_;
    float exposure_;
    std::array<std::array<float, 256>, 3> back_;  // codeOf(exposureOf(code)), which differs where the curve is flat

    // Where to begin to look for the code of some light, by the root of its share of the highest.
    static constexpr std::size_t kHints = 1024;
    std::array<std::array<std::uint16_t, kHints + 1>, 3> hints_;

    float codeAt(int channel, float light) const;                  // codeOf(), faster
    Vec3 plateLight(const Plate& plate, std::size_t pixel) const;  // times exposure
};

}  // namespace penumbra
