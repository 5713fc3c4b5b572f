#pragma once
// Buffers, textures and programs that release themselves. A context must be current when they are made and released.
#include <cstddef>
#include <span>
#include <string>
#include <utility>

#include "player/gl/gl_loader.h"

namespace penumbra {

class GlObject {
public:
    using Delete = void (*)(GLuint);
    GlObject() = default;
    GlObject(GLuint id, Delete destroy) : id_(id), delete_(destroy) {}
    GlObject(GlObject&& other) noexcept : id_(std::exchange(other.id_, 0)), delete_(other.delete_) {}
    GlObject& operator=(GlObject&& other) noexcept {
        std::swap(id_, other.id_);
        std::swap(delete_, other.delete_);
        return *this;
    }
    ~GlObject() {
        if (id_) delete_(id_);
    }
    GLuint id() const { return id_; }

private:
    GLuint id_ = 0;
    Delete delete_ = nullptr;
};

GlObject makeBuffer(GLenum target, std::span<const std::byte> bytes);
void replaceBuffer(GLenum target, const GlObject& buffer, std::span<const std::byte> bytes);
GlObject makeVertexArray();

// Makes a buffer without contents, whose size never changes; it is immutable where GL has buffer storage. `flags` are
// those of glBufferStorage.
GlObject makeStorage(std::size_t bytes, GLbitfield flags = GL_DYNAMIC_STORAGE_BIT);
// Throws Unsupported, naming `what`, when shaders cannot reach that many bytes of a storage buffer.
void checkStorageBlock(const char* what, std::size_t bytes);

template <class T>
GlObject makeBuffer(GLenum target, std::span<const T> values) {
    return makeBuffer(target, std::as_bytes(values));
}

// A buffer that shaders read with texelFetch. An empty one gets one zero texel, so that it can be bound.
struct TextureBuffer {
    GlObject buffer, texture;
};
// `format` is GL_R32F, GL_RGBA8I, ... Throws Unsupported when the driver cannot address that many texels.
TextureBuffer makeTextureBuffer(GLenum format, std::span<const std::byte> bytes);
template <class T>
TextureBuffer makeTextureBuffer(GLenum format, std::span<const T> values) {
    return makeTextureBuffer(format, std::as_bytes(values));
}
void replaceTextureBuffer(const TextureBuffer& buffer, std::span<const std::byte> bytes);
// Makes one without contents yet, in storage of its own.
TextureBuffer makeTextureStorage(GLenum format, std::size_t bytes);

// Makes a linked program. When the source does not compile it throws std::logic_error with the driver's log and the
// numbered source, because the sources are ours.
GlObject makeProgram(const std::string& vertex_source, const std::string& fragment_source);
GlObject makeComputeProgram(const std::string& source);
// Runs the program in use for `count` items in groups of `group`. Item i is gl_GlobalInvocationID.x +
// gl_GlobalInvocationID.y * gl_NumWorkGroups.x * group, because a direction has at most 65,535 groups.
void dispatchItems(std::size_t count, std::size_t group);

// Throws std::runtime_error, which names `doing`, if any GL call since the last check has failed.
void checkGl(const char* doing);

}  // namespace penumbra
