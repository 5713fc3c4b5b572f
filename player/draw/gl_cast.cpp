#include "player/draw/gl_cast.h"

#include <algorithm>
#include <map>

#include "formats/common/errors.h"
#include "player/draw/gl_heights.h"
#include "player/draw/shader_source.h"
#include "player/runtime/cast_glsl.h"
#include "player/runtime/far_glsl.h"

namespace penumbra {

namespace {

constexpr GLuint kFieldsBinding = 0, kTablesBinding = 1, kPosedBinding = 2, kGivenReceiversBinding = 3,
                 kWrittenCastsBinding = 4;

std::size_t partsOf(const GlCaster& caster) {
    return caster.kind == CasterKind::kFields ? caster.evaluator->farTables().partCount() : 0;
}

std::size_t spheresOf(const GlCaster& caster) {
    return caster.kind == CasterKind::kSpheres ? caster.evaluator->asset().blockers.spheres.size() : 0;
}

// A buffer without words cannot be bound.
template <class T>
GlObject makeTable(std::vector<T>& values) {
    values.resize(std::max<std::size_t>(values.size(), 4));
    checkStorageBlock("what casts in the scene", values.size() * sizeof(T));
    return makeBuffer(GL_SHADER_STORAGE_BUFFER, std::span<const T>(values));
}

float* writeSpheres(const GlCaster& caster, float* at) {
    const BlockersView& blockers = caster.evaluator->asset().blockers;
    for (std::size_t s = 0; s < blockers.spheres.size(); ++s) {
        const CasterSphere posed = movedBy(caster.evaluator->bones()[blockers.joints[s]], blockers.spheres[s]);
        const Vec3 centre = caster.to_scene.point(posed.centre);
        for (const float x : {centre.x, centre.y, centre.z, posed.radius}) *at++ = x;
    }
    return at;
}

}  // namespace

GlCast::GlCast(std::span<const GlCaster> casters) {
    uploadFields(casters);
    uploadTables(casters);
    program_ = makeComputeProgram(castSource(parts_ > 0, spheres_ > 0));
    receiver_count_ = gl::GetUniformLocation(program_.id(), "receiver_count");
    cast_quads_ = gl::GetUniformLocation(program_.id(), "cast_quads");
    gl::UseProgram(program_.id());
    gl::Uniform1i(gl::GetUniformLocation(program_.id(), "part_count"), GLint(parts_));
    gl::Uniform1i(gl::GetUniformLocation(program_.id(), "sphere_count"), GLint(spheres_));
    posed_ = UploadRing(std::max<std::size_t>(4, 4 * (kPosedPartRows * parts_ + spheres_)));
    checkGl("uploading the casters");
}

// Characters of one file share its fields.
void GlCast::uploadFields(std::span<const GlCaster> casters) {
    std::vector<std::uint32_t> words;
    std::map<const FarTables*, std::uint32_t> first_of;
    for (const GlCaster& caster : casters) {
        first_word_.push_back(0);
        if (partsOf(caster) == 0) continue;
        const FarTables& tables = caster.evaluator->farTables();
        const auto [found, is_new] = first_of.try_emplace(&tables, std::uint32_t(words.size()));
        first_word_.back() = found->second;
        if (!is_new) continue;
        const CompositionView& composition = *caster.evaluator->asset().model.composition;
        const std::size_t first = words.size(), count = fieldBlockWords(composition);
        if (first + count > kMostFieldWords) throw Unsupported("the fields of the scene are too many for a GPU");
        words.resize(first + count);
        writeFieldBlock(tables, composition, std::uint32_t(first), std::span(words).subspan(first));
    }
    fields_ = makeTable(words);
    bytes_ += words.size() * sizeof(std::uint32_t);
}

void GlCast::uploadTables(std::span<const GlCaster> casters) {
    std::vector<float> tables = capLogTexels();
    for (const GlCaster& caster : casters) {
        const std::size_t part = parts_, sphere = spheres_;
        parts_ += partsOf(caster);
        spheres_ += spheresOf(caster);
        for (const std::size_t place : {part, parts_, sphere, spheres_}) tables.push_back(float(place));
    }
    tables_ = makeTable(tables);
    bytes_ += tables.size() * sizeof(float);
}

void GlCast::pose(std::span<const GlCaster> casters) {
    float* at = posed_.next().data();
    for (std::size_t c = 0; c < casters.size(); ++c) {
        if (casters[c].kind != CasterKind::kFields) continue;
        std::uint32_t words = first_word_[c];
        for (const PosedPart& part : casters[c].evaluator->posedParts()) {
            writePosedPart(part, casters[c].to_scene, words, at);
            at += 4 * kPosedPartRows;
            words += kFarPartWords;
        }
    }
    for (const GlCaster& caster : casters)
        if (caster.kind == CasterKind::kSpheres) at = writeSpheres(caster, at);
}

void GlCast::cast(const GlObject& receivers, const GlObject& casts, std::size_t count, bool ground) {
    const bool heights = heights_ && !ground;
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kFieldsBinding, fields_.id());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kTablesBinding, tables_.id());
    posed_.bind(kPosedBinding);
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kGivenReceiversBinding, receivers.id());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kWrittenCastsBinding, casts.id());
    gl::UseProgram(program_.id());
    gl::Uniform1ui(receiver_count_, GLuint(count));
    gl::Uniform1ui(cast_quads_, GLuint(kCastQuads * (heights ? 2 : 1)));
    dispatchItems(count, kWorkGroup);
    if (heights) heights_->castOn(receivers, casts, count);
    gl::MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

}  // namespace penumbra
