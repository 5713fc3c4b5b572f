#pragma once
// Chooses tangents that are smooth over the surface. They are also smooth in time, because the rotation of the
// cluster's joint carries them.
#include <vector>

#include "fit/clusters/vertex_clusters.h"

namespace penumbra {

// Returns a unit tangent for each vertex, orthogonal to its rest normal. Each cluster takes the field that turns least
// among these candidates:
//
// - Each of the cluster's principal axes, projected on the tangent planes. This is singular where a normal lies along
//   the axis; it is good on limbs.
// - For each of the axes' six ends and for the mean normal as a pole, the tangent at the pole, carried to every normal
//   by the smallest rotation. This is singular only opposite the pole; it is good on caps and patches.
//
// "Turning" is the sum over edges of the fourth power of neighbourAngle(). It is dominated by the worst edges, yet no
// single folded edge decides alone.
std::vector<Vec3> restTangents(const Mesh& mesh, const std::vector<Vec3>& rest_normals, const VertexClusters& clusters,
                               int threads);

// Returns the angle in radians between tangent b and tangent a after the smallest rotation from normal a to normal b.
double neighbourAngle(Vec3 normal_a, Vec3 tangent_a, Vec3 normal_b, Vec3 tangent_b);

// Returns normalised(R t0 - N (N . R t0)). Where that vanishes, it projects the coordinate axis that is least along N.
Vec3 carriedTangent(Vec3 normal, const Mat3& rotation, Vec3 rest_tangent);

// Returns the matrix with columns t, n x t, n, which takes local to model directions.
Mat3 localFrame(Vec3 normal, Vec3 tangent);

}  // namespace penumbra
