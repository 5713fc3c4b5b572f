#pragma once
// Tells what one program for all materials and lights of an asset reads, and where. Its entries are the union of the
// materials' entries that are not zero; lights are padded to the highest order. Switching then changes numbers in
// buffers only.
#include <vector>

#include "runtime/shade/shading_set.h"

namespace penumbra {

struct ShadingLayout {
    Convention convention;
    ShadingChoice choice;
    int channels = 1;      // 3 when any material has 3
    int view_order = 1;    // highest order of the materials
    int light_order = 1;   // highest order of the lights
    int lobe_count = 0;    // most lobes of a light; 0 with LightForm::kRotation
    bool bounces = false;  // the asset has light that bounces

    // f_k = sum over e of A_ke y_e(omega_o), sorted by (k, e).
    struct View {
        std::uint16_t k, e;
        auto operator<=>(const View&) const = default;
    };
    std::vector<View> views;
    // t_i = sum over j of v_j sum over k of B_ijk f_k. The value is Gamma for slices. For operators it is not used,
    // as each material has its own.
    std::vector<ProductEntry> products;

    // The number of entries of one material after its colour: the views and, for operators, the products.
    std::size_t entryCount() const;
    // True for a set that shows pictures with normal maps. Two more materials, the slopes along both axes, then follow
    // all others.
    bool slopes = false;
    // Only for a set that shows pictures: how many materials a slot has besides the current one (writeTermRows()).
    std::size_t term_passes = 0;
    bool membranes = false;  // some material is one
    bool emission = false;   // some material has
    // Live materials and the entries of M of each (LiveLobe::matrix()); 0 where there are none.
    std::size_t live_count = 0, live_entries = 0;
    std::size_t liveTexels() const { return (live_entries + 3) / 4; }  // texels of one live material
    // Materials with steps. Their entries change with the parameter, so they are in the light's data.
    std::size_t stepped_count = 0;
    std::size_t entryTexels() const { return channels == 3 ? entryCount() : (entryCount() + 3) / 4; }
    // RGBA32F texels of one material: its colour, whose alpha is 0, or one more than its number among the live
    // materials, or minus one more than its number among those with steps. Then four entries a texel follow, or one
    // entry a texel with three channels. Where there are membranes, two
    // more: rho, whose alpha is 1 for a membrane and 2 for one whose other side sees freely; and tau. Where there is
    // emission, one more before these.
    std::size_t materialTexels() const;
    std::size_t emissionTexel() const { return 1 + entryTexels(); }  // texel of a material's emission
    // Number of vec4 of the uniform block "Light": the lobe count, then axes and [lobe, band] weights, or SH
    // coefficients. Where light bounces, kBouncedLight more follow, and one that has 1 to show no direct light. M of
    // the live materials and the entries of those with steps come last, which change as often.
    std::size_t lightTexels() const { return firstSteppedTexel() + stepped_count * entryTexels(); }
    std::size_t firstSteppedTexel() const { return firstLiveTexel() + live_count * liveTexels(); }
    std::size_t directTexels() const;
    std::size_t firstLiveTexel() const { return directTexels() + (bounces ? kBouncedLight + 1 : 0); }
};

// Makes the layout for all materials and lights that the set can switch on.
ShadingLayout shadingLayout(const ShadingSet& set);

// Returns [material, materialTexels(), 4], and slopes where the layout has them, with zeros for a material that cannot
// be on.
std::vector<float> materialData(const ShadingLayout& layout, const ShadingSet& set);

// Writes [slots, 1 + term_passes]: 1 where a slot shows its pictures, else 0, and then the rows of materialData() that
// its terms take: slopes along two axes, where there are normal maps, and A and B at each roughness. -1: the term is 0.
void writeTermRows(const ShadingLayout& layout, const ShadingSet& set, std::span<float> out);

// Writes the light that is on, as it is turned, and the materials whose parameter may change: [lightTexels(), 4], every
// number. Allocates nothing.
void writeLightData(const ShadingLayout& layout, const ShadingSet& set, std::span<float> out);

}  // namespace penumbra
