#pragma once
// Finds the lamps and windows of a room in its picture: several lights of up to about 15 degrees radius, also near one
// another. The picture without them and the lights together are the picture.
#include <vector>

#include "formats/image/environment_map.h"
#include "sh/light/dominant_light.h"

namespace penumbra {

struct AreaLight {
    SunD sun;          // with its share already in the irradiance
    double worth = 0;  // part of the light of a level ground that its shadow shows and SH do not
    double share = 0;  // part of the light found here that becomes the sun, 0 .. 1; the rest stays in the picture
};
struct AreaLights {
    std::vector<AreaLight> lights;  // by descending worth, each above the horizon
    EnvironmentMap rest;            // the picture without them, nowhere negative
};

// Returns at most `most` lights, 1 <= most <= kMaxSuns. They change continuously while lights fade, move, cross and
// meet. A disc that grows beyond some 15 degrees does not: it breaks into several for a while.
AreaLights findAreaLights(const EnvironmentMap& map, int most);

}  // namespace penumbra
