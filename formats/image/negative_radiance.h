#pragma once
// Lossy compression (OpenEXR's DWAA and DWAB) leaves dark rings below 0 beside bright pixels; in real pictures they
// take back up to a tenth of the light that overshoots next to them.
#include <string>

#include "formats/image/environment_map.h"

namespace penumbra {

struct NegativeRadiance {
    std::size_t pixels = 0;  // that were below 0 in some channel
    double share = 0;        // of the light, channels summed, steradians counted
};

// Sets what is below 0 to 0 and takes as much flux from the pixels above 0 at most 8 away, in proportion to theirs,
// channel by channel, so that no light is added. InvalidInput, naming the pixel, where a value is further below 0 than
// half of the largest one around: no compression does that.
NegativeRadiance removeNegativeRadiance(EnvironmentMap& map, const std::string& name);

}  // namespace penumbra
