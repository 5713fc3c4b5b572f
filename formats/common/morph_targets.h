#pragma once
// Morph targets (blend shapes) of a mesh. Their weights are numbers of the pose: the last M of a frame's inputs, which
// have the names of the targets (formats/README.md, /mesh/morphs).
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sh/morph_rows.h"
#include "sh/vec3.h"

namespace penumbra {

// M targets with R rows in all. A row is a vertex that a target changes: few targets of a face move more than a part of
// it, so that only these are kept.
struct MorphTargets {
    std::vector<std::string> names;                  // [M], unique
    std::vector<float> rest_weights;                 // [M], the weights of the rest pose
    std::vector<std::uint32_t> first;                // [M + 1] target m has the rows first[m] <= r < first[m + 1]
    std::vector<std::uint32_t> vertices;             // [R], ascending within a target
    std::vector<Vec3> positions = {}, normals = {};  // [R], added at weight 1

    std::size_t count() const { return names.size(); }
    bool empty() const { return names.empty(); }
    MorphRows rowsOf(std::size_t target) const {
        const std::size_t begin = first[target], size = first[target + 1] - begin;
        return {std::span(vertices).subspan(begin, size), std::span(positions).subspan(begin, size),
                std::span(normals).subspan(begin, size)};
    }
    bool operator==(const MorphTargets&) const = default;
};

// The surface that bones move.
struct RestShape {
    std::vector<Vec3> positions, normals;  // [V]
};
// Returns the rest positions and normals with the weights [M] of the targets.
RestShape restShape(const MorphTargets& morphs, RestShape rest, std::span<const float> weights);

// Returns the targets of other vertices: number i of the result is vertex vertices[i] of the old ones.
MorphTargets selectVertices(const MorphTargets& morphs, std::span<const std::uint32_t> vertices);
// Returns the targets of a mesh of `fronts` vertices that now also has their backs, with the opposite normals.
MorphTargets withBacks(const MorphTargets& morphs, std::size_t fronts);

// Returns the weights in a pose of P numbers, its last M.
inline std::span<const float> morphWeights(const MorphTargets& morphs, std::span<const float> pose) {
    return pose.last(morphs.count());
}

// Returns the weights in the bones of a pose: those of the joints that stand for the last M of `inputs` inputs. Fit and
// run time both take them from there, so that they have the same bits. Joint is InputJoint or InputJointView.
template <class Joint>
std::vector<float> morphWeights(const std::vector<Joint>& joints, std::span<const Affine> bones, std::size_t inputs,
                                std::size_t morphs) {
    std::vector<float> weights(morphs);
    for (const Joint& joint : joints)
        if (joint.columns == 1 && joint.column + morphs >= inputs)
            weights[joint.column + morphs - inputs] = joint.offset + bones[std::size_t(joint.joint)].m[3] / joint.scale;
    return weights;
}

}  // namespace penumbra
