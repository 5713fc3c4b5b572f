#include "player/gl/gl_context.h"

#include "formats/common/errors.h"
#include "player/gl/gl_context_backends.h"
#include "player/gl/gl_loader.h"

namespace penumbra {

namespace {

std::string glString(GLenum name) {
    const GLubyte* text = gl::GetString(name);
    return text ? reinterpret_cast<const char*>(text) : "unknown";
}

}  // namespace

void describe(GlContext& context, const std::string& system) {
    const std::string renderer = glString(GL_RENDERER);
    context.description = system + ", " + renderer + ", " + glString(GL_VERSION);
    // These are Mesa's software rasterisers. There is no portable query for this.
    for (const char* name : {"llvmpipe", "softpipe", "swrast", "SWR"})
        if (renderer.find(name) != std::string::npos) context.software = true;
}

std::unique_ptr<GlContext> createGlContext(GlBackend backend) {
    if (backend == GlBackend::kCurrent) return std::make_unique<GlContext>();
    std::string egl_reason, osmesa_reason;
    std::unique_ptr<GlContext> context;
    if (backend == GlBackend::kAuto) context = createEglContext(EglDevices::kGpus, egl_reason);
    if (!context && backend != GlBackend::kEgl) context = createOsMesaContext(osmesa_reason);
    if (!context && backend != GlBackend::kOsMesa) context = createEglContext(EglDevices::kAll, egl_reason);
    if (context) return context;
    std::string message = "no OpenGL 4.3 context:";
    if (!egl_reason.empty()) message += " EGL: " + egl_reason + ";";
    if (!osmesa_reason.empty()) message += " OSMesa: " + osmesa_reason + ";";
    message.back() = '.';
    throw Unsupported(message + " Debian's packages libosmesa6 and libegl1 bring both");
}

}  // namespace penumbra
