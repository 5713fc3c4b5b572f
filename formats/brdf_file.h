#pragma once
// m.brdf.h5: a material as reflectance slices (HDF5, format "penumbra.brdf", version 1).
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "formats/provenance.h"

namespace penumbra {

constexpr int kBrdfVersion = 1;

struct BrdfFile {
    std::string name;     // "ggx:alpha=0.3,f0=0.9"
    int slice_order = 5;  // J
    int view_order = 5;
    std::vector<double> slices;            // [J^2, E, 3], colour included
    std::vector<int> even_index;           // [E], SH index of each view function
    std::map<std::string, double> errors;  // measured at fit time: "fit" (relative, cos-weighted), "albedo", ...
    Provenance provenance;
};

void writeBrdf(const std::filesystem::path& path, const BrdfFile& brdf);
BrdfFile readBrdf(const std::filesystem::path& path);  // IoError, InvalidInput

}  // namespace penumbra
