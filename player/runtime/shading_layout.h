#pragma once
// What one program for all materials and lights of an asset reads, and where: the union of the materials' entries that
// are not zero, for lights padded to the highest order. Switching then changes numbers in buffers only.
#include <vector>

#include "player/runtime/shading_set.h"

namespace penumbra {

struct ShadingLayout {
    Convention convention;
    ShadingChoice choice;
    int channels = 1;     // 3 when any material has 3
    int view_order = 1;   // highest of the materials
    int light_order = 1;  // highest of the lights
    int lobe_count = 0;   // most lobes of a light; 0 with LightForm::kRotation

    // f_k = sum over e of A_ke y_e(omega_o), sorted by (k, e)
    struct View {
        std::uint16_t k, e;
        auto operator<=>(const View&) const = default;
    };
    std::vector<View> views;
    // t_i = sum over j of v_j sum over k of B_ijk f_k; the value is Gamma of slices, and of operators unused: theirs is
    // a material's.
    std::vector<ProductEntry> products;

    // Numbers of one material after its colour: the views and, of operators, the products.
    std::size_t entryCount() const;
    // RGBA32F texels of one material: colour; then four entries a texel, or one with three channels.
    std::size_t materialTexels() const;
    // vec4 of the uniform block "Light": lobe count; then axes and [lobe, band] weights, or SH coefficients.
    std::size_t lightTexels() const;
};

ShadingLayout shadingLayout(const ShadingSet& set);

// [material, materialTexels(), 4]; zeros for a material that cannot be on.
std::vector<float> materialData(const ShadingLayout& layout, const ShadingSet& set);

// The light that is on, as it is turned: [lightTexels(), 4], every number written. Allocates nothing.
void writeLightData(const ShadingLayout& layout, const LightTables& light, std::span<float> out);

}  // namespace penumbra
