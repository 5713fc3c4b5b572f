#pragma once
// Points and weights on the sphere, and fixed sets of directions.
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

struct WeightedDirection {
    Vec3d direction;
    double weight;  // steradians
};

struct WeightedNumber {
    double x, weight;
};
// n Gauss-Legendre nodes on (0, 1), ascending; the weights sum to 1.
std::vector<WeightedNumber> gaussInterval(int n);

// Gauss-Legendre nodes in z times uniform azimuths; exact for polynomials of degree < min(2 n_z, n_phi).
std::vector<WeightedDirection> gaussSphere(int n_z, int n_phi);
// The same on z in (0, 1). The weights sum to 2 pi.
std::vector<WeightedDirection> gaussHemisphere(int n_z, int n_phi);

// n directions of the spherical Fibonacci set over the whole sphere: z_i = 1 - (2i+1)/n, azimuth i pi (3 - sqrt 5).
std::vector<Vec3d> fibonacciSphere(int n);

// A permutation of `directions` along a Morton (Z-order) curve over the octahedral map, so that consecutive directions
// are neighbours: what coherent ray packets need. Stable and deterministic.
std::vector<Vec3d> mortonSorted(std::vector<Vec3d> directions);

}  // namespace penumbra
