#include "player/draw/gl_heights_ground.h"

#include "player/draw/heights_glsl.h"

namespace penumbra {

namespace {

constexpr GLuint kGroundReceiversBinding = 3, kGroundLightBinding = 3, kGroundEvaluatedBinding = 4,
                 kGroundCastsBinding = 5;

}  // namespace

GlHeightsGround::GlHeightsGround(const GlHeights& heights, std::span<const std::uint32_t> triangles,
                                 const ShadingSet* shading, std::optional<GroundLobes> lobes)
    : heights_(&heights),
      shading_(shading),
      lobes_(lobes),
      mesh_(triangles, heights.field().grid().size(), shading ? Channel::kShaded : Channel::kAmbient,
            lobes ? lobes->models : 0) {
    if (!shading) return;
    layout_ = shadingLayout(*shading);
    materials_ = makeTextureBuffer(GL_RGBA32F, std::span<const float>(materialData(*layout_, *shading)));
    light_.emplace(4 * layout_->lightTexels());
    checkGl("uploading the ground's material");
}

HeightsRecipe GlHeightsGround::recipe() const {
    const HeightReceivers& receivers = heights_->receivers();
    HeightsRecipe out;
    out.heights = heightsGlsl(heights_->field(), heights_->tables(), heights_->corner(), HeightReceiver::kOnField);
    out.order = heights_->tables().order();
    out.spacing = receivers.step();
    out.rows = receivers.rows();
    out.columns = receivers.columns();
    out.tolerance = heights_->tolerance();
    out.channel = shading_ ? Channel::kShaded : Channel::kAmbient;
    out.shading = layout_ ? &*layout_ : nullptr;
    out.sunlit = lobes_.has_value();
    return out;
}

void GlHeightsGround::castOnPoints(GlCast& cast) {
    const std::size_t quad = 4 * sizeof(float), count = mesh_.vertices();
    if (!casts_.id()) {
        checkStorageBlock("what is cast on the ground", count * kCastQuads * quad);
        receivers_ = makeStorage(count * kReceiverQuads * quad);
        casts_ = makeStorage(count * kCastQuads * quad);
        receiver_program_ = makeComputeProgram(heightsReceiversSource(recipe()));
    }
    heights_->bind();
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kGroundReceiversBinding, receivers_.id());
    gl::UseProgram(receiver_program_.id());
    dispatchItems(count, kWorkGroup);
    gl::MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    cast.cast(receivers_, casts_, count, true);
}

void GlHeightsGround::evaluate(GlCast* cast, Vec3 eye) {
    const bool casts = cast && !cast->empty();
    if (casts) castOnPoints(*cast);
    GlObject& program = casts ? past_casters_ : open_;
    if (!program.id()) {
        HeightsRecipe made = recipe();
        made.casts = casts;
        program = makeComputeProgram(heightsPointsSource(made));
    }
    gl::UseProgram(program.id());
    heights_->bind();
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kGroundEvaluatedBinding, mesh_.values().id());
    if (casts) gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kGroundCastsBinding, casts_.id());
    if (light_) {
        writeLightData(*layout_, *shading_, light_->next());
        light_->bind(kGroundLightBinding);
        gl::ActiveTexture(GL_TEXTURE0);  // the only sampler, unit 0
        gl::BindTexture(GL_TEXTURE_BUFFER, materials_.texture.id());
    }
    gl::Uniform3f(gl::GetUniformLocation(program.id(), "eye"), eye.x, eye.y, eye.z);
    if (lobes_)
        gl::Uniform3f(gl::GetUniformLocation(program.id(), "lobes"), lobes_->lobes.first, lobes_->lobes.count,
                      lobes_->lobes.mirror);
    dispatchItems(mesh_.vertices(), kWorkGroup);
    gl::MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    if (light_) light_->release();
    checkGl("shading the ground");
}

}  // namespace penumbra
