#pragma once
// Where a frame is drawn without a window: a multisampled colour and depth buffer, and the picture that it resolves to.
#include <cstdint>
#include <vector>

#include "formats/image/image_file.h"
#include "player/gl/gl_objects.h"

namespace penumbra {

class OffscreenTarget {
public:
    // `samples` a pixel (1: none beside the centre). Unsupported when the size or the samples are above GL's limits.
    // `color`: GL_RGBA32F, or what windows have, GL_RGBA8.
    OffscreenTarget(int width, int height, int samples, GLenum color = GL_RGBA32F);

    int width() const { return width_; }
    int height() const { return height_; }
    void begin() const;  // binds, sets the viewport, clears to transparent black
    // The mean of each pixel's samples, row 0 at the top, colours multiplied by coverage; alpha is coverage.
    Image read() const;
    // The same as 8-bit RGBA, rows from below as GL has them; resizes `out`. What a window does to show a frame.
    void readBytes(std::vector<std::uint8_t>& out) const;

private:
    void resolve() const;  // and binds what it resolved to
    int width_, height_;
    GlObject color_, depth_, resolved_color_, framebuffer_, resolved_framebuffer_;
};

}  // namespace penumbra
