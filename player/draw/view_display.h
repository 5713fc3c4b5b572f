#pragma once

namespace penumbra {

// Tells how linear radiance becomes what a screen shows, in the fragment shader (shaders/channel.frag). Only shaded
// pictures are exposed and tone mapped; all pictures are sRGB encoded.
enum class ToneMap {
    kOff,       // values above 1 are cut
    kReinhard,  // c / (1 + c)
    kFilmic,    // K. Narkowicz's fit of the ACES curve (2016, CC0)
};

struct DisplayTransform {
    float exposure = 1;  // factor on the radiance, > 0
    ToneMap tone_map = ToneMap::kOff;
    bool operator==(const DisplayTransform&) const = default;
};

}  // namespace penumbra
