#pragma once
// An isotropic BRDF as a table over Rusinkiewicz' (1998) angles: theta_h of the half vector from the normal, and
// theta_d, phi_d of wi in the half vector's frame. Reciprocity maps phi_d to phi_d + pi, and the mirror symmetry of
// an isotropic surface maps phi_d to -phi_d. So phi_d in [0, pi/2] covers everything.
#include <utility>
#include <vector>

#include "sh/brdf/brdf.h"

namespace penumbra {

struct HalfDifference {
    double theta_h = 0, theta_d = 0, phi_d = 0;  // radians, each 0..pi/2
};
HalfDifference halfDifference(Vec3d wi, Vec3d wo);
// Returns a pair (wi, wo) that has these angles, with the half vector at azimuth 0. Either may be below the horizon.
std::pair<Vec3d, Vec3d> directionsOf(const HalfDifference& angles);

// Cells are [theta_h, theta_d, phi_d] with the last index fastest. Of n cells along an angle, cell k has its center
// at (k + 1/2)/n of sqrt(theta_h / (pi/2)), theta_d / (pi/2) or phi_d / (pi/2).
struct HalfDifferenceTable {
    int theta_h = 0, theta_d = 0, phi_d = 0;
    std::vector<Vec3> values;

    HalfDifference center(std::size_t cell) const;
};

// Interpolates linearly between centers, and is constant beyond the outermost. 0 where a direction is at or below the
// horizon.
RgbBrdf interpolated(std::string name, HalfDifferenceTable table);

}  // namespace penumbra
