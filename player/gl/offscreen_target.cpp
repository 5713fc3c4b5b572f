#include "player/gl/offscreen_target.h"

#include <array>
#include <stdexcept>

#include "formats/common/errors.h"

namespace penumbra {

namespace {

GlObject makeRenderbuffer(GLenum format, int width, int height, int samples) {
    GLuint id = 0;
    gl::GenRenderbuffers(1, &id);
    gl::BindRenderbuffer(GL_RENDERBUFFER, id);
    // To GL, no samples and one sample are different things, and a resolve needs the former as its target.
    gl::RenderbufferStorageMultisample(GL_RENDERBUFFER, samples > 1 ? samples : 0, format, width, height);
    return GlObject(id, [](GLuint r) { gl::DeleteRenderbuffers(1, &r); });
}

GlObject makeFramebuffer(const GlObject& color, const GlObject* depth) {
    GLuint id = 0;
    gl::GenFramebuffers(1, &id);
    GlObject framebuffer(id, [](GLuint f) { gl::DeleteFramebuffers(1, &f); });
    gl::BindFramebuffer(GL_FRAMEBUFFER, id);
    gl::FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color.id());
    if (depth) gl::FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth->id());
    checkGl("making the picture's buffers");
    if (gl::CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        throw Unsupported("this OpenGL cannot draw to buffers of the asked format, size and samples");
    return framebuffer;
}

void checkLimit(const char* what, int value, GLenum limit_name) {
    GLint limit = 0;
    gl::GetIntegerv(limit_name, &limit);
    if (value > limit)
        throw Unsupported(std::string(what) + " " + std::to_string(value) + " is above this OpenGL's limit, " +
                          std::to_string(limit));
}

}  // namespace

OffscreenTarget::OffscreenTarget(int width, int height, int samples, GLenum color)
    : width_(width), height_(height), samples_(samples) {
    checkLimit("the picture's width", width, GL_MAX_RENDERBUFFER_SIZE);
    checkLimit("the picture's height", height, GL_MAX_RENDERBUFFER_SIZE);
    checkLimit("the number of samples a pixel,", samples, GL_MAX_SAMPLES);
    color_ = makeRenderbuffer(color, width, height, samples);
    depth_ = makeRenderbuffer(GL_DEPTH_COMPONENT32F, width, height, samples);
    framebuffer_ = makeFramebuffer(color_, &depth_);
    if (samples == 1) return;
    resolved_color_ = makeRenderbuffer(color, width, height, 1);
    resolved_framebuffer_ = makeFramebuffer(resolved_color_, nullptr);
}

void OffscreenTarget::begin() const {
    gl::BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl::Viewport(0, 0, width_, height_);
    gl::Enable(GL_DEPTH_TEST);
    gl::Enable(GL_MULTISAMPLE);
    gl::ClearColor(0, 0, 0, 0);
    gl::Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

void OffscreenTarget::resolve() const {
    if (samples_ == 1) return gl::BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl::BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.id());
    gl::BindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_framebuffer_.id());
    gl::BlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    gl::BindFramebuffer(GL_FRAMEBUFFER, resolved_framebuffer_.id());
}

Image OffscreenTarget::read() const {
    resolve();
    std::vector<std::array<float, 4>> rows(std::size_t(width_) * std::size_t(height_));
    gl::PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl::ReadPixels(0, 0, width_, height_, GL_RGBA, GL_FLOAT, rows.data());
    checkGl("reading the picture");

    Image image{width_, height_, {}, {}};
    image.pixels.reserve(rows.size());
    image.alpha.reserve(rows.size());
    for (int y = height_ - 1; y >= 0; --y)  // GL's row 0 is the bottom one
        for (int x = 0; x < width_; ++x) {
            const std::array<float, 4>& p = rows[std::size_t(y) * std::size_t(width_) + std::size_t(x)];
            image.pixels.push_back({p[0], p[1], p[2]});
            image.alpha.push_back(p[3]);
        }
    return image;
}

void OffscreenTarget::readBytes(std::vector<std::uint8_t>& out) const {
    resolve();
    out.resize(4 * std::size_t(width_) * std::size_t(height_));
    gl::PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl::ReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, out.data());
    checkGl("reading the picture");
}

}  // namespace penumbra
