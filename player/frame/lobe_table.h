#pragma once
// The lobes of all materials that suns shine on, one after another, as shaders read them (shaders/sunlight.glsl).
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "runtime/glsl/brdf_glsl.h"
#include "runtime/shade/shading_set.h"

namespace penumbra {

// Reference from the vertices of a material to its lobes in the table: index of the first, and their number << 24. With
// kLetsThrough the material is a membrane. One more entry follows its lobes then: tau as a colour, and a first
// parameter that is 1 if what comes through is unshadowed.
using LobeRange = std::uint32_t;
constexpr LobeRange kLetsThrough = 1u << 31;
inline std::size_t firstLobe(LobeRange range) { return range & 0xffffff; }
inline std::size_t lobeCount(LobeRange range) { return range >> 24 & 0x7f; }
// Among the models of lobes: some of them are of membranes.
constexpr BrdfModels kMembranes = 1u << 31;

// The same of a slot as shaders read it from a pose.
struct SlotLobes {
    float first = 0, count = 0;  // count: range >> 24
    float mirror = 0;            // 1: the first lobe is one
    float unused = 0;
    bool operator==(const SlotLobes&) const = default;
};

class LobeTable {
public:
    // Adds the lobes of a material. The same lobes again get the same range.
    LobeRange add(std::span<const BrdfLobe> lobes, const std::optional<Membrane>& membrane = {});
    // Adds the lobes of all materials that are on, and returns those of every vertex.
    std::vector<LobeRange> add(const ShadingSet& shading);
    // Adds them, too, and returns those of every slot.
    std::vector<SlotLobes> addSlots(const ShadingSet& shading);
    SlotLobes slotLobes(LobeRange range) const;
    std::span<const BrdfLobe> lobes() const { return lobes_; }
    // Returns the models of the lobes of vertices. kLambert is among them even where these have no lobes.
    BrdfModels models(std::span<const LobeRange> of_vertices) const;
    BrdfModels models() const { return models_; }  // models of all lobes that were ever added
    // Takes all lobes out. Ranges mean nothing any more.
    void clear() { lobes_.clear(); }
    bool isMirror(LobeRange range) const;  // tells whether the first lobe of a material is a mirror

private:
    LobeRange add(const ShadingSet& shading, std::size_t material);
    std::vector<BrdfLobe> lobes_;
    BrdfModels models_ = 1u << int(BrdfModel::kLambert);
};

}  // namespace penumbra
