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

// Memory that the calls below use on the way.
struct DeformationScratch {
    std::vector<PartSums> parts;  // [J]
    std::vector<Vec3d> normals;   // [Vs]
    std::vector<float> angles;    // [E]
};

class Deformation {
public:
    // The asset's model must be deforming, and the asset must outlive this object.
    explicit Deformation(const AssetView& asset);

    std::span<const Vec3> rest() const { return rest_; }  // [Vs]
    std::vector<float> restInputs() const;                // [X], the inputs with which no input joint moves
    DeformationScratch scratch() const;                   // scratch memory of the right sizes

    // `points`: [Vs] in the model frame; `inputs`: [X]. None of these functions allocates.
    void normals(std::span<const Vec3> points, DeformationScratch& scratch, std::span<Vec3> normals) const;
    void bones(std::span<const Vec3> points, std::span<const float> inputs, DeformationScratch& scratch,
               std::span<Affine> bones) const;
    // Computes the pose of kDihedrals, [P].
    void pose(std::span<const Vec3> points, std::span<const float> inputs, DeformationScratch& scratch,
              std::span<float> pose) const;

private:
    const AssetView* asset_;
    std::vector<Vec3> rest_;
    std::vector<std::uint16_t> part_of_point_;
    std::vector<std::uint32_t> triangles_;  // [3Ts] indices of shading points
    std::vector<InnerEdge> edges_;          // [E], only for kDihedrals
    std::vector<float> pose_basis_;         // [P - X, E]
};

}  // namespace penumbra
