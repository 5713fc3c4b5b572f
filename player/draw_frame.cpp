#include "player/draw_frame.h"

#include "formats/errors.h"

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

// Binding points of the uniform blocks.
static constexpr GLuint kSlicesBinding = 0, kLightBinding = 1;

static GlObject uniformBlock(const GlObject& program, const char* name, GLuint binding, std::span<const float> values) {
    GLint limit = 0;
    gl::GetIntegerv(GL_MAX_UNIFORM_BLOCK_SIZE, &limit);
    if (values.size_bytes() > std::size_t(limit))
        throw Unsupported(std::string(name) + " need " + std::to_string(values.size_bytes()) +
                          " bytes of a uniform block and this OpenGL has " + std::to_string(limit) +
                          "; use --path cpu");
    GlObject buffer = makeBuffer(GL_UNIFORM_BUFFER, values);
    gl::UniformBlockBinding(program.id(), gl::GetUniformBlockIndex(program.id(), name), binding);
    return buffer;
}

ModelPainter::ModelPainter(const AssetView& asset, Channel channel, const MaterialView* material,
                           const LightView* light, bool numbers_given)
    : model_(uploadModel(asset)) {
    ShaderRecipe recipe;
    recipe.channel = channel;
    recipe.convention = asset.model.convention;
    recipe.stride = asset.model.stride;
    recipe.influences = asset.mesh.influences;
    recipe.numbers_given = numbers_given;
    recipe.mean = model_.mean;
    recipe.basis = model_.basis;
    if (material && light) {
        recipe.light_order = light->order;
        recipe.slices = sliceLayout(*material);
    }
    program_ = makeProgram(evaluateVertexSource(recipe), channelFragmentSource(channel));
    if (channel != Channel::kShaded) return;
    slices_ = uniformBlock(program_, "Slices", kSlicesBinding, slicesBlock(recipe.slices, *material));
    light_ = uniformBlock(program_, "Light", kLightBinding, lightBlock(*light));
    checkGl("uploading material and light");
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

void ModelPainter::draw(const FrameView& view) const {
    setView(program_, view);
    GLint unit = 0;
    for (const auto& [name, buffer] : model_.samplers) {
        const GLint location = gl::GetUniformLocation(program_.id(), name.c_str());
        if (location < 0) continue;  // a channel that does not read it
        gl::ActiveTexture(GL_TEXTURE0 + GLenum(unit));
        gl::BindTexture(GL_TEXTURE_BUFFER, buffer.texture.id());
        gl::Uniform1i(location, unit++);
    }
    if (slices_.id()) gl::BindBufferBase(GL_UNIFORM_BUFFER, kSlicesBinding, slices_.id());
    if (light_.id()) gl::BindBufferBase(GL_UNIFORM_BUFFER, kLightBinding, light_.id());
    gl::BindVertexArray(model_.vertex_array.id());
    gl::DrawElements(GL_TRIANGLES, model_.index_count, GL_UNSIGNED_INT, nullptr);
    checkGl("drawing");
}

}  // namespace penumbra
