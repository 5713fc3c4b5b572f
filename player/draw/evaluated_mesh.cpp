#include "player/draw/evaluated_mesh.h"

#include <cassert>

#include "player/draw/shader_source.h"

namespace penumbra {

EvaluatedMesh::EvaluatedMesh(std::span<const std::uint32_t> triangles, std::size_t vertices, Channel channel,
                             BrdfModels sunlit)
    : vertices_(vertices),
      index_count_(GLsizei(triangles.size())),
      sunlit_(sunlit != 0),
      vertex_array_(makeVertexArray()),
      draw_(makeProgram(evaluatedVertexSource(channel, sunlit), channelFragmentSource(channel, sunlit))),
      vertex_count_(gl::GetUniformLocation(draw_.id(), "vertex_count")),
      view_(viewUniforms(draw_)),
      sunlight_(sunlightUniforms(draw_)) {
    const std::size_t bytes = vertices * (sunlit ? kSunlitQuads : kEvaluatedQuads) * 4 * sizeof(float);
    checkStorageBlock("the ground", bytes);
    evaluated_ = makeTextureStorage(GL_RGBA32F, bytes);
    gl::BindVertexArray(vertex_array_.id());
    triangles_ = makeBuffer(GL_ELEMENT_ARRAY_BUFFER, triangles);
}

void EvaluatedMesh::draw(const FrameView& view, const Sunlight* suns) const {
    assert(!sunlit_ || suns);
    setView(draw_, view_, view);
    if (sunlit_) suns->bind(sunlight_, view);
    gl::Uniform1i(vertex_count_, GLint(vertices_));
    gl::ActiveTexture(GL_TEXTURE0);
    gl::BindTexture(GL_TEXTURE_BUFFER, evaluated_.texture.id());
    gl::BindVertexArray(vertex_array_.id());
    gl::DrawElements(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr);
    checkGl("drawing the ground");
}

}  // namespace penumbra
