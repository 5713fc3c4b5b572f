#include "player/gl_loader.h"

namespace penumbra::gl {

#define PENUMBRA_DEFINE(TYPE, name) PFNGL##TYPE##PROC name = nullptr;
PENUMBRA_GL_FUNCTIONS(PENUMBRA_DEFINE)
#undef PENUMBRA_DEFINE

const char* loadFunctions(GetFunction get) {
    const char* missing = nullptr;
#define PENUMBRA_LOAD(TYPE, name)                                \
    name = reinterpret_cast<PFNGL##TYPE##PROC>(get("gl" #name)); \
    if (!name && !missing) missing = "gl" #name;
    PENUMBRA_GL_FUNCTIONS(PENUMBRA_LOAD)
#undef PENUMBRA_LOAD
    return missing;
}

}  // namespace penumbra::gl
