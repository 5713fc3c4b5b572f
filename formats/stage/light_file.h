#pragma once
// e.light.h5: an environment light as SH (HDF5, format "penumbra.light"). It is radiance in linear
// Rec.709, in the model frame.
#include <filesystem>
#include <string>
#include <vector>

#include "formats/common/file_format.h"
#include "formats/common/light_picture.h"
#include "formats/common/provenance.h"
#include "sh/light/dominant_light.h"
#include "sh/vec3.h"

namespace penumbra {

constexpr FileFormat kLightFormat{"penumbra.light", 1};
constexpr int kMaxFileLobes = 15;  // lobes of a file: 2n - 1 fixed lobes are exact, n <= 8

// The light as a sum of zonal lobes: light_lm = sum_d sqrt(4pi/(2l+1)) z_dl y_lm(direction_d) (sh/zonal.h).
struct LightLobesFit {
    std::string mode;                  // "greedy", "joint" or "fixed"; empty: no lobes
    std::vector<Vec3d> directions;     // [D] unit, model frame
    std::vector<double> coefficients;  // [D, n, 3] z_l of each channel
    double residual = 0;               // |sh - lobes| / |sh|, over all coefficients and channels
    double irradiance_error = 0;       // such a relative error of irradiance over all normals
};

struct LightFile {
    std::string name;
    int order = 4;
    std::vector<double> sh;      // [n^2, 3]
    double residual = 0;         // relative L2 error of the SH against the light, over the sphere
    std::vector<double> window;  // [n] factors that the bands have been multiplied by; empty: none
    LightLobesFit lobes;
    std::vector<SunD> suns;  // at most kMaxSuns; sh is the whole light, with them
    std::string factor;      // how they were found: "hand-over", "paper" or "exact"; empty: the light is not factored
    LightPicture picture;
    Provenance provenance;
};

void writeLight(const std::filesystem::path& path, const LightFile& light);
LightFile readLight(const std::filesystem::path& path);  // throws IoError and InvalidInput

}  // namespace penumbra
