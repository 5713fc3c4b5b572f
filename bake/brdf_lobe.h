#pragma once
// Where a BRDF is large, fitted to its values: what importance sampling needs of any material, analytic or measured.
#include "sh/brdf.h"

namespace penumbra {

// A point of the unit square.
struct UnitSquare {
    double u, v;
};

// Directions wi for a view wo, local frame, densities per steradian: (r.wi)^x around the mirror direction r, or
// mirrored about half vectors of a GGX distribution with the roughness x, y along the tangent and the bitangent.
struct BrdfLobe {
    enum class Kind { kNone, kPower, kHalfVector } kind = Kind::kNone;
    double x = 0, y = 0;
    double share = 0;  // of the samples of the BRDF, below 1; the rest is cosine-weighted
};

Vec3d sampleCosine(UnitSquare s);
double cosineDensity(Vec3d wi);
Vec3d sampleLobe(const BrdfLobe& lobe, Vec3d wo, UnitSquare s);  // may be below the horizon
double lobeDensity(const BrdfLobe& lobe, Vec3d wo, Vec3d wi);

// Point i of n of the Hammersley set, shifted around the square by an offset of its own for each seed (Cranley and
// Patterson 1976).
UnitSquare stratified(int i, int n, std::uint64_t seed);

// Of a fixed family of lobes and shares, the one whose samples give the least variance of the albedo, over a few views;
// kNone where none is better than the cosine.
BrdfLobe fitLobe(const RgbBrdf& brdf);

}  // namespace penumbra
