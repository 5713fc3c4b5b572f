#pragma once
// The lobes of all materials that suns shine on, one after another, as shaders read them (shaders/sunlight.glsl).
#include <cstdint>
#include <span>
#include <vector>

#include "player/runtime/brdf_glsl.h"
#include "player/runtime/shading_set.h"

namespace penumbra {

// What the vertices of a material have: where its lobes are in the table (the first, and their number << 24).
using LobeRange = std::uint32_t;

// The same of a slot as shaders read it from a pose.
struct SlotLobes {
    float first = 0, count = 0;
    float mirror = 0;  // 1: the first lobe is one
    float unused = 0;
};

class LobeTable {
public:
    // Adds the lobes of a material. The same lobes again get the same range.
    LobeRange add(std::span<const BrdfLobe> lobes);
    // Adds the lobes of all materials that are on, and returns those of every vertex.
    std::vector<LobeRange> add(const ShadingSet& shading);
    // Adds them, too, and returns those of every slot.
    std::vector<SlotLobes> addSlots(const ShadingSet& shading);
    SlotLobes slotLobes(LobeRange range) const;
    std::span<const BrdfLobe> lobes() const { return lobes_; }
    // Returns the models of the lobes of vertices, which are not 0 even where these have no lobes.
    BrdfModels models(std::span<const LobeRange> of_vertices) const;
    BrdfModels models() const;             // of all lobes
    bool isMirror(LobeRange range) const;  // tells whether the first lobe of a material is a mirror

private:
    std::vector<BrdfLobe> lobes_;
};

}  // namespace penumbra
