#include "player/shading_buffers.h"

#include "formats/errors.h"

namespace penumbra {

// Copies of what changes: a change goes to the next one, and drivers queue at most three frames.
constexpr std::size_t kParts = 4;
constexpr GLuint kLightBinding = 0;

ShadingBuffers::ShadingBuffers(const ShadingLayout& layout, const ShadingSet& set, const GlObject& program,
                               GLuint first_unit)
    : set_(&set), layout_(layout), first_unit_(first_unit) {
    light_data_.resize(4 * layout.lightTexels());
    const std::size_t bytes = light_data_.size() * sizeof(float);
    GLint limit = 0, alignment = 1;
    gl::GetIntegerv(GL_MAX_UNIFORM_BLOCK_SIZE, &limit);
    gl::GetIntegerv(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, &alignment);
    if (bytes > std::size_t(limit))
        throw Unsupported("a light takes " + std::to_string(bytes) + " bytes of a uniform block and this OpenGL has " +
                          std::to_string(limit) + "; use --path cpu");
    light_part_bytes_ = (bytes + std::size_t(alignment) - 1) / std::size_t(alignment) * std::size_t(alignment);
    light_ =
        makeBuffer(GL_UNIFORM_BUFFER, std::span<const std::byte>(std::vector<std::byte>(kParts * light_part_bytes_)));
    const std::vector<float> materials = materialData(layout, set);
    materials_ = makeTextureBuffer(GL_RGBA32F, std::span<const float>(materials));
    const std::vector<std::uint16_t> slots(kParts * set.slotCount());
    material_of_slot_ = makeTextureBuffer(GL_R16UI, std::span<const std::uint16_t>(slots));
    connect(program);
    checkGl("uploading materials and lights");
}

void ShadingBuffers::connect(const GlObject& program) {
    gl::UniformBlockBinding(program.id(), gl::GetUniformBlockIndex(program.id(), "Light"), kLightBinding);
    gl::Uniform1i(gl::GetUniformLocation(program.id(), "materials"), GLint(first_unit_));
    gl::Uniform1i(gl::GetUniformLocation(program.id(), "material_of_slot"), GLint(first_unit_ + 1));
    slot_base_ = gl::GetUniformLocation(program.id(), "slot_base");
}

void ShadingBuffers::uploadLight() {
    light_part_ = (light_part_ + 1) % kParts;
    light_version_ = set_->lightVersion();
    writeLightData(layout_, set_->lightTables(), light_data_);
    gl::BindBuffer(GL_UNIFORM_BUFFER, light_.id());
    gl::BufferSubData(GL_UNIFORM_BUFFER, GLintptr(light_part_ * light_part_bytes_),
                      GLsizeiptr(light_data_.size() * sizeof(float)), light_data_.data());
}

void ShadingBuffers::uploadSlots() {
    slot_part_ = (slot_part_ + 1) % kParts;
    material_version_ = set_->materialVersion();
    const std::span<const std::uint16_t> slots = set_->materialOfSlot();
    gl::BindBuffer(GL_TEXTURE_BUFFER, material_of_slot_.buffer.id());
    gl::BufferSubData(GL_TEXTURE_BUFFER, GLintptr(slot_part_ * slots.size_bytes()), GLsizeiptr(slots.size_bytes()),
                      slots.data());
}

void ShadingBuffers::bind() {
    if (light_version_ != set_->lightVersion()) uploadLight();
    if (material_version_ != set_->materialVersion()) uploadSlots();
    gl::BindBufferRange(GL_UNIFORM_BUFFER, kLightBinding, light_.id(), GLintptr(light_part_ * light_part_bytes_),
                        GLsizeiptr(light_data_.size() * sizeof(float)));
    gl::ActiveTexture(GL_TEXTURE0 + first_unit_);
    gl::BindTexture(GL_TEXTURE_BUFFER, materials_.texture.id());
    gl::ActiveTexture(GL_TEXTURE0 + first_unit_ + 1);
    gl::BindTexture(GL_TEXTURE_BUFFER, material_of_slot_.texture.id());
    gl::Uniform1i(slot_base_, GLint(slot_part_ * set_->slotCount()));
}

}  // namespace penumbra
