#include "player/frame/lobe_table.h"

#include <algorithm>

namespace penumbra {

LobeRange LobeTable::add(std::span<const BrdfLobe> lobes) {
    auto at = std::search(lobes_.begin(), lobes_.end(), lobes.begin(), lobes.end());
    if (at == lobes_.end()) at = lobes_.insert(at, lobes.begin(), lobes.end());
    return LobeRange(at - lobes_.begin()) | LobeRange(lobes.size()) << 24;
}

BrdfModels LobeTable::models() const {
    BrdfModels models = 1u << int(BrdfModel::kLambert);
    for (const BrdfLobe& lobe : lobes_) models |= 1u << int(lobe.model);
    return models;
}

BrdfModels LobeTable::models(std::span<const LobeRange> of_vertices) const {
    BrdfModels models = 1u << int(BrdfModel::kLambert);
    for (const LobeRange range : of_vertices)
        for (const BrdfLobe& lobe : lobes().subspan(range & 0xffffff, range >> 24)) models |= 1u << int(lobe.model);
    return models;
}

bool LobeTable::isMirror(LobeRange range) const {
    return range >> 24 > 0 && lobes_[range & 0xffffff].model == BrdfModel::kMirror;
}

SlotLobes LobeTable::slotLobes(LobeRange range) const {
    return {float(range & 0xffffff), float(range >> 24), isMirror(range) ? 1.0f : 0.0f};
}

std::vector<SlotLobes> LobeTable::addSlots(const ShadingSet& shading) {
    std::vector<SlotLobes> of_slot;
    for (const std::uint16_t material : shading.materialOfSlot())
        of_slot.push_back(slotLobes(add(shading.lobesOf(material))));
    return of_slot;
}

std::vector<LobeRange> LobeTable::add(const ShadingSet& shading) {
    std::vector<LobeRange> of_slot;
    for (const std::uint16_t material : shading.materialOfSlot()) of_slot.push_back(add(shading.lobesOf(material)));
    const MeshView& mesh = shading.asset().mesh;
    std::vector<LobeRange> of_vertex(mesh.positions.size(), of_slot.front());
    for (std::size_t v = 0; v < mesh.slot_of_vertex.size(); ++v) of_vertex[v] = of_slot[mesh.slot_of_vertex[v]];
    return of_vertex;
}

}  // namespace penumbra
