#include "player/draw_frame.h"

namespace penumbra {

static void setView(const GlObject& program, const FrameView& view) {
    gl::UseProgram(program.id());
    gl::UniformMatrix4fv(gl::GetUniformLocation(program.id(), "clip_from_model"), 1, GL_FALSE,
                         view.clip_from_model.data());
    gl::Uniform3f(gl::GetUniformLocation(program.id(), "eye"), view.eye.x, view.eye.y, view.eye.z);
    gl::Uniform1f(gl::GetUniformLocation(program.id(), "error_max"), view.error_max);
}

ValuePainter::ValuePainter(std::span<const std::uint32_t> triangles, Channel channel)
    : program_(makeProgram(valueVertexSource(channel), channelFragmentSource(channel))),
      vertex_array_(makeVertexArray()),
      index_count_(GLsizei(triangles.size())) {
    gl::BindVertexArray(vertex_array_.id());
    GLuint location = 0;
    for (GlObject* buffer : {&positions_, &values_}) {
        *buffer = makeBuffer(GL_ARRAY_BUFFER, std::span<const std::byte>{});
        gl::VertexAttribPointer(location, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
        gl::EnableVertexAttribArray(location++);
    }
    triangles_ = makeBuffer(GL_ELEMENT_ARRAY_BUFFER, triangles);
    checkGl("uploading the mesh");
}

void ValuePainter::draw(const FrameView& view, std::span<const Vec3> positions, std::span<const Vec3> values) const {
    gl::BindVertexArray(vertex_array_.id());
    replaceBuffer(GL_ARRAY_BUFFER, positions_, std::as_bytes(positions));
    replaceBuffer(GL_ARRAY_BUFFER, values_, std::as_bytes(values));
    setView(program_, view);
    gl::DrawElements(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr);
    checkGl("drawing");
}

ModelPainter::ModelPainter(const AssetView& asset, Channel channel, const ShadingSet* shading, bool numbers_given)
    : model_(uploadModel(asset)) {
    ShaderRecipe recipe;
    recipe.channel = channel;
    recipe.convention = asset.model.convention;
    recipe.stride = asset.model.stride;
    recipe.influences = asset.mesh.influences;
    recipe.numbers_given = numbers_given;
    recipe.mean = model_.mean;
    recipe.basis = model_.basis;
    ShadingLayout layout;
    if (channel == Channel::kShaded) {
        layout = shadingLayout(*shading);
        recipe.shading = &layout;
    }
    program_ = makeProgram(evaluateVertexSource(recipe), channelFragmentSource(channel));
    if (channel != Channel::kShaded) return;
    shading_.emplace(layout, *shading);
    shading_->attach(program_);
}

void ModelPainter::setPose(const Evaluator& evaluator, std::span<const Affine> bones) {
    uploadPose(model_, evaluator, bones);
}

void ModelPainter::setNumbers(std::span<const float> numbers) { uploadNumbers(model_, numbers); }

void ModelPainter::setTrueAmbient(std::span<const float> e) {
    gl::BindVertexArray(model_.vertex_array.id());
    true_ambient_ = makeBuffer(GL_ARRAY_BUFFER, e);
    gl::VertexAttribPointer(4, 1, GL_FLOAT, GL_FALSE, 0, nullptr);
    gl::EnableVertexAttribArray(4);
}

void ModelPainter::draw(const FrameView& view) {
    setView(program_, view);
    GLint unit = 0;
    for (const auto& [name, buffer] : model_.samplers) {
        const GLint location = gl::GetUniformLocation(program_.id(), name.c_str());
        if (location < 0) continue;  // a channel that does not read it
        gl::ActiveTexture(GL_TEXTURE0 + GLenum(unit));
        gl::BindTexture(GL_TEXTURE_BUFFER, buffer.texture.id());
        gl::Uniform1i(location, unit++);
    }
    if (shading_) shading_->bind(program_, GLuint(unit));
    gl::BindVertexArray(model_.vertex_array.id());
    gl::DrawElements(GL_TRIANGLES, model_.index_count, GL_UNSIGNED_INT, nullptr);
    checkGl("drawing");
}

}  // namespace penumbra
