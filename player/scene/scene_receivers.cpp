#include "player/scene/scene_receivers.h"

#include <algorithm>

#include "formats/common/parallel_for.h"
#include "player/runtime/cast_product.h"
#include "player/scene/cast_on.h"

namespace penumbra {

bool castOnNumbers(const CastShadow& cast, CasterChoice choice, const CastReceivers& receivers, const ModelView& model,
                   int threads, std::span<float> numbers) {
    thread_local std::vector<float> mirrored;  // a megabyte, which is not to be mapped anew in every frame
    if (castOn(cast, choice, receivers, threads, mirrored) == 0) return false;
    constexpr std::size_t kPiece = 512;  // vertices that a thread takes at once
    const CastProduct product(model.convention);
    const std::span<const float> others(mirrored);  // other threads have a `mirrored` of their own
    const std::size_t count = receivers.positions.size(), stride = std::size_t(model.stride);
    parallelFor((count + kPiece - 1) / kPiece, threads, [&](std::size_t piece) {
        const std::size_t first = piece * kPiece, n = std::min(kPiece, count - first);
        product(numbers.subspan(first * stride, n * stride), stride,
                others.subspan(first * kFarNumbers, n * kFarNumbers));
    });
    return true;
}

void skinMember(const SceneMember& member, int threads, FrameVertices& vertices) {
    skinFrame(member.evaluator, threads, vertices);
    const Mat3 turn = member.to_scene.linear();
    for (Vec3& p : vertices.positions) p = member.to_scene.point(p);
    for (std::vector<Vec3>* directions : {&vertices.normals, &vertices.tangents})
        for (Vec3& d : *directions) d = turn * d;
}

void ownVertices(const SceneMember& member, int threads, FrameVertices& vertices) {
    skinMember(member, threads, vertices);
    evaluateNumbers(member.evaluator, threads, vertices);
}

void memberVertices(const PosedScene& scene, std::size_t index, int threads, FrameVertices& vertices) {
    const SceneMember& member = *scene.members()[index];
    ownVertices(member, threads, vertices);
    castOnNumbers(scene.cast(), {.except = member.caster}, {vertices.positions, vertices.normals, vertices.tangents},
                  member.asset->view.model, threads, vertices.numbers);
}

FrameVertices memberVertices(const PosedScene& scene, std::size_t index, int threads) {
    FrameVertices vertices;
    memberVertices(scene, index, threads, vertices);
    return vertices;
}

}  // namespace penumbra
