#pragma once
// Sets a light beside its 3 zonal lobes (Nowrouzezahrai 2009, figure 10).
#include <string>
#include <vector>

#include "formats/stage/light_file.h"

namespace penumbra {

struct LightPair {
    std::string name;
    int order = 4;
    std::vector<double> sh;       // [order^2, 3] the light
    LightLobesFit greedy, joint;  // 3 lobes as the paper finds them, and as `penumbra-fit light` does
};
LightPair makeLightPair(const LightFile& light);

// Draws the light, the greedy lobes and the joint ones as lat-long maps in one SVG element. All have one exposure.
std::string lightPairSvg(const LightPair& pair);

}  // namespace penumbra
