#include "player/gl/upload_ring.h"

#include <stdexcept>

namespace penumbra {

constexpr GLuint64 kPatience = 10'000'000'000;  // nanoseconds

UploadRing::UploadRing(std::size_t floats_per_part) : floats_(floats_per_part) {
    GLint alignment = 1;
    gl::GetIntegerv(GL_SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT, &alignment);
    const auto step = std::size_t(alignment);
    checkStorageBlock("what changes from frame to frame", floats_ * sizeof(float));
    part_bytes_ = (floats_ * sizeof(float) + step - 1) / step * step;
    if (!gl::BufferStorage) {
        buffer_ = makeStorage(bytes());
        unmapped_.resize(floats_);
        return;
    }
    constexpr GLbitfield kMapped = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    buffer_ = makeStorage(bytes(), kMapped);
    mapped_ = static_cast<float*>(gl::MapBufferRange(GL_SHADER_STORAGE_BUFFER, 0, GLsizeiptr(bytes()), kMapped));
    checkGl("mapping what changes from frame to frame");
    if (!mapped_) throw std::runtime_error("OpenGL maps no buffer");
}

std::span<float> UploadRing::next() {
    part_ = (part_ + 1) % kParts;
    if (!mapped_) return unmapped_;
    if (const Fence fence = std::move(fences_[part_])) {
        const GLenum waited = gl::ClientWaitSync(fence.get(), GL_SYNC_FLUSH_COMMANDS_BIT, kPatience);
        if (waited != GL_ALREADY_SIGNALED && waited != GL_CONDITION_SATISFIED)
            throw std::runtime_error("the GPU does not finish a frame within 10 seconds");
    }
    return {mapped_ + part_ * part_bytes_ / sizeof(float), floats_};
}

void UploadRing::bind(GLuint binding) {
    const auto offset = GLintptr(part_ * part_bytes_);
    const auto size = GLsizeiptr(floats_ * sizeof(float));
    if (!mapped_) {
        gl::BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer_.id());
        gl::BufferSubData(GL_SHADER_STORAGE_BUFFER, offset, size, unmapped_.data());
    }
    gl::BindBufferRange(GL_SHADER_STORAGE_BUFFER, binding, buffer_.id(), offset, size);
}

void UploadRing::release() {
    if (mapped_) fences_[part_] = Fence(gl::FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0));
}

}  // namespace penumbra
