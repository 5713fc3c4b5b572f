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

    // Computes the radiance towards `eye` of vertices [begin, end), not clamped. Arrays are [V], numbers [V *
    // stride], radiance [V]. A vertex seen from behind its normal gets the radiance of the view direction mirrored at
    // its tangent plane. Allocates nothing.
    void shade(std::size_t begin, std::size_t end, std::span<const Vec3> positions, std::span<const Vec3> normals,
               std::span<const Vec3> tangents, std::span<const float> numbers, Vec3 eye,
               std::span<Vec3> radiance) const;

private:
    MaterialTables material_;
    LightTables light_;
    int stride_, size_;
    ShadePath path_;
};

// Computes E, cosine-weighted visibility / pi, of vertices [begin, end); 1 = unshadowed. numbers: [V * stride], e:
// [V].
void ambient(const Convention& convention, int stride, std::size_t begin, std::size_t end,
             std::span<const float> numbers, std::span<float> e);

// The same of an asset's numbers. Those of an asset of transfer are its transfer.
void ambient(const AssetView& asset, std::size_t begin, std::size_t end, std::span<const float> numbers,
             std::span<float> e);

// Turns the true moments (model frame) of frame `frame` of `truth` into numbers of `convention` (order <= the
// truth's) in the local frames of the model's vertices [begin, end). shading_point is the model's and < the truth's
// V. Arrays are [V], numbers [V * stride]; padding is set to 0.
void numbersFromTruth(const AssetView& truth, std::size_t frame, const Convention& convention, int stride,
                      std::size_t begin, std::size_t end, std::span<const std::uint32_t> shading_point,
                      std::span<const Vec3> normals, std::span<const Vec3> tangents, std::span<float> numbers);

// Copies the true transfer of frame `frame` of `truth` as numbers of an asset of transfer of order n, [V * stride]; of
// moments of visibility, whose order is n + 1 or more, it makes transfer. Padding is set to 0.
void transferFromTruth(const AssetView& truth, std::size_t frame, int order, int stride, std::size_t begin,
                       std::size_t end, std::span<const Vec3> normals, std::span<float> numbers);

// Turns moments (model frame, at least convention.order^2) of one vertex into numbers in the frame (normal, tangent).
void numbersFromMoments(const Convention& convention, std::span<const float> moments, Vec3 normal, Vec3 tangent,
                        std::span<float> numbers);

// Returns the numbers of a vertex that nothing hides anything from, [convention.size()].
std::vector<float> freeSight(const Convention& convention);

// Returns the rotation Q with local = Q model. Its rows are tangent, normal x tangent, normal.
Mat3 toLocalFrame(Vec3 normal, Vec3 tangent);

}  // namespace penumbra
