#include "player/draw/draw_frame.h"

#include <cassert>

#include "player/draw/shader_source.h"

namespace penumbra {

namespace {

constexpr GLuint kLobesLocation = 4, kSightLocation = 5;  // in value.vert

}  // namespace

ValuePainter::ValuePainter(std::span<const std::uint32_t> triangles, Channel channel, Sides sides, BrdfModels sunlit)
    : program_(makeProgram(valueVertexSource(channel, sunlit), channelFragmentSource(channel, sunlit))),
      vertex_array_(makeVertexArray()),
      view_(viewUniforms(program_)),
      sides_(sides),
      index_count_(GLsizei(triangles.size())) {
    gl::BindVertexArray(vertex_array_.id());
    GLuint location = 0;
    for (GlObject* buffer : {&positions_, &values_}) {
        *buffer = makeBuffer(GL_ARRAY_BUFFER, std::span<const std::byte>{});
        gl::VertexAttribPointer(location, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
        gl::EnableVertexAttribArray(location++);
    }
    if (sunlit) {
        sunlight_ = sunlightUniforms(program_);
        for (GlObject& buffer : surface_) {
            buffer = makeBuffer(GL_ARRAY_BUFFER, std::span<const std::byte>{});
            if (location == kLobesLocation)
                gl::VertexAttribIPointer(location, 1, GL_UNSIGNED_INT, 0, nullptr);
            else
                gl::VertexAttribPointer(location, location == kSightLocation ? 1 : 3, GL_FLOAT, GL_FALSE, 0, nullptr);
            if (location != kSightLocation) gl::EnableVertexAttribArray(location);
            ++location;
        }
    }
    if (sides == Sides::kSeen) surfaces_ = findClosedSurfaces(triangles);
    triangles_ = makeBuffer(GL_ELEMENT_ARRAY_BUFFER,
                            sides == Sides::kSeen ? std::span<const std::uint32_t>(surfaces_.triangles) : triangles);
    checkGl("uploading the mesh");
}

ValuePainter::ValuePainter(const MeshView& mesh, Channel channel, Sides sides, BrdfModels sunlit)
    : ValuePainter(mesh.triangles, channel, mesh.cull_backs ? Sides::kFront : sides, sunlit) {}

void ValuePainter::upload(std::span<const Vec3> positions, std::span<const Vec3> values, const SunlitSurface& surface) {
    gl::BindVertexArray(vertex_array_.id());
    replaceBuffer(GL_ARRAY_BUFFER, positions_, std::as_bytes(positions));
    replaceBuffer(GL_ARRAY_BUFFER, values_, std::as_bytes(values));
    if (sunlight_) {
        replaceBuffer(GL_ARRAY_BUFFER, surface_[0], std::as_bytes(surface.normals));
        replaceBuffer(GL_ARRAY_BUFFER, surface_[1], std::as_bytes(surface.tangents));
        replaceBuffer(GL_ARRAY_BUFFER, surface_[2], std::as_bytes(surface.lobes));
        replaceBuffer(GL_ARRAY_BUFFER, surface_[3], std::as_bytes(surface.sight));
        if (!surface.sight.empty()) gl::EnableVertexAttribArray(kSightLocation);
    }
    outward_ = allOutward(surfaces_, positions);
}

void ValuePainter::setTriangles(std::span<const std::uint32_t> triangles) {
    assert(sides_ != Sides::kSeen);
    gl::BindVertexArray(vertex_array_.id());
    replaceBuffer(GL_ELEMENT_ARRAY_BUFFER, triangles_, std::as_bytes(triangles));
    index_count_ = GLsizei(triangles.size());
}

void ValuePainter::draw(const FrameView& view, const Sunlight* suns) const {
    assert(!sunlight_ || suns);
    gl::BindVertexArray(vertex_array_.id());
    setView(program_, view_, view);
    if (sunlight_) suns->bind(*sunlight_, view);
    const GLsizei closed = outward_ ? GLsizei(surfaces_.closedIndices()) : 0;
    const GLsizei one_sided = sides_ == Sides::kFront ? index_count_ : closed;
    if (one_sided > 0) {
        gl::Enable(GL_CULL_FACE);
        gl::DrawElements(GL_TRIANGLES, one_sided, GL_UNSIGNED_INT, nullptr);
        gl::Disable(GL_CULL_FACE);
    }
    if (one_sided < index_count_)
        gl::DrawElements(GL_TRIANGLES, index_count_ - one_sided, GL_UNSIGNED_INT,
                         reinterpret_cast<const void*>(sizeof(std::uint32_t) * std::size_t(one_sided)));
    checkGl("drawing");
}

void ValuePainter::draw(const FrameView& view, std::span<const Vec3> positions, std::span<const Vec3> values) {
    upload(positions, values);
    draw(view);
}

}  // namespace penumbra
