#include "player/frame/lobe_table.h"

#include <algorithm>

namespace penumbra {

LobeRange LobeTable::add(std::span<const BrdfLobe> lobes, const std::optional<Membrane>& membrane) {
    std::vector<BrdfLobe> entries(lobes.begin(), lobes.end());
    if (membrane) entries.push_back({BrdfModel::kLambert, {membrane->open_back ? 1.0f : 0.0f}, membrane->tau});
    auto at = std::search(lobes_.begin(), lobes_.end(), entries.begin(), entries.end());
    if (at == lobes_.end()) at = lobes_.insert(at, entries.begin(), entries.end());
    for (const BrdfLobe& lobe : lobes) models_ |= 1u << int(lobe.model);
    if (membrane) models_ |= kMembranes;
    return LobeRange(at - lobes_.begin()) | LobeRange(lobes.size()) << 24 | (membrane ? kLetsThrough : 0);
}

BrdfModels LobeTable::models(std::span<const LobeRange> of_vertices) const {
    BrdfModels models = 1u << int(BrdfModel::kLambert);
    for (const LobeRange range : of_vertices) {
        for (const BrdfLobe& lobe : lobes().subspan(firstLobe(range), lobeCount(range)))
            models |= 1u << int(lobe.model);
        if (range & kLetsThrough) models |= kMembranes;
    }
    return models;
}

bool LobeTable::isMirror(LobeRange range) const {
    return lobeCount(range) > 0 && lobes_[firstLobe(range)].model == BrdfModel::kMirror;
}

SlotLobes LobeTable::slotLobes(LobeRange range) const {
    return {float(firstLobe(range)), float(range >> 24), isMirror(range) ? 1.0f : 0.0f};
}

LobeRange LobeTable::add(const ShadingSet& shading, std::size_t material) {
    return add(shading.lobesOf(material), shading.asset().materials[material].membrane);
}

std::vector<SlotLobes> LobeTable::addSlots(const ShadingSet& shading) {
    std::vector<SlotLobes> of_slot;
    for (const std::uint16_t material : shading.materialOfSlot()) of_slot.push_back(slotLobes(add(shading, material)));
    return of_slot;
}

std::vector<LobeRange> LobeTable::add(const ShadingSet& shading) {
    std::vector<LobeRange> of_slot;
    for (const std::uint16_t material : shading.materialOfSlot()) of_slot.push_back(add(shading, material));
    const MeshView& mesh = shading.asset().mesh;
    std::vector<LobeRange> of_vertex(mesh.positions.size(), of_slot.front());
    for (std::size_t v = 0; v < mesh.slot_of_vertex.size(); ++v) of_vertex[v] = of_slot[mesh.slot_of_vertex[v]];
    return of_vertex;
}

}  // namespace penumbra
