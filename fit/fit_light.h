#pragma once
// Environment pictures to SH.
#include "formats/image_file.h"
#include "formats/light_file.h"

namespace penumbra {

// The projection of a lat-long picture whose pixels are constant patches of radiance: solid angles and the integrals of
// the basis over every pixel are exact, so that a uniform picture has no band above 0. 1 <= order <= kMaxOrder. `name`
// starts messages: InvalidInput unless the picture is twice as wide as high. Provenance is left to the caller.
LightFile fitLight(const Image& image, const std::string& name, int order);

}  // namespace penumbra
