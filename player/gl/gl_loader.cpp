#include "player/gl/gl_loader.h"

#include <string_view>

namespace penumbra::gl {

#define PENUMBRA_DEFINE(TYPE, name) PFNGL##TYPE##PROC name = nullptr;
PENUMBRA_GL_FUNCTIONS(PENUMBRA_DEFINE)
PENUMBRA_GL_OPTIONAL_FUNCTIONS(PENUMBRA_DEFINE)
#undef PENUMBRA_DEFINE

namespace {

bool hasExtension(std::string_view name) {
    GLint count = 0;
    GetIntegerv(GL_NUM_EXTENSIONS, &count);
    for (GLint i = 0; i < count; ++i)
        if (name == reinterpret_cast<const char*>(GetStringi(GL_EXTENSIONS, GLuint(i)))) return true;
    return false;
}

bool isAtLeast(GLint major, GLint minor) {
    GLint has_major = 0, has_minor = 0;
    GetIntegerv(GL_MAJOR_VERSION, &has_major);
    GetIntegerv(GL_MINOR_VERSION, &has_minor);
    return has_major > major || (has_major == major && has_minor >= minor);
}

}  // namespace

const char* loadFunctions(GetFunction get) {
    const char* missing = nullptr;
#define PENUMBRA_LOAD(TYPE, name)                                \
    name = reinterpret_cast<PFNGL##TYPE##PROC>(get("gl" #name)); \
    if (!name && !missing) missing = "gl" #name;
    PENUMBRA_GL_FUNCTIONS(PENUMBRA_LOAD)
#undef PENUMBRA_LOAD
    if (missing) return missing;
    // Drivers give addresses of functions that the context does not have, so ask the context.
    const bool has_storage = isAtLeast(4, 4) || hasExtension("GL_ARB_buffer_storage");
    BufferStorage = has_storage ? reinterpret_cast<PFNGLBUFFERSTORAGEPROC>(get("glBufferStorage")) : nullptr;
    return nullptr;
}

}  // namespace penumbra::gl
