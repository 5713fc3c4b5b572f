#pragma once
// Loads OpenGL entry points by name from whichever context is current. The program does not link libGL, libOSMesa or
// libEGL, so that it can use any of them. Constants and function types come from Khronos' glcorearb.h.
#include <GL/glcorearb.h>

// clang-format off
#define PENUMBRA_GL_FUNCTIONS(X) \
    X(GETSTRING, GetString) X(GETINTEGERV, GetIntegerv) X(GETERROR, GetError) X(FINISH, Finish) \
    X(GENVERTEXARRAYS, GenVertexArrays) X(BINDVERTEXARRAY, BindVertexArray) X(DELETEVERTEXARRAYS, DeleteVertexArrays) \
    X(GENBUFFERS, GenBuffers) X(BINDBUFFER, BindBuffer) X(BUFFERDATA, BufferData) X(BUFFERSUBDATA, BufferSubData) \
    X(DELETEBUFFERS, DeleteBuffers) X(BINDBUFFERRANGE, BindBufferRange) \
    X(VERTEXATTRIBPOINTER, VertexAttribPointer) X(VERTEXATTRIBIPOINTER, VertexAttribIPointer) \
    X(ENABLEVERTEXATTRIBARRAY, EnableVertexAttribArray) X(VERTEXATTRIB1F, VertexAttrib1f) \
    X(CREATESHADER, CreateShader) X(SHADERSOURCE, ShaderSource) X(COMPILESHADER, CompileShader) \
    X(GETSHADERIV, GetShaderiv) X(GETSHADERINFOLOG, GetShaderInfoLog) X(DELETESHADER, DeleteShader) \
    X(CREATEPROGRAM, CreateProgram) X(ATTACHSHADER, AttachShader) X(LINKPROGRAM, LinkProgram) \
    X(GETPROGRAMIV, GetProgramiv) X(GETPROGRAMINFOLOG, GetProgramInfoLog) X(USEPROGRAM, UseProgram) \
    X(DELETEPROGRAM, DeleteProgram) X(GETUNIFORMLOCATION, GetUniformLocation) X(UNIFORM1I, Uniform1i) X(UNIFORM1UI, Uniform1ui) \
    X(UNIFORM1F, Uniform1f) X(UNIFORM1FV, Uniform1fv) X(UNIFORM2I, Uniform2i) X(UNIFORM2IV, Uniform2iv) X(UNIFORM3F, Uniform3f) X(UNIFORM3FV, Uniform3fv) \
    X(UNIFORM4FV, Uniform4fv) X(UNIFORMMATRIX3FV, UniformMatrix3fv) X(UNIFORMMATRIX4FV, UniformMatrix4fv) \
    X(GETUNIFORMBLOCKINDEX, GetUniformBlockIndex) X(UNIFORMBLOCKBINDING, UniformBlockBinding) \
    X(GENTEXTURES, GenTextures) X(BINDTEXTURE, BindTexture) X(ACTIVETEXTURE, ActiveTexture) X(TEXBUFFER, TexBuffer) \
    X(DELETETEXTURES, DeleteTextures) X(GENFRAMEBUFFERS, GenFramebuffers) X(BINDFRAMEBUFFER, BindFramebuffer) \
    X(FRAMEBUFFERRENDERBUFFER, FramebufferRenderbuffer) X(CHECKFRAMEBUFFERSTATUS, CheckFramebufferStatus) \
    X(DELETEFRAMEBUFFERS, DeleteFramebuffers) X(BLITFRAMEBUFFER, BlitFramebuffer) \
    X(GENRENDERBUFFERS, GenRenderbuffers) X(BINDRENDERBUFFER, BindRenderbuffer) \
    X(RENDERBUFFERSTORAGEMULTISAMPLE, RenderbufferStorageMultisample) X(DELETERENDERBUFFERS, DeleteRenderbuffers) \
    X(COLORMASK, ColorMask) X(VIEWPORT, Viewport) X(CLEARCOLOR, ClearColor) X(CLEAR, Clear) X(ENABLE, Enable) \
    X(DISABLE, Disable) X(BLENDFUNC, BlendFunc) \
    X(DRAWELEMENTS, DrawElements) X(READPIXELS, ReadPixels) X(PIXELSTOREI, PixelStorei) \
    X(SCISSOR, Scissor) X(GENQUERIES, GenQueries) X(DELETEQUERIES, DeleteQueries) X(QUERYCOUNTER, QueryCounter) \
    X(GETQUERYOBJECTIV, GetQueryObjectiv) X(GETQUERYOBJECTUI64V, GetQueryObjectui64v) X(GETSTRINGI, GetStringi) \
    X(DISPATCHCOMPUTE, DispatchCompute) X(MEMORYBARRIER, MemoryBarrier) X(BINDBUFFERBASE, BindBufferBase) \
    X(DRAWELEMENTSINSTANCED, DrawElementsInstanced) X(MAPBUFFERRANGE, MapBufferRange) X(FENCESYNC, FenceSync) \
    X(CLIENTWAITSYNC, ClientWaitSync) X(DELETESYNC, DeleteSync) X(TEXSTORAGE3D, TexStorage3D) \
    X(TEXIMAGE2D, TexImage2D) X(TEXPARAMETERI, TexParameteri) X(GENERATEMIPMAP, GenerateMipmap) X(FRAMEBUFFERTEXTURELAYER, FramebufferTextureLayer)
// These belong to OpenGL 4.4 or an extension; they are null where the context has neither.
#define PENUMBRA_GL_OPTIONAL_FUNCTIONS(X) X(BUFFERSTORAGE, BufferStorage)
// clang-format on

namespace penumbra::gl {

#define PENUMBRA_DECLARE(TYPE, name) extern PFNGL##TYPE##PROC name;
PENUMBRA_GL_FUNCTIONS(PENUMBRA_DECLARE)
PENUMBRA_GL_OPTIONAL_FUNCTIONS(PENUMBRA_DECLARE)
#undef PENUMBRA_DECLARE

using Function = void (*)();
using GetFunction = Function (*)(const char* name);

// Fetches every entry point of the current context. Returns the name of the first missing one that every OpenGL 4.3
// has, or null.
const char* loadFunctions(GetFunction get);

}  // namespace penumbra::gl
