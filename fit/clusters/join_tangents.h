#pragma once
// Makes tangents that are smooth inside each cluster smooth across the borders of clusters, too.
#include <cstdint>
#include <span>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

// Changes the unit tangents of a mesh at rest, [V], each orthogonal to its unit normal. It works in two steps.
//
// 1. Turn all tangents of a cluster about their normals by one angle. This changes no difference inside the cluster.
//    The angles make the sum of the cosines of all jumps large: each cluster in turn takes the best angle for those of
//    its neighbours (the synchronisation of angles, Singer 2011, solved by coordinate ascent from a spanning tree).
// 2. Blend what is left, because no turn of whole clusters brings it to zero: kBlendSweeps times every tangent becomes
//    the direction of the sum of its neighbours' tangents and its own, each carried to its normal.
//
// A closed surface has places that no tangent field is smooth at (Poincare and Hopf); they stay.
void joinTangents(std::span<const Triangle> triangles, std::span<const Vec3> normals,
                  std::span<const std::uint32_t> cluster_of_vertex, std::vector<Vec3>& tangents);

}  // namespace penumbra
