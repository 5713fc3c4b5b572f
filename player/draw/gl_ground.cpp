#include "player/draw/gl_ground.h"

#include <array>
#include <cassert>

#include "player/draw/shader_source.h"

namespace penumbra {

namespace {

constexpr BrdfModels kPaint = 1u << int(BrdfModel::kLambert);
constexpr GLuint kGroundReceivers = 3, kGroundCasts = 4, kGroundEvaluated = 5;

GlObject makeReceivers(const GroundMesh& mesh) {
    std::vector<float> quads;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const Vec3 p = mesh.positions[v], n = mesh.normals[v], t = mesh.tangents[v];
        quads.insert(quads.end(), {p.x, p.y, p.z, -1, n.x, n.y, n.z, 0, t.x, t.y, t.z, 0});
    }
    return makeBuffer(GL_SHADER_STORAGE_BUFFER, std::span<const float>(quads));
}

}  // namespace

GlGround::GlGround(const GroundMesh& mesh, Channel channel, std::optional<SlotLobes> lobes)
    : mesh_(mesh.triangles, mesh.positions.size(), channel, lobes ? kPaint : 0),
      lobes_(lobes),
      receivers_(makeReceivers(mesh)),
      evaluate_(makeComputeProgram(groundSource(lobes.has_value()))),
      weights_(gl::GetUniformLocation(evaluate_.id(), "weights")),
      receiver_count_(gl::GetUniformLocation(evaluate_.id(), "receiver_count")) {
    const std::size_t bytes = mesh_.vertices() * kCastQuads * 4 * sizeof(float);
    checkStorageBlock("the ground", bytes);
    casts_ = makeStorage(bytes);
    checkGl("uploading the ground");
}

void GlGround::evaluate(GlCast& cast, std::span<const Vec3> weights) {
    assert(weights.size() == kMirroredCast);
    cast.cast(receivers_, casts_, mesh_.vertices(), true);
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kGroundReceivers, receivers_.id());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kGroundCasts, casts_.id());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kGroundEvaluated, mesh_.values().id());
    gl::UseProgram(evaluate_.id());
    std::array<float, 4 * kMirroredCast> quads{};
    for (std::size_t i = 0; i < kMirroredCast; ++i)
        for (int c = 0; c < 3; ++c) quads[4 * i + std::size_t(c)] = weights[i][c];
    gl::Uniform4fv(weights_, GLsizei(kMirroredCast), quads.data());
    gl::Uniform1ui(receiver_count_, GLuint(mesh_.vertices()));
    if (lobes_) gl::Uniform3f(gl::GetUniformLocation(evaluate_.id(), "lobes"), lobes_->first, lobes_->count, 0);
    gl::DispatchCompute(GLuint((mesh_.vertices() + kWorkGroup - 1) / kWorkGroup), 1, 1);
    gl::MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    checkGl("casting on the ground");
}

}  // namespace penumbra
