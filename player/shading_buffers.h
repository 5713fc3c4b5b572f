#pragma once
// A shading set in GL buffers. After they are made, a change writes a few numbers into a part of a buffer that no frame
// in flight reads: nothing is compiled, allocated or waited for.
#include "player/gl_objects.h"
#include "player/runtime/shading_layout.h"

namespace penumbra {

class ShadingBuffers {
public:
    // `program` is in use and has shadingGlsl(layout); `first_unit`: of the two texture units that are taken.
    // Unsupported when the light does not fit a uniform block.
    ShadingBuffers(const ShadingLayout& layout, const ShadingSet& set, const GlObject& program, GLuint first_unit);

    // Before a draw, with the program in use: uploads what changed in the set and binds everything.
    void bind();

private:
    const ShadingSet* set_;
    ShadingLayout layout_;
    TextureBuffer materials_, material_of_slot_;
    GlObject light_;
    std::vector<float> light_data_;  // of one part
    std::size_t light_part_bytes_ = 0;
    GLuint first_unit_;
    GLint slot_base_;  // uniform
    std::size_t light_part_ = 0, slot_part_ = 0;
    std::uint64_t light_version_ = 0, material_version_ = 0;

    void connect(const GlObject& program);
    void uploadLight();
    void uploadSlots();
};

}  // namespace penumbra
