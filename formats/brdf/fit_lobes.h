#pragma once
// Fits lobes to measured values of a BRDF: a Lambert lobe and one or two isotropic GGX lobes with colours of their own.
#include <span>
#include <vector>

#include "sh/brdf/brdf_lobe.h"

namespace penumbra {

struct BrdfSample {
    Vec3d wi, wo;  // above the horizon
    Vec3d rgb;     // f without the cosine, >= 0
};

// Returns one to three lobes whose sum is near the samples in the norm sum over samples and channels of cos_i cos_o
// (cbrt(fit + e) - cbrt(rgb + e))^2, where e is a tenth of the channel's median. Cube roots keep the peak of a lobe
// from deciding alone (compare Ngan, Durand and Matusik 2005, section 4, and Low et al. 2012, section 5). Samples that
// are all black give a black Lambert lobe. Of more than 4096 samples it reads 4096, evenly spread over their order.
std::vector<BrdfLobe> fitLobes(std::span<const BrdfSample> samples);

// Returns samples of a BRDF to fit lobes to, dense where half vectors are near the normal.
std::vector<BrdfSample> samplesOf(const RgbBrdf& brdf);

// The angle from the normal at which the GGX distribution of half vectors falls to a half, in radians; pi / 2 where it
// never does.
double halfWidth(const BrdfLobe& ggx);

}  // namespace penumbra
