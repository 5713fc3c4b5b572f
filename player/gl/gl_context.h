#pragma once
// A current OpenGL 4.3 core context without a window or a display server.
#include <memory>
#include <string>
#include <string_view>

namespace penumbra {

enum class GlBackend {
    kAuto,    // EGL when it finds a GPU, else OSMesa, else EGL in software
    kEgl,     // libEGL.so.1: a GPU device when there is one, else Mesa's surfaceless platform
    kOsMesa,  // libOSMesa.so.8: software, needs neither GPU nor display
};

// "auto", "egl" or "osmesa"; UsageError otherwise.
GlBackend parseGlBackend(std::string_view word);

// Current on the calling thread from its making to its end; one at a time in a process.
class GlContext {
public:
    virtual ~GlContext() = default;
    std::string description;  // "OSMesa, llvmpipe (LLVM 15.0.6, 256 bits), 4.5 (Core Profile) Mesa 22.3.6"
    bool software = false;    // the processor draws, no GPU
};

// Loads the entry points of gl_loader.h too. Unsupported when there is no such context here, with the reasons.
std::unique_ptr<GlContext> createGlContext(GlBackend backend);

}  // namespace penumbra
