#pragma once
// Lights to SH. Window, lobes and provenance are left to the caller.
#include <span>

#include "fit/light/light_window.h"
#include "formats/image/environment_map.h"
#include "formats/stage/light_file.h"
#include "sh/analytic_light.h"

namespace penumbra {

// The projection of a picture (formats/image/project_map.h). 1 <= order <= kMaxOrder. The light is named after the file
// `name`.
LightFile fitLight(const EnvironmentMap& map, const std::string& name, int order, int threads);
// The sum of analytic lights. The residual of a directional light is 1: a delta has no SH.
LightFile fitLight(std::span<const AnalyticLight> lights, const std::string& name, int order);

// A pixel that shines alone, every neighbour less than a tenth of its luminance; or a spot of few pixels with an edge:
// the 5 x 5 pixels around the brightest have at most the light of 6 like it, and none of the next ring has 0.2% of its
// luminance. With 5% of the picture's luminous flux or more. Lenses do not make such pictures, they scatter light
// around a sun (2% of its luminance three pixels away in every one of 26 measured pictures with a spot that strong):
// fireflies of renderers and suns set by hand are like that, also after resampling.
struct HotPixel {
    int x = 0, y = 0;
    double share = 0;   // of the flux; 0: there is none
    bool alone = true;  // else a spot, x and y its brightest pixel
};
HotPixel findHotPixel(const EnvironmentMap& map);

// Windows light.sh and puts residual and window right. Before lobes are fitted. kAuto is kAlways with a hot pixel,
// whose ringing is no part of the light, else kNone: of real pictures the projection is best, and its ringing is
// reported.
WindowReport windowFit(const WindowChoice& choice, const HotPixel& hot, LightFile& light);

}  // namespace penumbra
