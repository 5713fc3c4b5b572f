#pragma once
// Radiance from visibility, light and reflectance: L = l . (f x v), f = C y_even(omega_o) in the vertex' local frame,
// the product exact (docs/formulas.md section 3).
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/asset_file.h"
#include "player/runtime/shade_kernel.h"

namespace penumbra {

// What per-vertex shading needs of one material, light and convention: tables made once when one of them changes. Keeps
// no reference to its arguments.
class VertexShader {
public:
    VertexShader(const Convention& convention, int stride, const MaterialView& material, const LightView& light);

    // The fastest path of this processor unless this is called: tests go through all of shadePaths().
    void usePath(const ShadePath& path) { path_ = path; }

    // Radiance towards `eye` of vertices [begin, end): arrays are [V], numbers [V * stride], radiance [V]. Not clamped.
    // A vertex seen from behind its normal gets the radiance of the view direction mirrored at its tangent plane.
    // Allocates nothing.
    void shade(std::size_t begin, std::size_t end, std::span<const Vec3> positions, std::span<const Vec3> normals,
               std::span<const Vec3> tangents, std::span<const float> numbers, Vec3 eye,
               std::span<Vec3> radiance) const;

private:
    std::vector<SliceTerm> slices_[3];
    std::vector<ProductRow> rows_;
    std::vector<ProductTerm> products_;
    std::vector<Vec3> axes_;
    std::vector<Vec3> lobes_;  // [axis, light order]
    std::vector<float> basis_a_, basis_b_;
    Convention convention_;
    int stride_ = 0, view_order_ = 0, slice_order_ = 0, light_order_ = 0, channels_ = 1;
    ShadePath path_;

    void addSlices(const MaterialView& material);
    void addProduct();
    void addLobes(const MaterialView& material, const LightView& light);
    ShadeTables tables() const;
};

// E, cosine-weighted visibility / pi, of vertices [begin, end); 1 = unshadowed. numbers: [V * stride], e: [V].
void ambient(const Convention& convention, int stride, std::size_t begin, std::size_t end,
             std::span<const float> numbers, std::span<float> e);

// Truth moments (model frame) of frame `frame` of `truth` as numbers of `convention` (order <= the truth's) in the
// local frames of the model's vertices [begin, end); shading_point is the model's and < the truth's V. Arrays are [V],
// numbers [V * stride]; padding is set to 0.
void numbersFromTruth(const AssetView& truth, std::size_t frame, const Convention& convention, int stride,
                      std::size_t begin, std::size_t end, std::span<const std::uint32_t> shading_point,
                      std::span<const Vec3> normals, std::span<const Vec3> tangents, std::span<float> numbers);

// Moments (model frame, at least convention.order^2) of one vertex as numbers in the frame (normal, tangent).
void numbersFromMoments(const Convention& convention, std::span<const float> moments, Vec3 normal, Vec3 tangent,
                        std::span<float> numbers);

// The rows of the rotation are tangent, normal x tangent, normal: local = Q model.
Mat3 localFrame(Vec3 normal, Vec3 tangent);

}  // namespace penumbra
