#pragma once
// Bends linear colours so that what is brighter than the screen keeps its shape.
#include "formats/common/words.h"
#include "formats/image/image_file.h"

namespace penumbra {

enum class ToneMap {
    kOff,       // values above 1 are cut
    kReinhard,  // c / (1 + c)
    kFilmic,    // K. Narkowicz's fit of the ACES curve (2016, CC0)
};
inline constexpr Word<ToneMap> kToneWords[] = {
    {"off", ToneMap::kOff}, {"reinhard", ToneMap::kReinhard}, {"filmic", ToneMap::kFilmic}};

// Returns an exposed linear colour as it is shown, linear and at most 1 (not cut where `tone` is kOff). Negative
// channels become 0.
Vec3 toneMapped(Vec3 exposed, ToneMap tone);

// Exposes and maps a picture. Its colours are multiplied by alpha before and after, and the curve is that of the colour
// itself.
Image toneMapped(Image image, float exposure, ToneMap tone);

}  // namespace penumbra
