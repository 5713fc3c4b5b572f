#include "player/draw_frame.h"

namespace penumbra {

static ViewUniforms viewUniforms(const GlObject& program) {
    return {gl::GetUniformLocation(program.id(), "clip_from_model"), gl::GetUniformLocation(program.id(), "eye"),
            gl::GetUniformLocation(program.id(), "error_max"), gl::GetUniformLocation(program.id(), "exposure"),
            gl::GetUniformLocation(program.id(), "tone_map")};
}

static void setView(const GlObject& program, const ViewUniforms& at, const FrameView& view) {
    gl::UseProgram(program.id());
    gl::UniformMatrix4fv(at.clip_from_model, 1, GL_FALSE, view.clip_from_model.data());
    gl::Uniform3f(at.eye, view.eye.x, view.eye.y, view.eye.z);
    gl::Uniform1f(at.error_max, view.error_max);
    gl::Uniform1f(at.exposure, view.display ? view.display->exposure : 1);
    gl::Uniform1i(at.tone_map, view.display ? int(view.display->tone_map) : -1);
}

ValuePainter::ValuePainter(std::span<const std::uint32_t> triangles, Channel channel)
    : program_(makeProgram(valueVertexSource(channel), channelFragmentSource(channel))),
      vertex_array_(makeVertexArray()),
      view_(viewUniforms(program_)),
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

void ValuePainter::upload(std::span<const Vec3> positions, std::span<const Vec3> values) const {
    gl::BindVertexArray(vertex_array_.id());
    replaceBuffer(GL_ARRAY_BUFFER, positions_, std::as_bytes(positions));
    replaceBuffer(GL_ARRAY_BUFFER, values_, std::as_bytes(values));
}

void ValuePainter::draw(const FrameView& view) const {
    gl::BindVertexArray(vertex_array_.id());
    setView(program_, view_, view);
    gl::DrawElements(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr);
    checkGl("drawing");
}

void ValuePainter::draw(const FrameView& view, std::span<const Vec3> positions, std::span<const Vec3> values) const {
    upload(positions, values);
    draw(view);
}

static constexpr const char* kSamplers[] = {"bones",         "skin_joints",   "skin_weights", "cluster_rotations",
                                            "given_numbers", "clusters",      "scores",       "mean_numbers",
                                            "mean_scales",   "basis_numbers", "basis_scales"};

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
    view_ = viewUniforms(program_);
    gl::UseProgram(program_.id());
    for (const char* name : kSamplers) {
        const GLint location = gl::GetUniformLocation(program_.id(), name);
        if (location < 0) continue;  // a channel that does not read it
        gl::Uniform1i(location, GLint(samplers_.size()));
        samplers_.push_back(name);
    }
    if (channel == Channel::kShaded) shading_.emplace(layout, *shading, program_, GLuint(samplers_.size()));
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
    setView(program_, view_, view);
    for (std::size_t unit = 0; unit < samplers_.size(); ++unit) {
        gl::ActiveTexture(GL_TEXTURE0 + GLenum(unit));
        gl::BindTexture(GL_TEXTURE_BUFFER, model_.samplers.at(samplers_[unit]).texture.id());
    }
    if (shading_) shading_->bind();
    gl::BindVertexArray(model_.vertex_array.id());
    gl::DrawElements(GL_TRIANGLES, model_.index_count, GL_UNSIGNED_INT, nullptr);
    checkGl("drawing");
}

}  // namespace penumbra
