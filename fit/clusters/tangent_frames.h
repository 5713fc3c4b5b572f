#pragma once
// Tangents: smooth over the surface inside a cluster, and in time because the cluster joint's rotation carries them.
#include <vector>

#include "fit/clusters/vertex_clusters.h"

namespace penumbra {

// A unit tangent per vertex, orthogonal to its rest normal. Per cluster the field of least turning out of these is
// taken: the cluster's principal axes, each projected on the tangent planes (singular where a normal lies along the
// axis: good on limbs); and for each of the axes' six ends and the mean normal as a pole, the tangent at the pole
// carried to every normal by the smallest rotation (singular only opposite the pole: good on caps and patches).
// "Turning" is the sum over edges of the fourth power of neighbourAngle: close to the worst edge, yet no single folded
// edge decides.
std::vector<Vec3> restTangents(const Mesh& mesh, const std::vector<Vec3>& rest_normals, const VertexClusters& clusters,
                               int threads);

// Angle in radians between tangent b and tangent a carried from normal a to normal b by the smallest rotation.
double neighbourAngle(Vec3 normal_a, Vec3 tangent_a, Vec3 normal_b, Vec3 tangent_b);

// normalised(R t0 - N (N . R t0)); where that vanishes, the projection of the coordinate axis least along N.
Vec3 carriedTangent(Vec3 normal, const Mat3& rotation, Vec3 rest_tangent);

// Columns t, n x t, n: takes local to model directions.
Mat3 localFrame(Vec3 normal, Vec3 tangent);

}  // namespace penumbra
