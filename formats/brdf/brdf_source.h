#pragma once
// Reads a material from where it comes from: an analytic model, or a file of measurements, fits or a table
// (formats/README.md). The fit and the brute-force pictures both read it here, so that they see the same material.
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sh/brdf/brdf.h"
#include "sh/brdf/brdf_lobe.h"
#include "sh/brdf/brdf_range.h"
#include "sh/brdf/membrane.h"

namespace penumbra {

// Exactly one of the first three members is set.
struct BrdfSource {
    std::string analytic = {};                 // NAME[:key=value,...], sums too, sh/brdf/brdf_sum.h
    std::filesystem::path merl = {};           // .binary of the MERL database
    std::filesystem::path table = {};          // scattered .brdf, fits .csv or our own table
    std::string material = {};                 // the row, for a file of fits
    const char* analytic_option = "analytic";  // name of the option behind `analytic`, for BadOption
    bool takes_ranges = false;                 // accepts a range for a parameter, such as alpha=0.1..0.6
    std::vector<std::filesystem::path> files() const;
};

// Reads a source from one word: an analytic model, or a file. FILE.binary is MERL, FILE:ROW a row of fits; others are
// tables.
BrdfSource brdfSource(const std::string& word);

struct BrdfReading {
    RgbBrdf brdf;  // named after the model, or after the file without its folder
    // Counts what a file has and what was done about its faults: samples; unmeasured (cells above the horizon that
    // were filled from their neighbours); clamped (negative values that became 0); outside_rec709 (channels of
    // samples that became 0, because their colour is more saturated than Rec.709 allows).
    std::map<std::string, double> figures;
    std::vector<BrdfLobe> lobes = {};
    std::optional<Membrane> membrane = {};  // set: `brdf` and `lobes` are a white Lambertian surface
    std::optional<BrdfRange> range = {};    // set: `brdf` and `lobes` are those of the middle of it
    Vec3d emission = {};                    // radiance of the surface itself; it is in none of these
};

// Reads the material. Throws UsageError for a source that makes no sense, IoError, and InvalidInput, which names file
// and field. The result is the same for any number of threads.
BrdfReading readBrdfSource(const BrdfSource& source, int threads);

}  // namespace penumbra
