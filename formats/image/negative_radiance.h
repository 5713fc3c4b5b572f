#pragma once
// Mends negative radiance. Lossy compression (OpenEXR's DWAA and DWAB) leaves dark rings below 0 beside bright
// pixels. In real pictures they take back up to a tenth of the light that overshoots next to them.
#include <string>

#include "formats/image/environment_map.h"

namespace penumbra {

struct NegativeRadiance {
    std::size_t pixels = 0;  // pixels that were below 0 in some channel
    double share = 0;        // their share of the light, summed over channels and weighted with steradians
};

// Sets what is below 0 to 0, and takes as much flux from the pixels above 0 that are at most 8 away, in proportion to
// theirs, channel by channel. So no light is added. Throws InvalidInput, which names the pixel, where a value is
// further below 0 than half of the largest one around it: no compression does that.
NegativeRadiance removeNegativeRadiance(EnvironmentMap& map, const std::string& name);

}  // namespace penumbra
