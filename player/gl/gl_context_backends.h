#pragma once
// The two window-less systems behind gl_context.cpp. Each function returns a context that is current with its entry
// points loaded, or null with `reason` filled in.
#include <memory>
#include <string>

#include "player/gl/gl_context.h"

namespace penumbra {

constexpr int kGlMajor = 4, kGlMinor = 3;

enum class EglDevices { kAll, kGpus };
std::unique_ptr<GlContext> createEglContext(EglDevices devices, std::string& reason);
std::unique_ptr<GlContext> createOsMesaContext(std::string& reason);

// Fills in description and `software` from the current context.
void describe(GlContext& context, const std::string& system);

}  // namespace penumbra
