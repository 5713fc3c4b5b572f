#pragma once
// A material as a sum of analytic models, as lambert:color=0.2+ggx:alpha=0.1, or as principled
// (sh/brdf/principled.h), which is such a sum. Its parts keep their own colours.
#include <string>
#include <string_view>
#include <vector>

#include "sh/brdf/brdf.h"
#include "sh/brdf/brdf_lobe.h"

namespace penumbra {

struct BrdfSum {
    std::string name;             // canonical: parseBrdfSum(name) is the same sum
    std::vector<BrdfSpec> terms;  // 1..kMaxBrdfLobes
    Vec3d emission{};             // radiance that the surface sends out by itself
};

// Splits "TERM+TERM" at every '+' that a name follows, so that "1e+5" stays whole.
std::vector<std::string_view> splitTerms(std::string_view text);

// Parses a sum of one model or several. Throws std::invalid_argument with one sentence as parseBrdf() does, also where
// there are too many terms, or where a model that takes light in its own way (phong-live, ggx-live, mirror, membrane)
// is in a sum.
BrdfSum parseBrdfSum(std::string_view text);

// One lobe a term, whose sum is exact.
std::vector<BrdfLobe> lobesOf(const BrdfSum& sum);
// The sum of all terms, without the emission. Its symmetry is that of the term with the least.
RgbBrdf sumBrdf(const BrdfSum& sum);

}  // namespace penumbra
