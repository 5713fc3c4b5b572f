#pragma once
// Computes radiance from visibility, light and reflectance in the vertex' local frame: L = l . (f x v), f = C
// y_even(omega_o) with the exact product, or eq 11 of Nowrouzezahrai 2009 (docs/formulas.md, section 3).
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"
#include "runtime/shade/light_tables.h"
#include "runtime/shade/material_tables.h"
#include "runtime/shade/vertex_frames.h"

namespace penumbra {

struct ShadingChoice {
    Reflectance reflectance = Reflectance::kSlices;
    LightForm light_form = LightForm::kRotation;
    bool operator==(const ShadingChoice&) const = default;
};

// Shades vertices that all have one material under one light. ShadingSet (shading_set.h) switches both while it runs.
// Keeps no reference to its arguments.
class VertexShader {
public:
    // Needs hasReflectance(material, choice.reflectance) and hasForm(light, choice.light_form).
    VertexShader(const Convention& convention, int stride, const MaterialView& material, const LightView& light,
                 const ShadingChoice& choice = {});

    // Replaces the fastest path of this processor, which is the default. Tests go through all of shadePaths().
    void usePath(const ShadePath& path) { path_ = path; }
    void setLightRotation(const Mat3& rotation) { light_.setRotation(rotation); }  // LightTables

    // Computes the radiance [V] of `vertices` towards `eye`, not clamped. A vertex seen from behind its normal gets the
    // radiance of the view direction mirrored at its tangent plane. Allocates nothing.
    void shade(const VertexFrames& vertices, Vec3 eye, std::span<Vec3> radiance) const;

private:
    MaterialTables material_;
    LightTables light_;
    int stride_, size_;
    ShadePath path_;
};

// Computes E [V], cosine-weighted visibility / pi; 1 = unshadowed. coefficients: [V * stride].
void ambient(const Convention& convention, int stride, std::span<const float> coefficients, std::span<float> e);

// The same of an asset's coefficients. Those of an asset of transfer are its transfer.
void ambient(const AssetView& asset, std::span<const float> coefficients, std::span<float> e);

// Writes frame `frame` of `truth` (findTruthFrame() tells which one) as coefficients [V * stride] of the asset's model,
// in the local frames of `vertices`. Moments of visibility become what the model stands for, visibility or transfer;
// transfer is copied. Padding is set to 0.
void coefficientsFromTruth(const AssetView& truth, std::size_t frame, const AssetView& asset,
                           const VertexFrames& vertices, std::span<float> coefficients);

// Turns moments (model frame, at least convention.order^2) of one vertex into coefficients in the frame (normal,
// tangent).
void coefficientsFromMoments(const Convention& convention, std::span<const float> moments, Vec3 normal, Vec3 tangent,
                             std::span<float> coefficients);

// Returns the coefficients of a vertex that nothing hides anything from, [convention.size()].
std::vector<float> freeSight(const Convention& convention);

// Returns the rotation Q with local = Q model. Its rows are tangent, normal x tangent, normal.
Mat3 toLocalFrame(Vec3 normal, Vec3 tangent);

}  // namespace penumbra
