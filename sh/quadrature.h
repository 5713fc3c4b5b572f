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
// Returns n Gauss-Legendre nodes on (0, 1) in ascending order. The weights sum to 1.
std::vector<WeightedNumber> gaussInterval(int n);

// Returns Gauss-Legendre nodes in z times uniform azimuths, over the whole sphere. It is exact for polynomials of
// degree < min(2 n_z, n_phi).
std::vector<WeightedDirection> gaussSphere(int n_z, int n_phi);
// Returns such a grid on z in (0, 1). The weights sum to 2 pi.
std::vector<WeightedDirection> gaussHemisphere(int n_z, int n_phi);

// Returns n directions of the spherical Fibonacci set over the whole sphere: z_i = 1 - (2i+1)/n, azimuth i pi (3 - sqrt
// 5).
std::vector<Vec3d> fibonacciSphere(int n);

// Returns the directions along a Morton (Z-order) curve over the octahedral map. Consecutive directions are then
// neighbours, which coherent ray packets need. The order is stable and deterministic.
std::vector<Vec3d> mortonSorted(std::vector<Vec3d> directions);

}  // namespace penumbra
