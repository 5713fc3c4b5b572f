#pragma once
#include "formats/image/tone_map.h"

namespace penumbra {

// Tells how linear radiance becomes what a screen shows, in the fragment shader (shaders/channel.frag). Only shaded
// pictures are exposed and tone mapped; all pictures are sRGB encoded.
struct DisplayTransform {
    float exposure = 1;  // factor on the radiance, > 0
    ToneMap tone_map = ToneMap::kOff;
    bool operator==(const DisplayTransform&) const = default;
};

}  // namespace penumbra
