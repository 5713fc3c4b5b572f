#include "pack/sections/source_materials.h"

#include <algorithm>

#include "formats/brdf/principled_slices.h"
#include "formats/common/errors.h"
#include "formats/common/joined.h"
#include "sh/brdf/brdf_sum.h"
#include "sh/reflectance.h"

namespace penumbra {

namespace {

BrdfFile materialOf(const Principled& look, PrincipledSlices& slices) {
    const BrdfSum sum = parseBrdfSum(toString(look));
    BrdfFile brdf;
    brdf.name = sum.name;
    brdf.slice_order = slices.orders().slice_order;
    brdf.view_order = slices.orders().view_order;
    brdf.even_index = evenIndices(brdf.view_order);
    brdf.slices = slices.slicesOf(look);
    brdf.lobes = lobesOf(sum);
    brdf.emission = toFloat(sum.emission);
    return brdf;
}

// Returns the material of a look and warns of what it leaves out.
Principled readLook(const SlotLook& of, std::vector<std::string>& warnings) {
    const auto warn = [&](const std::string& what) {
        const std::string message = "material '" + of.look.material + "': " + what;
        if (std::ranges::find(warnings, message) == warnings.end()) warnings.push_back(message);
    };
    for (const std::string& note : of.look.notes) warn(note);
    const Principled look = shownLook(of.look);
    if (look.emission != of.look.principled.emission)
        warn("its emission is in a texture, which is not read: the surface does not glow");
    if (look.roughness < kMinRoughness)
        warn("roughness " + std::to_string(look.roughness) + " is shaded as " + std::to_string(kMinRoughness));
    return look;
}

void addSlot(const SlotLook& of, PrincipledSlices& slices, SourceMaterials& out) {
    if (!of.look.problem.empty())
        throw InvalidInput("slot '" + of.slot + "': material '" + of.look.material + "': " + of.look.problem);
    const Principled look = readLook(of, out.warnings);
    const std::string name = toString(look);
    if (std::ranges::find(out.materials, name, &BrdfFile::name) == out.materials.end())
        out.materials.push_back(materialOf(look, slices));
    out.of_slot.push_back(name);
    out.said.push_back("slot '" + of.slot + "': " + name +
                       (of.look.textures.empty() ? "" : "; textures: " + joined(of.look.textures)));
}

}  // namespace

SourceMaterials materialsOf(const SourceLooks& looks, std::span<const std::string> slots, int bands, int threads) {
    PrincipledSlices slices({bands, bands}, threads);
    SourceMaterials out;
    out.warnings = looks.notes;
    std::vector<std::string> asked(slots.begin(), slots.end());
    if (asked.empty())
        for (const SlotLook& of : looks.slots) asked.push_back(of.slot);
    for (const std::string& slot : asked) {
        if (const SourceLook* look = findLook(looks, slot)) {
            addSlot({slot, *look}, slices, out);
            continue;
        }
        out.of_slot.emplace_back();
        out.warnings.push_back("slot '" + slot + "' is not in the file: it has the first material");
    }
    if (out.materials.empty()) throw InvalidInput("has none of the mesh's slots");
    return out;
}

}  // namespace penumbra
