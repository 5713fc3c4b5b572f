#include "player/scene/scene_receivers.h"

#include "player/runtime/cast_product.h"
#include "player/scene/cast_on.h"

namespace penumbra {

namespace {

void multiply(const ModelView& model, std::span<const float> mirrored, FrameVertices& vertices) {
    const CastProduct product(model.convention);
    for (std::size_t v = 0; v < vertices.positions.size(); ++v)
        product(
            std::span(vertices.numbers).subspan(v * std::size_t(model.stride), std::size_t(model.convention.size())),
            mirrored.subspan(v * kFarNumbers, kFarNumbers));
}

}  // namespace

FrameVertices memberVertices(const PosedScene& scene, std::size_t index, int threads) {
    const SceneMember& member = *scene.members()[index];
    FrameVertices vertices;
    skinFrame(member.evaluator, threads, vertices);
    evaluateNumbers(member.evaluator, threads, vertices);
    const Mat3 turn = member.to_scene.linear();
    for (Vec3& p : vertices.positions) p = member.to_scene.point(p);
    for (std::vector<Vec3>* directions : {&vertices.normals, &vertices.tangents})
        for (Vec3& d : *directions) d = turn * d;
    std::vector<float> mirrored;
    if (castOn(scene.cast(), {.except = member.caster}, {vertices.positions, vertices.normals, vertices.tangents},
               threads, mirrored) > 0)
        multiply(member.asset->view.model, mirrored, vertices);
    return vertices;
}

}  // namespace penumbra
