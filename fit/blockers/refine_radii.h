#pragma once
// Changes the radii of blockers until their silhouettes are like those of the mesh, not only as large.
#include <span>
#include <vector>

#include "fit/blockers/silhouette.h"
#include "formats/stage/blocker_file.h"

namespace penumbra {

// The poses that silhouettes are compared in.
struct SilhouettePoses {
    std::vector<std::vector<Affine>> bones;
    std::vector<std::vector<Vec3>> positions;  // positions of the mesh
};

struct RadiusRefinement {
    double before = 0, after = 0;  // rms over poses, views and bands of spheres - mesh, / the rms of the mesh
    int steps = 0;                 // steps that made it smaller
};

// Least squares over the logarithms of the radii; centers stay. What is compared is the silhouette in
// kSilhouetteBands bands of each view. A weak pull towards the radii of before keeps those that no band tells. The
// error never grows, and the result is the same for any number of threads.
RadiusRefinement refineRadii(std::span<const Triangle> triangles, const SilhouettePoses& poses,
                             std::span<const Vec3d> views, int threads, SphereBlockers& blockers);

}  // namespace penumbra
