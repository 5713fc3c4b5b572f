#pragma once
// Projects lights on SH. Windows, lobes and provenance are left to the caller.
#include <span>

#include "fit/light/light_window.h"
#include "formats/image/project_map.h"
#include "formats/stage/light_file.h"
#include "sh/light/analytic_light.h"

namespace penumbra {

// Returns the projection of a picture (formats/image/project_map.h), 1 <= order <= kMaxOrder. The light gets the file
// name of `name`.
LightFile fitLight(const EnvironmentMap& map, const std::string& name, int order, int threads);
LightFile fitLight(MapProjection projection, const std::string& name, int order);
// Returns the sum of analytic lights. A directional light has the residual 1: a delta has infinite energy, of which SH
// hold a vanishing part.
LightFile fitLight(std::span<const AnalyticLight> lights, const std::string& name, int order);

// The light of a picture that no lens could have made, if it holds 5% or more of the picture's luminous flux. There are
// two kinds. A pixel may shine alone: every neighbour has less than a tenth of its luminance. Or a small spot has a
// sharp edge: the 5 x 5 pixels around the brightest have at most the light of 6 pixels like it, and no pixel of the
// next ring has 0.2% of its luminance.
//
// Lenses scatter light around a sun: three pixels away there is still 2% of its luminance in every one of 26 measured
// pictures with a spot that strong. Fireflies of renderers and suns set by hand look like a hot pixel, also after
// resampling.
struct HotPixel {
    int x = 0, y = 0;
    double share = 0;   // share of the flux; 0 if there is none
    bool alone = true;  // false for a spot, whose brightest pixel is x, y
};
HotPixel findHotPixel(const EnvironmentMap& map);

// Windows light.sh and corrects residual and window. This comes before lobes are fitted. With a hot pixel kAuto means
// kAlways, because its ringing is no part of the light. Otherwise it means kNone: the projection is the best fit of a
// real picture, and its ringing is only reported.
WindowReport windowFit(const WindowChoice& choice, const HotPixel& hot, LightFile& light);

}  // namespace penumbra
