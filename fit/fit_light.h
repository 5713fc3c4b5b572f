#pragma once
// Environment pictures to SH.
#include "formats/environment_map.h"
#include "formats/light_file.h"

namespace penumbra {

// The projection of a picture (formats/project_map.h). 1 <= order <= kMaxOrder. The light is named after the file
// `name`; lobes and provenance are left to the caller.
LightFile fitLight(const EnvironmentMap& map, const std::string& name, int order, int threads);

}  // namespace penumbra
