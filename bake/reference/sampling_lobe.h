#pragma once
// Fits a lobe to a BRDF's values that tells where the BRDF is large. Importance sampling needs this of any material,
// analytic or measured ("Brute force" in section 3 of docs/formulas.md).
#include "sh/brdf/brdf.h"

namespace penumbra {

// A point of the unit square.
struct UnitSquare {
    double u, v;
};

// A distribution of directions wi for a view wo, in the local frame, with densities per steradian. kPower is (r.wi)^x
// around the mirror direction r. kHalfVector mirrors wo about half vectors of a GGX distribution with the roughness x
// along the tangent and y along the bitangent.
struct SamplingLobe {
    enum class Kind { kNone, kPower, kHalfVector } kind = Kind::kNone;
    double x = 0, y = 0;
    double share = 0;  // the lobe's share of the samples of the BRDF, below 1; the others are cosine-weighted
};

// Map a point of the unit square to a direction, and give the density of directions that are drawn so.
Vec3d sampleCosine(UnitSquare s);
double cosineDensity(Vec3d wi);
Vec3d sampleLobe(const SamplingLobe& lobe, Vec3d wo, UnitSquare s);  // the direction may be below the horizon
double lobeDensity(const SamplingLobe& lobe, Vec3d wo, Vec3d wi);

// Returns point i of n of the Hammersley set. Each seed shifts the set around the square by an offset of its own
// (Cranley and Patterson 1976).
UnitSquare stratified(int i, int n, std::uint64_t seed);

// Chooses from a fixed family of lobes and shares. The choice is the one whose samples give the least variance of the
// albedo over a few views, or kNone where none is better than the cosine.
SamplingLobe fitLobe(const RgbBrdf& brdf);

}  // namespace penumbra
