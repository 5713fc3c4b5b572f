// Makes an EGL context without a surface, through libglvnd's libEGL.so.1. It tries GPU devices first
// (EGL_EXT_platform_device, which NVIDIA's and Mesa's drivers offer without a display), then Mesa's surfaceless
// platform.
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include <vector>

#include "player/gl/gl_context_backends.h"
#include "player/gl/gl_loader.h"

namespace penumbra {
namespace {

// clang-format off
#define PENUMBRA_EGL_FUNCTIONS(X) \
    X(INITIALIZE, Initialize) X(TERMINATE, Terminate) X(BINDAPI, BindAPI) X(CHOOSECONFIG, ChooseConfig) \
    X(CREATECONTEXT, CreateContext) X(DESTROYCONTEXT, DestroyContext) X(MAKECURRENT, MakeCurrent) \
    X(GETPLATFORMDISPLAYEXT, GetPlatformDisplayEXT)
// clang-format on

struct EglLibrary {
    PFNEGLGETPROCADDRESSPROC get = nullptr;
    PFNEGLQUERYDEVICESEXTPROC query_devices = nullptr;  // may be missing
#define PENUMBRA_MEMBER(TYPE, name) PFNEGL##TYPE##PROC name = nullptr;
    PENUMBRA_EGL_FUNCTIONS(PENUMBRA_MEMBER)
#undef PENUMBRA_MEMBER
    bool complete = false;
};

EglLibrary loadLibrary() {
    EglLibrary egl;
    void* library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!library) return egl;
    egl.get = reinterpret_cast<PFNEGLGETPROCADDRESSPROC>(dlsym(library, "eglGetProcAddress"));
    if (!egl.get) return egl;
    egl.complete = true;
    // Client functions come by dlsym (EGL 1.4 promises no more), extensions by eglGetProcAddress.
#define PENUMBRA_LOAD(TYPE, name)                                                         \
    egl.name = reinterpret_cast<PFNEGL##TYPE##PROC>(dlsym(library, "egl" #name));         \
    if (!egl.name) egl.name = reinterpret_cast<PFNEGL##TYPE##PROC>(egl.get("egl" #name)); \
    egl.complete = egl.complete && egl.name;
    PENUMBRA_EGL_FUNCTIONS(PENUMBRA_LOAD)
#undef PENUMBRA_LOAD
    egl.query_devices = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(egl.get("eglQueryDevicesEXT"));
    return egl;
}

// The library stays open for the life of the process, as the drivers behind it must.
const EglLibrary& openEgl() {
    static const EglLibrary egl = loadLibrary();
    return egl;
}

gl::Function getFunction(const char* name) { return openEgl().get(name); }

struct EglContext final : GlContext {
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext handle = EGL_NO_CONTEXT;
    ~EglContext() override {
        const EglLibrary& egl = openEgl();
        if (display == EGL_NO_DISPLAY) return;
        egl.MakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        if (handle != EGL_NO_CONTEXT) egl.DestroyContext(display, handle);
        egl.Terminate(display);
    }
};

std::unique_ptr<GlContext> createOn(EGLDisplay display, std::string& reason) {
    const EglLibrary& egl = openEgl();
    if (display == EGL_NO_DISPLAY || !egl.Initialize(display, nullptr, nullptr)) {
        reason = "no display could be initialised";
        return nullptr;
    }
    auto context = std::make_unique<EglContext>();
    context->display = display;
    const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 kGlMajor,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 kGlMinor,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_NONE};
    EGLConfig config = EGL_NO_CONFIG_KHR;
    EGLint configs = 0;
    if (egl.BindAPI(EGL_OPENGL_API)) {
        if (!egl.ChooseConfig(display, wanted, &config, 1, &configs) || configs == 0) config = EGL_NO_CONFIG_KHR;
        context->handle = egl.CreateContext(display, config, EGL_NO_CONTEXT, attributes);
    }
    if (context->handle == EGL_NO_CONTEXT ||
        !egl.MakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context->handle)) {
        reason = "no OpenGL 4.3 core context without a surface";
        return nullptr;
    }
    if (const char* missing = gl::loadFunctions(getFunction)) {
        reason = std::string(missing) + " is missing";
        return nullptr;
    }
    describe(*context, "EGL");
    return context;
}

std::vector<EGLDisplay> deviceDisplays() {
    const EglLibrary& egl = openEgl();
    std::vector<EGLDeviceEXT> devices(16);
    EGLint count = 0;
    if (!egl.query_devices || !egl.query_devices(EGLint(devices.size()), devices.data(), &count)) return {};
    std::vector<EGLDisplay> displays;
    for (EGLint i = 0; i < count; ++i)
        displays.push_back(egl.GetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[std::size_t(i)], nullptr));
    return displays;
}

}  // namespace

std::unique_ptr<GlContext> createEglContext(EglDevices devices, std::string& reason) {
    const EglLibrary& egl = openEgl();
    if (!egl.complete) {
        reason = "libEGL.so.1 cannot be loaded or is too old";
        return nullptr;
    }
    for (const EGLDisplay display : deviceDisplays())
        if (auto context = createOn(display, reason); context && !context->software) return context;
    if (devices == EglDevices::kGpus) {
        reason = "no GPU";
        return nullptr;
    }
    // This is a display of its own, not a device's: EGL_DEFAULT_DISPLAY on the surfaceless platform.
    return createOn(egl.GetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr), reason);
}

}  // namespace penumbra
