#include "player/gl/gl_objects.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <stdexcept>

#include "formats/common/errors.h"

namespace penumbra {

GlObject makeBuffer(GLenum target, std::span<const std::byte> bytes) {
    GLuint id = 0;
    gl::GenBuffers(1, &id);
    GlObject buffer(id, [](GLuint b) { gl::DeleteBuffers(1, &b); });
    replaceBuffer(target, buffer, bytes);
    return buffer;
}

void replaceBuffer(GLenum target, const GlObject& buffer, std::span<const std::byte> bytes) {
    gl::BindBuffer(target, buffer.id());
    gl::BufferData(target, GLsizeiptr(bytes.size()), bytes.data(), GL_STATIC_DRAW);
}

GlObject makeVertexArray() {
    GLuint id = 0;
    gl::GenVertexArrays(1, &id);
    return GlObject(id, [](GLuint a) { gl::DeleteVertexArrays(1, &a); });
}

GlObject makeStorage(std::size_t bytes, GLbitfield flags) {
    GLuint id = 0;
    gl::GenBuffers(1, &id);
    GlObject buffer(id, [](GLuint b) { gl::DeleteBuffers(1, &b); });
    gl::BindBuffer(GL_SHADER_STORAGE_BUFFER, id);
    const auto size = GLsizeiptr(std::max<std::size_t>(bytes, 16));
    if (gl::BufferStorage)
        gl::BufferStorage(GL_SHADER_STORAGE_BUFFER, size, nullptr, flags);
    else
        gl::BufferData(GL_SHADER_STORAGE_BUFFER, size, nullptr, GL_DYNAMIC_DRAW);
    checkGl("allocating a buffer");
    return buffer;
}

void checkStorageBlock(const char* what, std::size_t bytes) {
    GLint limit = 0;
    gl::GetIntegerv(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &limit);
    if (bytes > std::size_t(limit))
        throw Unsupported(std::string(what) + " takes " + std::to_string(bytes) +
                          " bytes of a storage block and this OpenGL has " + std::to_string(limit) +
                          "; use the CPU path");
}

namespace {

std::size_t texelBytes(GLenum format) {
    switch (format) {
        case GL_R16UI:
            return 2;
        case GL_R32F:
        case GL_R32UI:
        case GL_RGBA8I:
            return 4;
        case GL_RG32F:
        case GL_RGBA16F:
        case GL_RGBA16:
            return 8;
        case GL_RGBA32F:
        case GL_RGBA32UI:
            return 16;
        default:
            throw std::logic_error("texture buffer format without a known size");
    }
}

}  // namespace

void replaceTextureBuffer(const TextureBuffer& buffer, std::span<const std::byte> bytes) {
    static constexpr std::array<std::byte, 16> kOneTexel{};
    replaceBuffer(GL_TEXTURE_BUFFER, buffer.buffer, bytes.empty() ? std::span<const std::byte>(kOneTexel) : bytes);
}

namespace {

void checkTexels(GLenum format, std::size_t bytes) {
    GLint limit = 0;
    gl::GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &limit);
    if (bytes / texelBytes(format) > std::size_t(limit))
        throw Unsupported("this OpenGL addresses " + std::to_string(limit) + " texels of a buffer and the asset has " +
                          std::to_string(bytes / texelBytes(format)) + "; use the CPU path");
}

GlObject textureOf(const GlObject& buffer, GLenum format) {
    GLuint id = 0;
    gl::GenTextures(1, &id);
    GlObject texture(id, [](GLuint t) { gl::DeleteTextures(1, &t); });
    gl::BindTexture(GL_TEXTURE_BUFFER, id);
    gl::TexBuffer(GL_TEXTURE_BUFFER, format, buffer.id());
    return texture;
}

}  // namespace

TextureBuffer makeTextureBuffer(GLenum format, std::span<const std::byte> bytes) {
    checkTexels(format, bytes.size());
    TextureBuffer result;
    result.buffer = makeBuffer(GL_TEXTURE_BUFFER, std::span<const std::byte>{});
    replaceTextureBuffer(result, bytes);
    result.texture = textureOf(result.buffer, format);
    return result;
}

TextureBuffer makeTextureStorage(GLenum format, std::size_t bytes) {
    checkTexels(format, bytes);
    TextureBuffer result;
    result.buffer = makeStorage(bytes);
    result.texture = textureOf(result.buffer, format);
    return result;
}

namespace {

std::string numberLines(const std::string& source) {
    std::string numbered = "1: ";
    int line = 1;
    for (const char c : source) {
        numbered += c;
        if (c == '\n') numbered += std::to_string(++line) + ": ";
    }
    return numbered;
}

GlObject compile(GLenum stage, const std::string& source) {
    GlObject shader(gl::CreateShader(stage), [](GLuint s) { gl::DeleteShader(s); });
    const char* text = source.c_str();
    gl::ShaderSource(shader.id(), 1, &text, nullptr);
    gl::CompileShader(shader.id());
    GLint compiled = 0;
    gl::GetShaderiv(shader.id(), GL_COMPILE_STATUS, &compiled);
    if (compiled) return shader;
    std::array<char, 4096> log{};
    gl::GetShaderInfoLog(shader.id(), GLsizei(log.size()), nullptr, log.data());
    throw std::logic_error(std::string("a shader does not compile: ") + log.data() + "\n" + numberLines(source));
}

GlObject link(std::initializer_list<const GlObject*> shaders) {
    GlObject program(gl::CreateProgram(), [](GLuint p) { gl::DeleteProgram(p); });
    for (const GlObject* shader : shaders) gl::AttachShader(program.id(), shader->id());
    gl::LinkProgram(program.id());
    GLint linked = 0;
    gl::GetProgramiv(program.id(), GL_LINK_STATUS, &linked);
    if (linked) return program;
    std::array<char, 4096> log{};
    gl::GetProgramInfoLog(program.id(), GLsizei(log.size()), nullptr, log.data());
    throw std::logic_error(std::string("a shader program does not link: ") + log.data());
}

}  // namespace

GlObject makeProgram(const std::string& vertex_source, const std::string& fragment_source) {
    const GlObject vertex = compile(GL_VERTEX_SHADER, vertex_source);
    const GlObject fragment = compile(GL_FRAGMENT_SHADER, fragment_source);
    return link({&vertex, &fragment});
}

GlObject makeComputeProgram(const std::string& source) {
    const GlObject shader = compile(GL_COMPUTE_SHADER, source);
    return link({&shader});
}

void dispatchItems(std::size_t count, std::size_t group) {
    constexpr std::size_t kMaxDispatch = 32768;
    const std::size_t groups = (count + group - 1) / group, rows = (groups + kMaxDispatch - 1) / kMaxDispatch;
    if (groups > 0) gl::DispatchCompute(GLuint((groups + rows - 1) / rows), GLuint(rows), 1);
}

void checkGl(const char* doing) {
    const GLenum error = gl::GetError();
    if (error == GL_NO_ERROR) return;
    if (error == GL_OUT_OF_MEMORY) throw std::runtime_error(std::string("OpenGL is out of memory while ") + doing);
    throw std::runtime_error(std::string("OpenGL error ") + std::to_string(error) + " while " + doing);
}

}  // namespace penumbra
