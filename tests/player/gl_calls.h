#pragma once
// Stands in for the GL functions that compile or allocate for as long as it lives. Counts their calls and the bytes
// of buffers.
#include "player/gl/gl_loader.h"

namespace penumbra::player_test {

class GlCalls {
public:
    GlCalls() {
        made_ = 0;
        buffer_bytes_ = 0;
        create_program_ = gl::CreateProgram;
        compile_shader_ = gl::CompileShader;
        buffer_data_ = gl::BufferData;
        buffer_storage_ = gl::BufferStorage;
        map_buffer_range_ = gl::MapBufferRange;
        gen_buffers_ = gl::GenBuffers;
        gen_textures_ = gl::GenTextures;
        gl::CreateProgram = [] { return ++made_, create_program_(); };
        gl::CompileShader = [](GLuint shader) { ++made_, compile_shader_(shader); };
        gl::BufferData = [](GLenum target, GLsizeiptr size, const void* data, GLenum usage) {
            ++made_, buffer_bytes_ += size, buffer_data_(target, size, data, usage);
        };
        if (buffer_storage_)
            gl::BufferStorage = [](GLenum target, GLsizeiptr size, const void* data, GLbitfield flags) {
                ++made_, buffer_bytes_ += size, buffer_storage_(target, size, data, flags);
            };
        gl::MapBufferRange = [](GLenum target, GLintptr offset, GLsizeiptr length, GLbitfield access) {
            return ++made_, map_buffer_range_(target, offset, length, access);
        };
        gl::GenBuffers = [](GLsizei n, GLuint* ids) { ++made_, gen_buffers_(n, ids); };
        gl::GenTextures = [](GLsizei n, GLuint* ids) { ++made_, gen_textures_(n, ids); };
    }
    ~GlCalls() {
        gl::CreateProgram = create_program_;
        gl::CompileShader = compile_shader_;
        gl::BufferData = buffer_data_;
        gl::BufferStorage = buffer_storage_;
        gl::MapBufferRange = map_buffer_range_;
        gl::GenBuffers = gen_buffers_;
        gl::GenTextures = gen_textures_;
    }
    GlCalls(const GlCalls&) = delete;
    GlCalls& operator=(const GlCalls&) = delete;
    int made() const { return made_; }
    std::size_t bufferBytes() const { return std::size_t(buffer_bytes_); }

private:
    static inline int made_ = 0;
    static inline GLsizeiptr buffer_bytes_ = 0;
    static inline PFNGLCREATEPROGRAMPROC create_program_ = nullptr;
    static inline PFNGLCOMPILESHADERPROC compile_shader_ = nullptr;
    static inline PFNGLBUFFERDATAPROC buffer_data_ = nullptr;
    static inline PFNGLBUFFERSTORAGEPROC buffer_storage_ = nullptr;
    static inline PFNGLMAPBUFFERRANGEPROC map_buffer_range_ = nullptr;
    static inline PFNGLGENBUFFERSPROC gen_buffers_ = nullptr;
    static inline PFNGLGENTEXTURESPROC gen_textures_ = nullptr;
};

}  // namespace penumbra::player_test
