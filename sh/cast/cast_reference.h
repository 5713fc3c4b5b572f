#pragma once
// Visibility past spheres by any of the papers' ways to multiply caps, for comparison. The fast way is
// castVisibility() (sh/cast/cast_visibility.h). These functions take one receiver at a time, in double precision.
#include <span>
#include <string>
#include <string_view>

#include "sh/cast/cast_visibility.h"
#include "sh/cast/log_visibility.h"

namespace penumbra {

// How the caps of spheres are multiplied. The default is what castVisibility() computes.
struct CastExponential {
    ExpOptions options;
    bool chain = false;  // productChain() instead of an exponential of logarithms
    bool isDefault() const { return !chain && options.method == ExpMethod::kHybPs2; }
};
constexpr int kMaxSeriesTerms = 20;  // limit of K in "ps-K"

// Reads "hyb-ps2", "hyb-ol", "ps-K" with K from 1 to kMaxSeriesTerms, "ol" or "chain". Throws std::invalid_argument
// with a sentence.
CastExponential parseCastExponential(std::string_view word);
std::string nameOf(const CastExponential& exponential);

// Writes the visibility past all `spheres` at `position`, over the whole sphere of directions and in the frame of both;
// out.size() == coefficientCount(order), `order` from kMinLogOrder to kMaxLogOrder. A sphere that fades is as much
// smaller as it counts less.
void castReference(const CastExponential& exponential, int order, std::span<const CasterSphere> spheres, Vec3 position,
                   const CastFade& fade, std::span<double> out);

// Writes what castMirrored() does.
void castMirroredReference(const CastExponential& exponential, std::span<const CasterSphere> spheres,
                           const CastPoints& points, const CastFade& fade, std::span<float> out);

}  // namespace penumbra
