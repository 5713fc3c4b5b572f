#include "player/draw/draw_frame.h"

#include "player/draw/shader_source.h"

namespace penumbra {

ViewUniforms viewUniforms(const GlObject& program) {
    return {gl::GetUniformLocation(program.id(), "clip_from_model"), gl::GetUniformLocation(program.id(), "eye"),
            gl::GetUniformLocation(program.id(), "error_max"), gl::GetUniformLocation(program.id(), "exposure"),
            gl::GetUniformLocation(program.id(), "tone_map")};
}

void setView(const GlObject& program, const ViewUniforms& at, const FrameView& view) {
    gl::UseProgram(program.id());
    gl::UniformMatrix4fv(at.clip_from_model, 1, GL_FALSE, view.clip_from_model.data());
    gl::Uniform3f(at.eye, view.eye.x, view.eye.y, view.eye.z);
    gl::Uniform1f(at.error_max, view.error_max);
    gl::Uniform1f(at.exposure, view.display ? view.display->exposure : view.scale);
    gl::Uniform1i(at.tone_map, view.display ? int(view.display->tone_map) : -1);
}

ValuePainter::ValuePainter(std::span<const std::uint32_t> triangles, Channel channel, Sides sides)
    : program_(makeProgram(valueVertexSource(channel), channelFragmentSource(channel))),
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
    if (sides == Sides::kSeen) surfaces_ = findClosedSurfaces(triangles);
    triangles_ = makeBuffer(GL_ELEMENT_ARRAY_BUFFER,
                            sides == Sides::kSeen ? std::span<const std::uint32_t>(surfaces_.triangles) : triangles);
    checkGl("uploading the mesh");
}

ValuePainter::ValuePainter(const MeshView& mesh, Channel channel, Sides sides)
    : ValuePainter(mesh.triangles, channel, mesh.two_sided ? Sides::kFront : sides) {}

void ValuePainter::upload(std::span<const Vec3> positions, std::span<const Vec3> values) {
    gl::BindVertexArray(vertex_array_.id());
    replaceBuffer(GL_ARRAY_BUFFER, positions_, std::as_bytes(positions));
    replaceBuffer(GL_ARRAY_BUFFER, values_, std::as_bytes(values));
    outward_ = allOutward(surfaces_, positions);
}

void ValuePainter::draw(const FrameView& view) const {
    gl::BindVertexArray(vertex_array_.id());
    setView(program_, view_, view);
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
