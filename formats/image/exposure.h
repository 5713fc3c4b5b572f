#pragma once
// Chooses the exposure of a picture: the factor on its linear colours at which 8 bits show it. EXR pictures are never
// exposed.
#include "formats/image/image_file.h"

namespace penumbra {

// An automatic exposure shows the 90th percentile of a picture's luminance as 0.6, which sRGB encodes as 203 of 255.
// A tenth of the picture is brighter, so highlights and a sunlit side may be cut while everything else shows.
constexpr double kExposedPercentile = 90;
constexpr float kExposedValue = 0.6f;  // linear
// Bounds of every automatic exposure.
constexpr float kMinExposure = 1e-6f, kMaxExposure = 1e6f;

// Returns the automatic exposure of a picture without a background. It counts the pixels that are covered by half or
// more and whose luminance (Rec.709) is finite and above 0: black pixels stay black at any exposure. Where there are
// none it returns 1. The factor is rounded to 4 digits, so that a user who types the printed number gets the same
// picture.
float automaticExposure(const Image& image);

// Puts a picture over a background, as a PNG of this exposure shows it: colours in [0, 1] without alpha. The
// background is not exposed, so it looks the same under any light.
Image overBackground(const Image& image, float exposure, Vec3 background);

}  // namespace penumbra
