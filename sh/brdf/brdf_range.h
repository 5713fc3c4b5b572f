#pragma once
// A material whose parameter may change over a range, as ggx:alpha=0.1..0.6. Tables of it are made at some steps and
// interpolated between them (fit/reflectance/fit_steps.h).
#include <cstddef>
#include <optional>
#include <string_view>

#include "sh/brdf/brdf.h"

namespace penumbra {

constexpr std::size_t kMaxBrdfSteps = 33;  // tables of one material

struct BrdfRange {
    BrdfSpec spec;              // the parameter is in the middle of its range
    std::size_t parameter = 0;  // index into parametersOf(modelOf(spec))
    double least = 0, most = 1;
};

// Parses "NAME:key=LEAST..MOST[,key=value,...]". Returns nothing for a text without a range. Throws
// std::invalid_argument with one sentence that names the key, its range and the value.
std::optional<BrdfRange> parseBrdfRange(std::string_view text);

// Returns the spec with its parameter set to `value`.
BrdfSpec specAt(const BrdfRange& range, double value);

// Returns as BrdfSpec's toString() does, with the range.
std::string toString(const BrdfRange& range);

}  // namespace penumbra
