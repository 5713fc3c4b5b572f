#pragma once
// Finds the feet of a character: the ends of limbs that stand on the ground.
#include <cstdint>
#include <span>
#include <vector>

#include "fit/blockers/surface_samples.h"

namespace penumbra {

struct FootOptions {
    double touch = 0.025;     // a point touches that is at most so far above the lowest one, in diagonals of the pose
    double least_time = 0.2;  // share of the poses in which each joint of a foot touches, at least
    double most_area = 0.15;  // share of the surface that a foot has at most: what crawls is not all foot
};

// Returns the joints that are feet: with all joints below it that own a point of `samples`, each touches the ground in
// enough poses, and no joint above it is such a one. Ascending. `bones` are the skinning matrices of all poses, one
// pose after the other. A point moves with its own joint alone.
std::vector<std::uint16_t> findFeet(const SurfaceSamples& samples, std::span<const std::int32_t> parents,
                                    std::span<const Affine> bones, const FootOptions& options = {});

// Returns, for each joint, the number of the foot that it belongs to, or -1.
std::vector<int> footOfJoint(std::span<const std::uint16_t> feet, std::span<const std::int32_t> parents);

}  // namespace penumbra
