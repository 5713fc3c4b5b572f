#pragma once
// e.light.h5: an environment light as SH (HDF5, format "penumbra.light", version 1). Radiance, linear Rec.709, model
// frame.
#include <filesystem>
#include <string>
#include <vector>

#include "formats/provenance.h"
#include "sh/vec3.h"

namespace penumbra {

constexpr int kLightVersion = 1;

struct LightFile {
    std::string name;
    int order = 4;
    std::vector<double> sh;  // [n^2, 3]
    double residual = 0;     // relative L2 error of the SH against the image, over the sphere
    Provenance provenance;
};

void writeLight(const std::filesystem::path& path, const LightFile& light);
LightFile readLight(const std::filesystem::path& path);  // IoError, InvalidInput

}  // namespace penumbra
