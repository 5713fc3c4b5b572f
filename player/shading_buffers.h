#pragma once
// A shading set in GL buffers. After they are made, a change writes a few numbers into a part of a buffer that no frame
// in flight reads: nothing is compiled, allocated or waited for.
#include "player/gl_objects.h"
#include "player/shading_layout.h"

namespace penumbra {

class ShadingBuffers {
public:
    // Unsupported when the light does not fit a uniform block.
    ShadingBuffers(const ShadingLayout& layout, const ShadingSet& set);

    // Connects the program that shadingGlsl(layout) is part of; once.
    void attach(const GlObject& program) const;
    // Before a draw: uploads what changed in the set, binds the light. `first_unit`: of the two texture units it takes.
    void bind(const GlObject& program, GLuint first_unit);

private:
    const ShadingSet* set_;
    ShadingLayout layout_;
    TextureBuffer materials_, material_of_slot_;
    GlObject light_;
    std::vector<float> light_data_;  // of one part
    std::size_t light_part_bytes_ = 0;
    std::size_t light_part_ = 0, slot_part_ = 0;
    std::uint64_t light_version_ = 0, material_version_ = 0;

    void uploadLight();
    void uploadSlots();
};

}  // namespace penumbra
