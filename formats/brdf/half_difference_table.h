#pragma once
// An isotropic BRDF as a table over Rusinkiewicz' (1998) angles: theta_h of the half vector from the normal, and
// theta_d, phi_d of wi in the half vector's frame. Reciprocity is phi_d -> phi_d + pi and the mirror of an isotropic
// surface is phi_d -> -phi_d, so that phi_d in [0, pi/2] is everything.
#include <utility>
#include <vector>

#include "sh/brdf.h"

namespace penumbra {

struct HalfDifference {
    double theta_h = 0, theta_d = 0, phi_d = 0;  // radians, each 0..pi/2
};
HalfDifference halfDifference(Vec3d wi, Vec3d wo);
// A pair (wi, wo) that has these angles, the half vector at azimuth 0; either may be below the horizon.
std::pair<Vec3d, Vec3d> directionsOf(const HalfDifference& angles);

// Cells [theta_h, theta_d, phi_d], the last fastest; of n cells along an angle, k has its centre at (k + 1/2)/n of
// sqrt(theta_h / (pi/2)), theta_d / (pi/2) or phi_d / (pi/2).
struct HalfDifferenceTable {
    int theta_h = 0, theta_d = 0, phi_d = 0;
    std::vector<Vec3> values;

    HalfDifference centre(std::size_t cell) const;
};

// Linear between centres, constant beyond the outermost; 0 where a direction is at or below the horizon.
RgbBrdf interpolated(std::string name, HalfDifferenceTable table);

}  // namespace penumbra
