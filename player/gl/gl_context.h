#pragma once
// Makes a current OpenGL 4.3 core context without a window or a display server.
#include <memory>
#include <string>

#include "formats/common/words.h"

namespace penumbra {

enum class GlBackend {
    kAuto,     // EGL when it finds a GPU, else OSMesa, else EGL in software
    kEgl,      // libEGL.so.1: a GPU device when there is one, else Mesa's surfaceless platform
    kOsMesa,   // libOSMesa.so.8: software, needs neither GPU nor display
    kCurrent,  // the context of a window, which is current and whose entry points are loaded
};

inline constexpr Word<GlBackend> kGlWords[] = {
    {"auto", GlBackend::kAuto}, {"egl", GlBackend::kEgl}, {"osmesa", GlBackend::kOsMesa}};

// Is current on the calling thread from its making to its end. A process may have only one at a time.
class GlContext {
public:
    virtual ~GlContext() = default;
    std::string description;  // "OSMesa, llvmpipe (LLVM 15.0.6, 256 bits), 4.5 (Core Profile) Mesa 22.3.6"
    bool software = false;    // the processor draws, no GPU
};

// Also loads the entry points of gl_loader.h. Throws Unsupported, with the reasons, when there is no such context
// here.
std::unique_ptr<GlContext> createGlContext(GlBackend backend);

}  // namespace penumbra
