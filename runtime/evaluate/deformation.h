#pragma once
// Computes from the vertices of a deforming mesh what its model reads: the motions of near-rigid parts, the joints
// that stand for inputs, the dihedral angles where the model asks for them, and normals. formats/stage/model_file.h
// has the rules. All arrays are of shading points, the Vs front vertices in the bake's order. So results have the
// same bits as in the fit.
#include <cstdint>
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"
#include "sh/dihedral_angles.h"
#include "sh/rigid_fit.h"

namespace penumbra {

// Returns the bone of a joint that stands for inputs; `inputs`: [X].
Affine inputBone(const AssetView& asset, const InputJointView& input, std::span<const float> inputs);

// The vertices of one pose, and what the model reads of them.
struct DeformedPose {
    std::vector<Vec3> points, normals;  // [Vs]
    std::vector<Affine> bones;          // [J]
    std::vector<float> pose;            // [P], only for kDihedrals
    // Memory that is used on the way.
    std::vector<PartSums> part_sums;  // [J]
    std::vector<Vec3d> normal_sums;   // [Vs]
    std::vector<float> angles;        // [E]
};

class Deformation {
public:
    // The asset's model must be deforming, and the asset must outlive this object.
    explicit Deformation(const AssetView& asset);

    std::span<const Vec3> rest() const { return rest_; }  // [Vs]
    std::vector<float> restInputs() const;                // [X], the inputs with which no input joint moves

    // Returns the points at rest, with their normals. Bones and pose are not known yet.
    DeformedPose atRest() const;
    // Computes the rest of `pose` from its points, which are in the model frame. `inputs`: [X]. Allocates nothing.
    void follow(std::span<const float> inputs, DeformedPose& pose) const;

private:
    const AssetView* asset_;
    std::vector<Vec3> rest_;
    std::vector<std::uint16_t> part_of_point_;
    std::vector<std::uint32_t> triangles_;  // [3Ts] indices of shading points
    std::vector<InnerEdge> edges_;          // [E], only for kDihedrals
    std::vector<float> pose_basis_;         // [P - X, E]

    void projectAngles(std::span<const float> inputs, DeformedPose& pose) const;
};

}  // namespace penumbra
