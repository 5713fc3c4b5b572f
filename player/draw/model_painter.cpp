#include "player/draw/model_painter.h"

#include <algorithm>
#include <cassert>

#include "formats/common/errors.h"
#include "runtime/glsl/far_glsl.h"

namespace penumbra {

constexpr GLuint kPosesBinding = 1, kEvaluatedBinding = 2, kCoefficientsBinding = 3, kAmbientBinding = 4,
                 kVerticesBinding = 5, kAnchorsBinding = 6, kReceiversBinding = 7, kCastsBinding = 7;
constexpr std::size_t kMaxGroups = 65535;  // of a dispatch, in each direction; every OpenGL has as many

ModelPainter::ModelPainter(std::shared_ptr<GlAsset> asset, std::size_t capacity)
    : asset_(std::move(asset)), capacity_(capacity), poses_(4 * capacity * asset_->pose().size) {
    if (capacity > kMaxGroups || asset_->vertexCount() / kWorkGroup >= kMaxGroups)
        throw Unsupported("too many characters or vertices for one dispatch; use the CPU path");
    makeRoom();
}

void ModelPainter::makeRoom() {
    checkStorageBlock("what is drawn of all characters", evaluatedBytes());
    evaluated_ = makeTextureStorage(GL_RGBA32F, evaluatedBytes());
}

std::size_t ModelPainter::evaluatedBytes() const {
    return capacity_ * asset_->vertexCount() * quads_ * 4 * sizeof(float);
}

std::size_t ModelPainter::anchorBytes() const { return capacity_ * asset_->anchorValues() * 4 * sizeof(float); }

std::size_t ModelPainter::bytes() const {
    return evaluatedBytes() + poses_.bytes() + (coefficients_ ? coefficients_->bytes() : 0) +
           (anchors_ ? anchorBytes() : 0) +
           (casts_ ? capacity_ * asset_->vertexCount() * (kReceiverQuads + cast_sets_ * kCastQuads) * 4 * sizeof(float)
                   : 0) +
           (cast_anchors_ ? cast_anchors_->bytes() : 0) + (true_ambient_ ? true_ambient_->bytes() : 0) +
           (vertices_ ? vertices_->bytes() : 0);
}

namespace {

// Writes the PosePlaces of one character, in order. `out` is only written, never read.
void writePose(const GlAsset& asset, const PosedCharacter& character, bool with_looks, std::span<float> out) {
    const PosePlaces& places = asset.pose();
    const std::vector<ClusterView>& clusters = asset.view().model.clusters;
    float* at = std::copy_n(character.to_scene.m.data(), 12, out.data());
    const float given = character.coefficients.empty() ? 0.0f : 1.0f;
    const float caster = character.caster == kNobody ? -1.0f : float(character.caster);
    for (const float x : {given, caster, 0.0f, 0.0f}) *at++ = x;
    for (const Affine& bone : character.evaluator->bones()) at = std::copy_n(bone.m.data(), 12, at);
    for (std::size_t c = 0; c < clusters.size(); ++c) {
        const Mat3& r = character.evaluator->clusterRotation(c);
        const float rows[12] = {r.m[0], r.m[1], r.m[2], 0, r.m[3], r.m[4], r.m[5], 0, r.m[6], r.m[7], r.m[8], 0};
        at = std::copy_n(rows, 12, at);
    }
    const auto write = [&](std::span<const float> y, std::span<const float> scale) {
        for (std::size_t k = 0; k < y.size(); ++k) *at++ = scale.empty() ? y[k] : y[k] * scale[k];
    };
    for (std::size_t c = 0; c < clusters.size(); ++c) write(character.evaluator->scores(c), clusters[c].basis.scale);
    if (asset.evaluatesFar()) {
        const std::vector<ClusterView>& residual = asset.view().model.composition->residual;
        for (std::size_t c = 0; c < residual.size(); ++c)
            write(character.evaluator->residualScores(c), residual[c].basis.scale);
    }
    if (const std::optional<IndirectView>& indirect = asset.view().model.indirect)
        for (std::size_t c = 0; c < clusters.size(); ++c)
            write(character.evaluator->indirectScores(c), indirect->clusters[c].basis.scale);
    if (asset.evaluatesFar()) {
        at = out.data() + 4 * places.parts;
        std::uint32_t words = asset.fieldWords();
        for (const PosedPart& part : character.evaluator->posedParts()) {
            writePosedPart(part, {}, words, at);
            at += 4 * kPosedPartRows;
            words += kFarPartWords;
        }
    }
    if (!with_looks) return;
    at = out.data() + 4 * places.materials;
    for (const std::uint16_t material : character.shading->materialOfSlot()) *at++ = float(material);
    at = out.data() + 4 * places.lobes;
    for (const SlotLobes& lobes : character.lobes)
        for (const float x : {lobes.first, lobes.count, lobes.mirror, 0.0f}) *at++ = x;
    if (asset.surface())
        writeTermRows(
            asset.shading(), *character.shading,
            out.subspan(4 * places.terms, character.shading->slotCount() * (1 + asset.shading().term_passes)));
    writeLightData(asset.shading(), *character.shading, out.subspan(4 * places.light));
}

}  // namespace

void ModelPainter::uploadPoses(std::span<const PosedCharacter> characters) {
    const std::span<float> out = poses_.next();
    const std::size_t size = 4 * asset_->pose().size;
    for (std::size_t i = 0; i < characters.size(); ++i)
        writePose(*asset_, characters[i], channel_ == Channel::kShaded, out.subspan(i * size, size));
}

void ModelPainter::uploadArrays(std::optional<UploadRing>& ring, std::span<const PosedCharacter> characters,
                                std::span<const float> PosedCharacter::*member, std::size_t of_one) {
    if (!ring) ring.emplace(capacity_ * of_one);
    const std::span<float> out = ring->next();
    for (std::size_t i = 0; i < characters.size(); ++i) {
        const std::span<const float> values = characters[i].*member;
        assert(values.empty() || values.size() == of_one);
        std::copy(values.begin(), values.end(), out.begin() + std::ptrdiff_t(i * of_one));
    }
}

// Writes position and normal of every skinned vertex, and returns what follows.
static float* writeSkinned(const Evaluator& evaluator, float* at) {
    std::vector<Vec3> positions(evaluator.vertexCount()), normals(positions), tangents(positions);
    evaluator.skin(0, positions.size(), positions, normals, tangents);
    for (std::size_t v = 0; v < positions.size(); ++v) {
        const Vec3 p = positions[v], n = normals[v];
        for (const float number : {p.x, p.y, p.z, n.x, n.y, n.z}) *at++ = number;
    }
    return at;
}

// Uploads position and normal of every vertex of a mesh that deforms or has morph targets. Other meshes need none, as
// the GPU skins them.
void ModelPainter::uploadVertices(std::span<const PosedCharacter> characters) {
    const AssetView& asset = asset_->view();
    if (!asset.model.deforming && asset.mesh.morphs.empty()) return;
    if (!vertices_) vertices_.emplace(capacity_ * asset_->vertexCount() * 6);
    float* at = vertices_->next().data();
    for (const PosedCharacter& character : characters) {
        const Evaluator& evaluator = *character.evaluator;
        if (!asset.model.deforming) {
            at = writeSkinned(evaluator, at);
            continue;
        }
        for (std::size_t v = 0; v < asset_->vertexCount(); ++v) {
            const std::size_t point = asset.mesh.pointOf(v);
            const Vec3 p = evaluator.points()[point], front = evaluator.pointNormals()[point],
                       n = asset.mesh.isBack(v) ? -front : front;
            for (const float number : {p.x, p.y, p.z, n.x, n.y, n.z}) *at++ = number;
        }
    }
}

void ModelPainter::uploadCoefficients(std::span<const PosedCharacter> characters) {
    const std::size_t vertices = asset_->vertexCount();
    const auto given = [](const PosedCharacter& character) { return !character.coefficients.empty(); };
    assert(!asset_->needsCoefficients() || std::all_of(characters.begin(), characters.end(), given));
    has_coefficients_ = std::any_of(characters.begin(), characters.end(), given);
    if (has_coefficients_)
        uploadArrays(coefficients_, characters, &PosedCharacter::coefficients,
                     vertices * std::size_t(asset_->view().model.stride));
    if (channel_ == Channel::kError) uploadArrays(true_ambient_, characters, &PosedCharacter::true_ambient, vertices);
}

void ModelPainter::bind() {
    asset_->bindArrays();
    poses_.bind(kPosesBinding);
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kEvaluatedBinding, evaluated_.buffer.id());
    (has_coefficients_ ? *coefficients_ : poses_)
        .bind(kCoefficientsBinding);  // any buffer will do where it is not read
    if (channel_ == Channel::kError) true_ambient_->bind(kAmbientBinding);
    if (vertices_) vertices_->bind(kVerticesBinding);
}

// Casts on the vertices of all characters, which evaluating reads afterwards.
void ModelPainter::castOnVertices(GlCast& cast, const Evaluator& evaluator) {
    const std::size_t quad = 4 * sizeof(float), room = capacity_ * asset_->vertexCount();
    if (!casts_ || cast_sets_ < cast.castSets()) {
        cast_sets_ = cast.castSets();
        checkStorageBlock("what is cast on all characters", room * cast_sets_ * kCastQuads * quad);
        receivers_.emplace(makeStorage(room * kReceiverQuads * quad));
        casts_.emplace(makeStorage(room * cast_sets_ * kCastQuads * quad));
        if (!cast_anchors_) cast_anchors_.emplace(evaluator.castLayout(), asset_->vertexCount(), capacity_);
    }
    bind();
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kReceiversBinding, receivers_->id());
    dispatch(asset_->receiverProgram(), asset_->vertexCount());
    gl::MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    cast.castAtAnchors(*receivers_, *casts_, *cast_anchors_, count_);
}

void ModelPainter::dispatch(const GlAsset::Program& program, std::size_t invocations) const {
    gl::UseProgram(program.program.id());
    gl::Uniform1ui(program.vertex_count, GLuint(asset_->vertexCount()));
    gl::DispatchCompute(GLuint((invocations + kWorkGroup - 1) / kWorkGroup), GLuint(count_), 1);
}

// Evaluates the anchors of all characters, which the vertices read afterwards.
void ModelPainter::evaluateAnchors() {
    if (!anchors_) {
        checkStorageBlock("the anchors of all characters", anchorBytes());
        anchors_.emplace(makeStorage(std::max<std::size_t>(anchorBytes(), 16)));
    }
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kAnchorsBinding, anchors_->id());
    if (asset_->anchorCount() == 0) return;
    dispatch(asset_->anchorProgram(), asset_->anchorCount());
    gl::MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void ModelPainter::release() {
    poses_.release();
    if (has_coefficients_) coefficients_->release();
    if (channel_ == Channel::kError) true_ambient_->release();
    if (vertices_) vertices_->release();
}

void ModelPainter::evaluate(Channel channel, std::span<const PosedCharacter> characters, Vec3 eye, GlCast* cast) {
    assert(characters.size() <= capacity_);
    channel_ = channel;
    count_ = characters.size();
    if (count_ == 0) return;
    sunlit_ = !characters.front().lobes.empty();
    assert(std::ranges::all_of(characters, [&](const PosedCharacter& c) { return c.lobes.empty() != sunlit_; }));
    if (const std::size_t quads = asset_->evaluatedQuads(channel_, sunlit_); quads_ < quads) {
        quads_ = quads;
        makeRoom();
    }
    uploadPoses(characters);
    uploadVertices(characters);
    uploadCoefficients(characters);
    gl::MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);  // after what the last frame's draws read
    const bool casts = cast && showsVisibility(channel);
    if (casts) castOnVertices(*cast, *characters.front().evaluator);
    bind();
    if (showsVisibility(channel) && asset_->evaluatesFar()) evaluateAnchors();
    if (casts) gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kCastsBinding, casts_->id());
    const GlAsset::Program& program = asset_->evaluateProgram(channel, casts ? cast->castSets() : 0, sunlit_);
    gl::UseProgram(program.program.id());
    gl::Uniform3f(program.eye, eye.x, eye.y, eye.z);
    dispatch(program, asset_->vertexCount());
    gl::MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    release();
    checkGl("evaluating");
}

void ModelPainter::draw(const FrameView& view, const Sunlight* suns) const {
    if (count_ == 0) return;
    assert(!sunlit_ || suns);
    const GlAsset::Program& program = asset_->drawProgram(channel_, sunlit_ ? suns->models() : 0);
    setView(program.program, program.view, view);
    if (sunlit_) suns->bind(program.sunlight, view);
    gl::Uniform1i(program.vertex_count, GLint(asset_->vertexCount()));
    gl::ActiveTexture(GL_TEXTURE0);
    gl::BindTexture(GL_TEXTURE_BUFFER, evaluated_.texture.id());
    asset_->draw(channel_, program, count_);
    checkGl("drawing");
}

}  // namespace penumbra
