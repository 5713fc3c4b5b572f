#pragma once
// An offscreen target is where a frame is drawn without a window: a multisampled colour and depth buffer, and the
// picture that it resolves to, which with one sample a pixel is the buffer itself.
#include <cstdint>
#include <vector>

#include "formats/image/image_file.h"
#include "player/gl/gl_objects.h"

namespace penumbra {

class OffscreenTarget {
public:
    // `samples` counts samples a pixel (1: only the center). `color` is GL_RGBA32F, or GL_RGBA8 as windows have it.
    // Throws Unsupported when the size or the samples are above GL's limits.
    OffscreenTarget(int width, int height, int samples, GLenum color = GL_RGBA32F);

    int width() const { return width_; }
    int height() const { return height_; }
    void begin() const;  // binds, sets the viewport, clears to transparent black
    // Returns the mean of each pixel's samples with row 0 at the top. Colours are multiplied by coverage, and alpha
    // is coverage.
    Image read() const;
    // Reads that as 8-bit RGBA, with rows from below as in GL, as a window does to show a frame. Resizes `out`.
    void readBytes(std::vector<std::uint8_t>& out) const;

private:
    void resolve() const;  // binds the samples' means
    int width_, height_, samples_;
    GlObject color_, depth_, resolved_color_, framebuffer_, resolved_framebuffer_;
};

}  // namespace penumbra
