#pragma once
// Draws what the light looks like, behind everything else.
#include "player/draw/draw_frame.h"
#include "player/frame/sky_picture.h"

namespace penumbra {

// The rays of a picture: a pixel at (x, y) in [-1, 1]^2, y up, looks along ahead + x across + y up, which is not unit.
struct PictureRays {
    Vec3 ahead, across, up;
};
PictureRays raysOf(const FrameView& view);

class SkyPainter {
public:
    SkyPainter();
    void upload(const SkyPicture& sky);
    // Fills the picture, and leaves its depth as it is. `rotation` turns the light, L'(s) = L(rotation^T s). Suns are
    // discs; those without a radius cannot be seen.
    void draw(const FrameView& view, const Mat3& rotation) const;

private:
    GlObject program_, vertex_array_, triangle_;
    ViewUniforms view_;
    GLint rays_[3], size_, sun_count_, discs_, radiance_;
    TextureBuffer texels_;
    int width_ = 0, height_ = 0;
    std::vector<Sun> suns_;
};

}  // namespace penumbra
