#pragma once
// Where a frame is drawn without a window: a multisampled colour and depth buffer, and the picture that it resolves to.
#include "formats/image_file.h"
#include "player/gl_objects.h"

namespace penumbra {

class OffscreenTarget {
public:
    // `samples` a pixel (1: none beside the centre). Unsupported when the size or the samples are above GL's limits.
    OffscreenTarget(int width, int height, int samples);

    int width() const { return width_; }
    int height() const { return height_; }
    void begin() const;  // binds, sets the viewport, clears to transparent black
    // The mean of each pixel's samples, row 0 at the top, colours multiplied by coverage; alpha is coverage.
    Image read() const;

private:
    int width_, height_;
    GlObject color_, depth_, resolved_color_, framebuffer_, resolved_framebuffer_;
};

}  // namespace penumbra
