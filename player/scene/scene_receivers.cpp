#include "player/scene/scene_receivers.h"

#include <algorithm>
#include <array>

#include "formats/common/parallel_for.h"
#include "player/scene/cast_on.h"
#include "runtime/cast/cast_product.h"
#include "runtime/cast/ground_shadow.h"
#include "runtime/shade/indirect_light.h"
#include "runtime/shade/shading.h"

namespace penumbra {

bool castOnCoefficients(const CastShadow& cast, CasterChoice choice, const Evaluator& character,
                        const CastReceivers& vertices, int threads, std::span<float> coefficients,
                        std::span<float> indirect) {
    thread_local std::vector<float> mirrored;  // a megabyte, which is not to be mapped anew in every frame
    if (castOnCharacter(cast, choice, character, vertices, threads, mirrored) == 0) return false;
    constexpr std::size_t kVertexPiece = 512;  // vertices that a thread takes at once
    const ModelView& model = character.asset().model;
    const CastProduct product(model.convention);
    const std::span<const float> others(mirrored);  // other threads have a `mirrored` of their own
    const std::size_t count = vertices.positions.size(), stride = std::size_t(model.stride);
    parallelFor((count + kVertexPiece - 1) / kVertexPiece, threads, [&](std::size_t piece) {
        const std::size_t first = piece * kVertexPiece, n = std::min(kVertexPiece, count - first);
        product(coefficients.subspan(first * stride, n * stride), stride,
                others.subspan(first * kFarCoefficients, n * kFarCoefficients));
        if (!indirect.empty())
            castOnIndirect(others.subspan(first * kFarCoefficients, n * kFarCoefficients),
                           indirect.subspan(first * kIndirectStride, n * kIndirectStride));
    });
    return true;
}

namespace {

void moveToScene(const SceneMember& member, FrameVertices& vertices) {
    const Mat3 turn = member.to_scene.linear();
    for (Vec3& p : vertices.positions) p = member.to_scene.point(p);
    for (std::vector<Vec3>* directions : {&vertices.normals, &vertices.tangents})
        for (Vec3& d : *directions) d = turn * d;
}

}  // namespace

void skinMember(const SceneMember& member, int threads, FrameVertices& vertices) {
    skinFrame(member.evaluator, threads, vertices);
    moveToScene(member, vertices);
}

void ownVertices(const SceneMember& member, int threads, FrameVertices& vertices) {
    skinFrame(member.evaluator, threads, vertices);
    evaluateSkinned(member.evaluator, threads, vertices);
    evaluateIndirect(member.evaluator, threads, vertices.indirect);
    moveToScene(member, vertices);
}

void castGround(const ModelView& model, const CastReceivers& vertices, int threads, std::span<float> coefficients) {
    const CastProduct product(model.convention);
    const std::size_t count = vertices.normals.size(), stride = std::size_t(model.stride);
    parallelFor((count + kMaxReceivers - 1) / kMaxReceivers, threads, [&](std::size_t piece) {
        std::array<float, kMaxReceivers * kFarCoefficients> mirrored;
        const std::size_t first = piece * kMaxReceivers, n = std::min(kMaxReceivers, count - first);
        const std::span<float> used = std::span(mirrored).first(n * kFarCoefficients);
        groundVisibility(vertices.normals.subspan(first, n), vertices.tangents.subspan(first, n), used);
        product(coefficients.subspan(first * stride, n * stride), stride, used);
    });
}

namespace {

// Writes E of all vertices.
void ambientOfAll(const ModelView& model, std::span<const float> coefficients, int threads, std::vector<float>& e) {
    constexpr std::size_t kAmbientPiece = 2048;  // vertices that a thread takes at once
    const auto stride = std::size_t(model.stride);
    e.resize(coefficients.size() / stride);
    parallelFor((e.size() + kAmbientPiece - 1) / kAmbientPiece, threads, [&](std::size_t piece) {
        const std::size_t first = piece * kAmbientPiece, n = std::min(kAmbientPiece, e.size() - first);
        ambient(model.convention, model.stride, coefficients.subspan(first * stride, n * stride),
                std::span(e).subspan(first, n));
    });
}

// Replaces E of before by what E has lost since, and writes what is left.
void subtractAmbient(const ModelView& model, std::span<const float> coefficients, int threads,
                     std::vector<float>& before, std::vector<float>& after) {
    ambientOfAll(model, coefficients, threads, after);
    for (std::size_t v = 0; v < before.size(); ++v) before[v] = std::max(before[v] - after[v], 0.0f);
}

}  // namespace

void castOthers(const OthersAround& others, const Evaluator& character, const CastReceivers& vertices, int threads,
                CastCoefficients coefficients, HiddenSky* hidden) {
    const ModelView& model = character.asset().model;
    thread_local std::vector<float> after;
    if (hidden) {
        ambientOfAll(model, coefficients.coefficients, threads, after);
        hidden->by_others.clear();
        hidden->by_ground.clear();
    }
    const bool casts = others.cast.casterCount() > 0;
    if (hidden && casts) hidden->by_others = after;
    const bool seen = casts && castOnCoefficients(others.cast, others.choice, character, vertices, threads,
                                                  coefficients.coefficients, coefficients.indirect);
    if (hidden && seen)
        subtractAmbient(model, coefficients.coefficients, threads, hidden->by_others, after);
    else if (hidden)
        hidden->by_others.clear();
    if (others.heights)
        others.heights->shadow(vertices, model, threads, coefficients.coefficients, coefficients.indirect);
    if (!others.level_ground) return;
    if (hidden) hidden->by_ground = after;
    castGround(model, vertices, threads, coefficients.coefficients);
    if (hidden) subtractAmbient(model, coefficients.coefficients, threads, hidden->by_ground, after);
}

void castOthers(const PosedScene& scene, const SceneMember& member, int threads, FrameVertices& vertices,
                HiddenSky* hidden) {
    castOthers({scene.cast(), {.except = member.caster}, scene.field(), scene.groundCasts()}, member.evaluator,
               {vertices.positions, vertices.normals, vertices.tangents}, threads,
               {vertices.coefficients, vertices.indirect}, hidden);
}

void memberVertices(const PosedScene& scene, std::size_t index, int threads, FrameVertices& vertices,
                    HiddenSky* hidden) {
    const SceneMember& member = *scene.members()[index];
    ownVertices(member, threads, vertices);
    castOthers(scene, member, threads, vertices, hidden);
}

FrameVertices memberVertices(const PosedScene& scene, std::size_t index, int threads) {
    FrameVertices vertices;
    memberVertices(scene, index, threads, vertices);
    return vertices;
}

}  // namespace penumbra
