#include "player/draw/gl_cast.h"

#include <algorithm>
#include <bit>

#include "formats/common/errors.h"
#include "player/draw/gl_heights.h"
#include "runtime/glsl/cast_glsl.h"
#include "runtime/glsl/far_glsl.h"

namespace penumbra {

namespace {

constexpr GLuint kFieldsBinding = 0, kTablesBinding = 1, kPosedBinding = 2, kGivenReceiversBinding = 3,
                 kWrittenCastsBinding = 4, kLayoutBinding = 5, kCastAnchorsBinding = 6;

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

// Writes what cast_anchors.glsl calls the layout.
std::vector<std::uint32_t> castLayoutWords(const FarLayout& layout, std::size_t vertex_count) {
    std::vector<std::uint32_t> words(2 * layout.anchors.size() + 8 * vertex_count, kNoAnchor);
    std::uint32_t* const rows = words.data() + 2 * layout.anchors.size();
    for (const FarRun& run : layout.runs) {
        for (std::uint32_t a = run.first_anchor; a < run.first_anchor + run.anchor_count; ++a) {
            words[2 * a] = layout.anchors[a];
            words[2 * a + 1] = std::bit_cast<std::uint32_t>(run.spacing);
        }
        if (run.anchor_count == 0) continue;
        for (std::uint32_t r = run.first; r < run.first + run.count; ++r)
            for (std::size_t k = 0; k < kAnchorsOfReceiver; ++k) {
                const std::size_t at = r * kAnchorsOfReceiver + k;
                std::uint32_t* const row = rows + 8 * layout.receivers[r];
                row[k] = run.first_anchor + layout.anchor[at];
                row[kAnchorsOfReceiver + k] = std::bit_cast<std::uint32_t>(layout.weight[at]);
            }
    }
    return words;
}

float* writeSpheres(const GlCaster& caster, float* at) {
    const BlockersView& blockers = caster.evaluator->asset().blockers;
    for (std::size_t s = 0; s < blockers.spheres.size(); ++s) {
        const CasterSphere posed = movedBy(caster.evaluator->bones()[blockers.joints[s]], blockers.spheres[s]);
        const Vec3 center = caster.to_scene.point(posed.center);
        for (const float x : {center.x, center.y, center.z, posed.radius}) *at++ = x;
    }
    return at;
}

}  // namespace

GlCastAnchors::GlCastAnchors(const FarLayout& layout, std::size_t vertex_count, std::size_t capacity)
    : vertex_count_(vertex_count), anchor_count_(layout.anchors.size()) {
    std::vector<std::uint32_t> words = castLayoutWords(layout, vertex_count);
    layout_ = makeTable(words);
    const std::size_t values = std::max<std::size_t>(capacity * anchor_count_ * kCastAnchorWords, 4) * sizeof(float);
    checkStorageBlock("the anchors of casts", values);
    values_ = makeStorage(values);
    bytes_ = words.size() * sizeof(std::uint32_t) + values;
}

GlCast::GlCast(std::span<const GlCaster> casters) {
    uploadFields(casters);
    uploadTables(casters);
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
        if (first + count > kMaxFieldWords) throw Unsupported("the fields of the scene are too many for a GPU");
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

const GlCast::Program& GlCast::use(CastPass pass) {
    const auto [found, is_new] = programs_.try_emplace(pass);
    Program& made = found->second;
    if (is_new) {
        made.program = makeComputeProgram(castSource({.parts = parts_ > 0, .spheres = spheres_ > 0}, pass));
        const auto place = [&](const char* name) { return gl::GetUniformLocation(made.program.id(), name); };
        made.receiver_count = place("receiver_count");
        made.vertex_count = place("vertex_count");
        made.anchor_count = place("anchor_count");
        made.cast_quads = place("cast_quads");
        gl::UseProgram(made.program.id());
        gl::Uniform1i(place("part_count"), GLint(parts_));
        gl::Uniform1i(place("sphere_count"), GLint(spheres_));
    }
    gl::UseProgram(made.program.id());
    return made;
}

void GlCast::bind(const GlObject& receivers, const GlObject& casts) {
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kFieldsBinding, fields_.id());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kTablesBinding, tables_.id());
    posed_.bind(kPosedBinding);
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kGivenReceiversBinding, receivers.id());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kWrittenCastsBinding, casts.id());
}

void GlCast::cast(const GlObject& receivers, const GlObject& casts, std::size_t count, bool ground) {
    const bool heights = heights_ && !ground;
    bind(receivers, casts);
    const Program& program = use(CastPass::kEach);
    gl::Uniform1ui(program.receiver_count, GLuint(count));
    gl::Uniform1ui(program.cast_quads, GLuint(kCastQuads * (heights ? 2 : 1)));
    dispatchItems(count, kWorkGroup);
    if (heights) heights_->castOn(receivers, casts, count);
    gl::MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void GlCast::castAtAnchors(const GlObject& receivers, const GlObject& casts, const GlCastAnchors& anchors,
                           std::size_t characters) {
    const std::size_t count = characters * anchors.vertex_count_;
    if (anchors.anchor_count_ == 0) return cast(receivers, casts, count);
    bind(receivers, casts);
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kLayoutBinding, anchors.layout_.id());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kCastAnchorsBinding, anchors.values_.id());
    const auto useFor = [&](CastPass pass) -> const Program& {
        const Program& program = use(pass);
        gl::Uniform1ui(program.vertex_count, GLuint(anchors.vertex_count_));
        gl::Uniform1ui(program.anchor_count, GLuint(anchors.anchor_count_));
        return program;
    };
    useFor(CastPass::kAnchors);
    gl::DispatchCompute(GLuint((anchors.anchor_count_ + kWorkGroup - 1) / kWorkGroup), GLuint(characters), 1);
    gl::MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    const Program& at_anchors = useFor(CastPass::kAtAnchors);
    gl::Uniform1ui(at_anchors.receiver_count, GLuint(count));
    gl::Uniform1ui(at_anchors.cast_quads, GLuint(kCastQuads * castSets()));
    dispatchItems(count, kWorkGroup);
    if (heights_) heights_->castOn(receivers, casts, count);
    gl::MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

}  // namespace penumbra
