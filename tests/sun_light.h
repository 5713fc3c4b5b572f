#pragma once
// Lights with a sun, for tests of shadows.
#include <span>

#include "formats/stage/light_file.h"
#include "sh/light/dominant_light.h"

namespace penumbra::synthetic {

// Adds a sun, whose SH the light has, too, as a light that was factored without an error.
inline LightFile withSun(LightFile light, const SunD& sun) {
    SunD negative = sun;
    negative.irradiance *= -1;
    subtractSuns(std::span(&negative, 1), {}, light.sh);
    light.suns = {sun};
    light.factor = "exact";
    return light;
}

}  // namespace penumbra::synthetic
