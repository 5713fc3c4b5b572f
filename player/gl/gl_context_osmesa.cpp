// Makes a context by Mesa's off-screen interface. The library is opened with RTLD_LOCAL, since linked beside libGL it
// would make every gl* symbol ambiguous. The constants are those of GL/osmesa.h, copied because that header (package
// libosmesa6-dev) brings nothing else.
#include <dlfcn.h>

#include <array>
#include <cstdint>

#include "player/gl/gl_context_backends.h"
#include "player/gl/gl_loader.h"

namespace penumbra {
namespace {

constexpr int kFormat = 0x22, kDepthBits = 0x30, kStencilBits = 0x31, kAccumulationBits = 0x32, kProfile = 0x33,
              kCoreProfile = 0x34, kMajorVersion = 0x36, kMinorVersion = 0x37;

using Handle = void*;

struct OsMesaLibrary {
    void* library = nullptr;
    Handle (*create)(const int* attributes, Handle share) = nullptr;
    void (*destroy)(Handle) = nullptr;
    GLboolean (*make_current)(Handle, void* buffer, GLenum type, GLsizei width, GLsizei height) = nullptr;
    gl::GetFunction get = nullptr;
};

// The library stays open for the life of the process, because Mesa does not survive being unloaded and loaded again.
OsMesaLibrary& openOsMesa() {
    static OsMesaLibrary mesa = [] {
        OsMesaLibrary opened;
        opened.library = dlopen("libOSMesa.so.8", RTLD_NOW | RTLD_LOCAL);
        if (!opened.library) return opened;
        const auto find = [&](auto& function, const char* name) {
            function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(opened.library, name));
        };
        find(opened.create, "OSMesaCreateContextAttribs");
        find(opened.destroy, "OSMesaDestroyContext");
        find(opened.make_current, "OSMesaMakeCurrent");
        find(opened.get, "OSMesaGetProcAddress");
        return opened;
    }();
    return mesa;
}

struct OsMesaContext final : GlContext {
    Handle handle = nullptr;
    std::array<std::uint8_t, 4> pixel{};  // making it current needs a client buffer, though we draw to our own
    ~OsMesaContext() override {
        if (handle) openOsMesa().destroy(handle);
    }
};

}  // namespace

std::unique_ptr<GlContext> createOsMesaContext(std::string& reason) {
    const OsMesaLibrary& mesa = openOsMesa();
    if (!mesa.library || !mesa.create || !mesa.destroy || !mesa.make_current || !mesa.get) {
        reason = "libOSMesa.so.8 cannot be loaded";
        return nullptr;
    }
    const int attributes[] = {kFormat,           GL_RGBA,  kDepthBits, 24,           kStencilBits,  0,
                              kAccumulationBits, 0,        kProfile,   kCoreProfile, kMajorVersion, kGlMajor,
                              kMinorVersion,     kGlMinor, 0};
    auto context = std::make_unique<OsMesaContext>();
    context->handle = mesa.create(attributes, nullptr);
    if (!context->handle || !mesa.make_current(context->handle, context->pixel.data(), GL_UNSIGNED_BYTE, 1, 1)) {
        reason = "no OpenGL 4.3 core context";
        return nullptr;
    }
    if (const char* missing = gl::loadFunctions(mesa.get)) {
        reason = std::string(missing) + " is missing";
        return nullptr;
    }
    describe(*context, "OSMesa");
    return context;
}

}  // namespace penumbra
