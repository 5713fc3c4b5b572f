#include "player/scene/scene_field.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <utility>

#include "formats/common/errors.h"
#include "formats/common/find_by_name.h"
#include "formats/common/parallel_for.h"
#include "player/runtime/shade/indirect_light.h"

namespace penumbra {

namespace {

constexpr std::size_t kFieldPiece = 512;  // points that a thread takes at once

std::size_t fieldPieces(std::size_t count) { return (count + kFieldPiece - 1) / kFieldPiece; }

CastReceivers fieldPiece(const CastReceivers& all, std::size_t piece) {
    const std::size_t first = piece * kFieldPiece, n = std::min(kFieldPiece, all.positions.size() - first);
    return {all.positions.subspan(first, n), all.normals.subspan(first, n), all.tangents.subspan(first, n)};
}

}  // namespace

SceneField::SceneField(const SceneGround& ground, GroundHeights heights)
    : heights_(std::move(heights)),
      visibility_(heights_.field(), ground.heights->order, ground.heights->step),
      above_(heights_.field(), kAboveFieldOrder, kFieldOrder),
      product_(visibility_.convention()) {}

void SceneField::wake(std::span<const TexelBox> changed) {
    if (changed.empty() || changed[0].empty()) return;
    visibility_.wake(heights_.field(), changed);
    ++version_;
    changed_.resize(changed.size());
    for (std::size_t l = 0; l < changed.size(); ++l) include(changed_[l], changed[l]);
}

std::vector<TexelBox> SceneField::takeChanged() { return std::exchange(changed_, {}); }

void SceneField::brush(Vec3 at, float radius, float rise) {
    const HeightField& field = heights_.field();
    const Vec3 place = at - heights_.corner();
    const TexelBox box =
        strokeHeights(field, {place.z / field.grid().cell_x, place.x / field.grid().cell_y, radius, rise}, brushed_);
    if (!box.empty()) set(box, brushed_);
}

// At most kFieldPiece points.
void SceneField::castOnRun(const CastShadow& cast, const CastReceivers& some, std::span<float> numbers) const {
    std::array<float, kFieldPiece * kFarNumbers> mirrored;
    const std::span<float> used = std::span(mirrored).first(some.positions.size() * kFarNumbers);
    if (cast.evaluate(some, {}, used) > 0) product_(numbers, kFieldStride, used);
}

void SceneField::castOn(const CastShadow& cast, int threads, FrameVertices& points) const {
    if (cast.casterCount() == 0) return;
    const CastReceivers all{points.positions, points.normals, points.tangents};
    parallelFor(fieldPieces(points.positions.size()), threads, [&](std::size_t piece) {
        const CastReceivers some = fieldPiece(all, piece);
        castOnRun(cast, some,
                  std::span(points.numbers)
                      .subspan(piece * kFieldPiece * kFieldStride, some.positions.size() * kFieldStride));
    });
}

// Points of a row, which are at most HeightVisibility::kMostPoints.
void SceneField::updateRun(const CastShadow& cast, int row, int first, std::size_t count, FrameVertices& points) const {
    const HeightField& field = heights_.field();
    const std::size_t at = std::size_t(row) * std::size_t(field.grid().columns) + std::size_t(first);
    const std::span positions = std::span(points.positions).subspan(at, count),
                    normals = std::span(points.normals).subspan(at, count),
                    tangents = std::span(points.tangents).subspan(at, count);
    const std::span<float> numbers = std::span(points.numbers).subspan(at * kFieldStride, count * kFieldStride);
    visibility_.numbers(field, row, first, normals, tangents, kFieldStride, numbers);
    for (std::size_t i = 0; i < count; ++i) {
        positions[i] = heights_.point(row, first + int(i));
        normals[i] = sceneFromField(normals[i]);
        tangents[i] = sceneFromField(tangents[i]);
    }
    if (cast.casterCount() > 0) castOnRun(cast, {positions, normals, tangents}, numbers);
}

std::size_t SceneField::update(const CastShadow& cast, bool anew, int threads, FrameVertices& points) {
    const HeightField& field = heights_.field();
    const HeightGrid& grid = field.grid();
    for (std::vector<Vec3>* list : {&points.positions, &points.normals, &points.tangents}) list->resize(grid.size());
    points.numbers.resize(grid.size() * kFieldStride);
    parallelFor(visibility_.receiverRows(), threads, [&](std::size_t r) { visibility_.evaluate(field, r, r + 1); });
    const HeightReceivers& receivers = visibility_.receivers();
    const std::size_t columns = std::size_t(grid.columns), step = std::size_t(receivers.step());
    std::atomic<std::size_t> updated = 0;
    parallelFor(std::size_t(grid.rows), threads, [&](std::size_t r) {
        const auto isStale = [&](std::size_t c) { return anew || receivers.isStale(r / step, c / step); };
        for (std::size_t first = 0, end; first < columns; first = end) {
            end = first;
            while (end < columns && end < first + HeightVisibility::kMostPoints && isStale(end)) ++end;
            if (end > first) updateRun(cast, int(r), int(first), end - first, points);
            updated += end - first;
            while (end < columns && !isStale(end)) ++end;
        }
    });
    visibility_.freshen();
    return updated;
}

void SceneField::visibleFrom(const CastReceivers& receivers, std::span<float> mirrored) const {
    fieldVisibility(heights_.field(), above_, heights_.corner(), receivers, mirrored);
}

void SceneField::shadow(const CastReceivers& receivers, const ModelView& model, int threads, std::span<float> numbers,
                        std::span<float> indirect) const {
    const CastProduct product(model.convention);
    const auto stride = std::size_t(model.stride);
    parallelFor(fieldPieces(receivers.positions.size()), threads, [&](std::size_t piece) {
        const CastReceivers some = fieldPiece(receivers, piece);
        std::array<float, kFieldPiece * kFarNumbers> mirrored;
        const std::span<float> used = std::span(mirrored).first(some.positions.size() * kFarNumbers);
        visibleFrom(some, used);
        product(numbers.subspan(piece * kFieldPiece * stride, some.positions.size() * stride), stride, used);
        if (!indirect.empty())
            castOnIndirect(
                used, indirect.subspan(piece * kFieldPiece * kIndirectStride, some.positions.size() * kIndirectStride));
    });
}

namespace {

// Returns null where the ground is Lambertian.
const MaterialView* fieldMaterial(const SceneGround& ground, const AssetView& asset) {
    if (ground.material.empty()) return nullptr;
    try {
        const std::string what = ground.heights->source.at + ": the ground's material";
        return &asset.materials[findByName(asset.materials, ground.material, what)];
    } catch (const UsageError& error) {
        throw InvalidInput(error.what());
    }
}

}  // namespace

FieldLook::FieldLook(const SceneGround& ground, const Convention& convention, const AssetView& asset,
                     const LightView& light) {
    const LambertMaterial lambert(ground.albedo);
    const MaterialView* material = fieldMaterial(ground, asset);
    shader_.emplace(convention, kFieldStride, material ? *material : lambert.view, light);
}

FieldShading::FieldShading(const SceneGround& ground, const Convention& convention, const AssetView& asset,
                           const LightView& light)
    : lambert_(ground.albedo) {
    const MaterialView* material = fieldMaterial(ground, asset);
    view_.has_model = true;
    view_.model.convention = convention;
    view_.model.stride = kFieldStride;
    view_.materials = {material ? *material : lambert_.view};
    view_.materials.front().membrane.reset();  // a field has no other side
    view_.lights = {light};
    view_.slot_material = {0};
    set_.emplace(view_);
}

std::vector<BrdfLobe> fieldLobes(const SceneGround& ground, const AssetView& asset) {
    const MaterialView* material = fieldMaterial(ground, asset);
    if (!material || material->lobes.empty()) return {{BrdfModel::kLambert, {}, ground.albedo}};
    return {material->lobes.begin(), material->lobes.end()};
}

void FieldLook::shade(const FrameVertices& points, Vec3 eye, int threads, std::vector<Vec3>& radiance) const {
    radiance.resize(points.positions.size());
    parallelFor(fieldPieces(radiance.size()), threads, [&](std::size_t piece) {
        const std::size_t first = piece * kFieldPiece, end = std::min(first + kFieldPiece, radiance.size());
        shader_->shade(first, end, points.positions, points.normals, points.tangents, points.numbers, eye, radiance);
        for (std::size_t v = first; v < end; ++v)
            for (int c = 0; c < 3; ++c) radiance[v][c] = std::max(radiance[v][c], 0.0f);
    });
}

std::vector<float> fieldAmbient(const Convention& convention, const FrameVertices& points) {
    std::vector<float> e(points.positions.size());
    ambient(convention, kFieldStride, 0, e.size(), points.numbers, e);
    return e;
}

}  // namespace penumbra
