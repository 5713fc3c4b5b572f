#pragma once
// A material whose parameter may change over a range, as ggx:alpha=0.1..0.6. Tables of it are made at some steps and
// interpolated between them (fit/reflectance/fit_steps.h).
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "sh/brdf/brdf_sum.h"

namespace penumbra {

constexpr std::size_t kMaxBrdfSteps = 33;  // tables of one material

struct BrdfRange {
    std::string name = {};      // canonical: that of the sum, with the range
    BrdfSum sum;                // the parameter is in the middle of its range
    std::uint8_t terms = 1;     // bit i: term i has the parameter; of a sum often one, of principled two
    std::size_t parameter = 0;  // index into parametersOf() of the model of each of these
    double least = 0, most = 1;
};

// Parses "NAME:key=LEAST..MOST[,key=value,...]", also as a term of a sum. Of principled the roughness may have a range.
// Returns nothing for a text without a range. Throws std::invalid_argument with one sentence that names the key, its
// range and the value.
std::optional<BrdfRange> parseBrdfRange(std::string_view text);

// Returns the sum with the parameter set to `value`. Its name is that of the middle.
BrdfSum sumAt(const BrdfRange& range, double value);

}  // namespace penumbra
