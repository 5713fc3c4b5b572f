#pragma once
// Radiance from visibility, light and reflectance: L = l . (f x v), f = C y_even(omega_o) in the vertex' local frame,
// the product exact (formulas-core section 3b); the light is brought into the local frame by rotating t = f x v into
// the model frame.
#include <span>
#include <vector>

#include "formats/asset_file.h"
#include "sh/sh_product.h"

namespace penumbra {

// What per-vertex shading needs of one material, light and convention; made once when one of them changes.
class VertexShader {
public:
    VertexShader(const Convention& convention, int stride, const MaterialView& material, const LightView& light);

    // Radiance towards `eye` of vertices [begin, end): arrays are [V], numbers [V * stride], radiance [V]. Not clamped.
    // A vertex seen from behind its normal gets the radiance of the view direction mirrored at its tangent plane.
    void shade(std::size_t begin, std::size_t end, std::span<const Vec3> positions, std::span<const Vec3> normals,
               std::span<const Vec3> tangents, std::span<const float> numbers, Vec3 eye,
               std::span<Vec3> radiance) const;

private:
    Convention convention_;
    int stride_;
    MaterialView material_;
    LightView light_;
    std::vector<TripleProductEntry> product_;  // i: light, j: visibility number, k: slice
};

// E, cosine-weighted visibility / pi, of vertices [begin, end); 1 = unshadowed.
void ambient(const Convention& convention, int stride, std::size_t begin, std::size_t end,
             std::span<const float> numbers, std::span<float> e);

// Truth moments (model frame) of one frame as numbers of `convention` in the local frames. numbers: [V * stride].
void numbersFromTruth(const AssetView& truth, std::size_t frame, const Convention& convention, int stride,
                      std::span<const std::uint32_t> shading_point, std::span<const Vec3> normals,
                      std::span<const Vec3> tangents, std::span<float> numbers);

// The rows of the rotation are tangent, normal x tangent, normal: local = Q model.
Mat3 localFrame(Vec3 normal, Vec3 tangent);

}  // namespace penumbra
