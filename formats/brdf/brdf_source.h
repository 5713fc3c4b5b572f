#pragma once
// Where a material comes from: an analytic model or a file of measurements, fits or a table (README.md). The fit and
// the brute-force pictures read it here, so that both see the same material.
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "sh/brdf.h"

namespace penumbra {

// Exactly one of the first three is set.
struct BrdfSource {
    std::string analytic = {};                   // NAME[:key=value,...], sh/brdf.h
    std::filesystem::path merl = {};             // .binary of the MERL database
    std::filesystem::path table = {};            // scattered .brdf, fits .csv or our own table
    std::string material = {};                   // which row of a file of fits
    const char* analytic_option = "--analytic";  // what the command line calls the first, for messages
    std::vector<std::filesystem::path> files() const;
};

// A source in one word: an analytic model, or a file: FILE.binary is MERL, others are tables, FILE:ROW a row of fits.
BrdfSource brdfSource(const std::string& word);

struct BrdfReading {
    RgbBrdf brdf;  // named after the model, or the file without its folder
    // Counts of what a file has and what was done about its faults: samples; unmeasured (cells above the horizon that
    // were filled from their neighbours); clamped (negative values set to 0); outside_rec709 (channels of samples set
    // to 0, whose colour is more saturated than Rec.709 has).
    std::map<std::string, double> figures;
};

// UsageError for a source that makes no sense, IoError, InvalidInput (names file and field). Same result for any number
// of threads.
BrdfReading readBrdfSource(const BrdfSource& source, int threads);

}  // namespace penumbra
