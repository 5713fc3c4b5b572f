#include "player/draw/sky_painter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "player/draw/shader_source.h"

namespace penumbra {

// A point eye + d has the clip coordinates (r0 . d, r1 . d, r3 . d) for the x, y and w rows of clip_from_model, since
// the eye itself has zeros there. So d is the solution of r0 . d = x, r1 . d = y, r3 . d = 1.
PictureRays raysOf(const FrameView& view) {
    const auto& m = view.clip_from_model;
    const Vec3 x{m[0], m[4], m[8]}, y{m[1], m[5], m[9]}, w{m[3], m[7], m[11]};
    const float scale = 1 / dot(x, cross(y, w));
    return {cross(x, y) * scale, cross(y, w) * scale, cross(w, x) * scale};
}

SkyPainter::SkyPainter()
    : program_(makeProgram(skyVertexSource(), skyFragmentSource())),
      vertex_array_(makeVertexArray()),
      view_(viewUniforms(program_)),
      rays_{gl::GetUniformLocation(program_.id(), "ahead"), gl::GetUniformLocation(program_.id(), "across"),
            gl::GetUniformLocation(program_.id(), "up")},
      size_(gl::GetUniformLocation(program_.id(), "sky_size")),
      sun_count_(gl::GetUniformLocation(program_.id(), "sun_count")),
      discs_(gl::GetUniformLocation(program_.id(), "sun_disc")),
      radiance_(gl::GetUniformLocation(program_.id(), "sun_radiance")) {
    constexpr std::array<std::uint32_t, 3> kTriangle{0, 1, 2};
    gl::BindVertexArray(vertex_array_.id());
    triangle_ = makeBuffer(GL_ELEMENT_ARRAY_BUFFER, std::span<const std::uint32_t>(kTriangle));
    checkGl("making the sky");
}

void SkyPainter::upload(const SkyPicture& sky) {
    texels_ = makeTextureBuffer(GL_RGBA16F, std::as_bytes(std::span(sky.texels)));
    width_ = sky.width;
    height_ = sky.height;
    suns_ = sky.suns;
}

void SkyPainter::draw(const FrameView& view, const Mat3& rotation) const {
    setView(program_, view_, view);
    const PictureRays rays = raysOf(view);
    const Mat3 to_light = transposed(rotation);
    const Vec3 turned[3] = {to_light * rays.ahead, to_light * rays.across, to_light * rays.up};
    for (int i = 0; i < 3; ++i) gl::Uniform3f(rays_[i], turned[i].x, turned[i].y, turned[i].z);
    gl::Uniform2i(size_, width_, height_);

    std::array<float, 4 * kMaxSuns> discs{};
    std::array<float, 3 * kMaxSuns> radiance{};
    int count = 0;
    for (const Sun& sun : suns_) {
        if (sun.radius <= 0) continue;
        const float sine = std::sin(sun.radius), area = std::numbers::pi_v<float> * sine * sine;
        const float disc[4] = {sun.direction.x, sun.direction.y, sun.direction.z, std::cos(sun.radius)};
        std::copy_n(disc, 4, &discs[std::size_t(4 * count)]);
        for (int c = 0; c < 3; ++c) radiance[std::size_t(3 * count + c)] = sun.irradiance[c] / area;
        ++count;
    }
    gl::Uniform1i(sun_count_, count);
    gl::Uniform4fv(discs_, kMaxSuns, discs.data());
    gl::Uniform3fv(radiance_, kMaxSuns, radiance.data());

    gl::ActiveTexture(GL_TEXTURE0);
    gl::BindTexture(GL_TEXTURE_BUFFER, texels_.texture.id());
    gl::BindVertexArray(vertex_array_.id());
    gl::Disable(GL_DEPTH_TEST);
    gl::DrawElements(GL_TRIANGLES, 3, GL_UNSIGNED_INT, nullptr);
    gl::Enable(GL_DEPTH_TEST);
    checkGl("drawing the sky");
}

}  // namespace penumbra
