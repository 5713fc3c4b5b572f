#include "player/scene/scene_field.h"

#include <algorithm>
#include <array>
#include <utility>

#include "formats/common/errors.h"
#include "formats/common/find_by_name.h"
#include "formats/common/parallel_for.h"
#include "player/scene/cast_blocks.h"
#include "runtime/shade/indirect_light.h"

namespace penumbra {

namespace {

constexpr std::size_t kFieldPiece = 512;  // points that a thread takes at once
constexpr int kBandRows = 16;             // as well, where others cast by blocks

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
      product_(visibility_.convention()) {
    visibility_.setTolerance(float(ground.heights->refine));
}

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

// Points of columns [first, end) of a tile.
void SceneField::updateTile(const HeightRefined& refined, int first, int end, FrameVertices& points) const {
    const HeightField& field = heights_.field();
    for (int row = refined.first_row; row < refined.end_row; ++row) {
        const std::size_t at = std::size_t(row) * std::size_t(field.grid().columns) + std::size_t(first),
                          count = std::size_t(end - first);
        const std::span positions = std::span(points.positions).subspan(at, count),
                        normals = std::span(points.normals).subspan(at, count),
                        tangents = std::span(points.tangents).subspan(at, count);
        visibility_.coefficients(field, row, first, normals, tangents, kFieldStride,
                                 std::span(points.coefficients).subspan(at * kFieldStride, count * kFieldStride),
                                 &refined);
        for (std::size_t i = 0; i < count; ++i) {
            positions[i] = heights_.point(row, first + int(i));
            normals[i] = sceneFromField(normals[i]);
            tangents[i] = sceneFromField(tangents[i]);
        }
    }
}

namespace {

// Points a side that are computed together: whole cells between receivers, and whole blocks of casts.
int unitOf(int step) { return std::max(step, int(kCastBlock)); }
int unitsIn(int count, int unit) { return (count + unit - 1) / unit; }

}  // namespace

bool SceneField::isStale(int row, int column) const {
    const int unit = unitOf(visibility_.step());
    return stale_[std::size_t(row / unit * unitsIn(heights_.field().grid().columns, unit) + column / unit)] != 0;
}

// Of the units of one row of them.
void SceneField::findStale(FieldPoints old, int first_row) {
    const HeightGrid& grid = heights_.field().grid();
    const int step = visibility_.step(), unit = unitOf(step), across = unitsIn(grid.columns, unit);
    for (int u = 0; u < across; ++u) {
        bool surely = old == FieldPoints::kNew, perhaps = false;
        for (int r = first_row; r < std::min(first_row + unit, grid.rows); r += step)
            for (int c = u * unit; c < std::min((u + 1) * unit, grid.columns) && !surely; c += step) {
                const auto row = std::size_t(r / step), column = std::size_t(c / step);
                surely = visibility_.receivers().isStale(row, column);
                perhaps = perhaps || (!surely && visibility_.isStale(heights_.field(), row, column));
            }
        // Smaller cells are several to a unit, which is computed as a whole.
        const bool counts = surely || (perhaps && step < unit);
        stale_[std::size_t(first_row / unit * across + u)] = counts ? 2 : perhaps ? 1 : 0;
    }
}

// One band of cells.
void SceneField::updateBand(int first_row, FrameVertices& points) {
    const int columns = heights_.field().grid().columns, step = visibility_.step(), unit = unitOf(step);
    std::uint8_t* const stale = &stale_[std::size_t(first_row / unit * unitsIn(columns, unit))];
    std::uint64_t* const finer = &finer_[std::size_t(first_row / step) * visibility_.receivers().columns()];
    HeightRefined refined;
    for (int first = 0, end; first < columns; first = end) {
        for (end = first; end < columns && end < first + HeightRefined::kColumns && stale[end / unit];) end += unit;
        end = std::min(end, columns);
        if (end > first) visibility_.refine(heights_.field(), first_row, first, end, refined);
        for (int c = first; c < end; c += step) {
            const std::uint64_t key = visibility_.finerKey(refined, first_row, c);
            if (stale[c / unit] == 1) stale[c / unit] = key == finer[c / step] ? 0 : 2;
            finer[c / step] = key;
        }
        for (int c = first, tile; c < end; c = tile) {
            for (tile = c; tile < end && stale[tile / unit];) tile += unit;
            tile = std::min(tile, end);
            if (tile > c) updateTile(refined, c, tile, points);
            while (tile < end && !stale[tile / unit]) tile += unit;
        }
        while (end < columns && !stale[end / unit]) end += unit;
    }
}

std::size_t SceneField::update(const CastShadow& cast, FieldPoints old, int threads, FrameVertices& points) {
    const HeightField& field = heights_.field();
    const HeightGrid& grid = field.grid();
    for (std::vector<Vec3>* list : {&points.positions, &points.normals, &points.tangents}) list->resize(grid.size());
    points.coefficients.resize(grid.size() * kFieldStride);
    parallelFor(visibility_.receiverRows(), threads, [&](std::size_t r) { visibility_.evaluate(field, r, r + 1); });
    const int step = visibility_.step(), unit = unitOf(step), across = unitsIn(grid.columns, unit);
    stale_.resize(std::size_t(unitsIn(grid.rows, unit) * across));
    finer_.resize(visibility_.receiverCount());
    parallelFor(std::size_t(unitsIn(grid.rows, unit)), threads, [&](std::size_t units) {
        const int first_row = int(units) * unit;
        findStale(old, first_row);
        for (int row = first_row; row < std::min(first_row + unit, grid.rows); row += step) updateBand(row, points);
    });
    visibility_.freshen();
    castOnStale(cast, threads, points);
    std::size_t updated = 0;
    for (int r = 0; r < grid.rows; r += unit)
        for (int c = 0; c < grid.columns; c += unit)
            if (isStale(r, c)) updated += std::size_t(std::min(unit, grid.rows - r) * std::min(unit, grid.columns - c));
    return updated;
}

void SceneField::castOn(const CastShadow& cast, int threads, FrameVertices& points) {
    std::ranges::fill(stale_, std::uint8_t(1));
    castOnStale(cast, threads, points);
}

void SceneField::castOnStale(const CastShadow& cast, int threads, FrameVertices& points) const {
    const HeightGrid& grid = heights_.field().grid();
    if (cast.casterCount() == 0) return;
    // Every point is within half a block of one that is evaluated, but a smaller caster may stand between these.
    if (float(kCastBlock) * std::max(grid.cell_x, grid.cell_y) > 2 * cast.smallestCaster())
        parallelFor(std::size_t(grid.rows), threads, [&](std::size_t row) { castOnRow(cast, int(row), points); });
    else
        // The last band has the last row, too, so that no band is without squares.
        parallelFor(std::size_t(std::max(unitsIn(grid.rows - 1, kBandRows), 1)), threads,
                    [&](std::size_t band) { castOnBand(cast, int(band) * kBandRows, points); });
}

// Casts on each point for itself.
void SceneField::castOnRow(const CastShadow& cast, int row, FrameVertices& points) const {
    const int columns = heights_.field().grid().columns, unit = unitOf(visibility_.step());
    std::array<float, kFieldPiece * kFarCoefficients> mirrored;
    for (int first = 0, end; first < columns; first = end) {
        for (end = first; end < columns && end < first + int(kFieldPiece) && isStale(row, end);) end += unit;
        end = std::min(end, columns);
        const std::size_t at = std::size_t(row) * std::size_t(columns) + std::size_t(first),
                          count = std::size_t(end - first);
        const std::span<float> used = std::span(mirrored).first(count * kFarCoefficients);
        const CastReceivers some{std::span(points.positions).subspan(at, count),
                                 std::span(points.normals).subspan(at, count),
                                 std::span(points.tangents).subspan(at, count)};
        if (count > 0 && cast.evaluate(some, {}, used) > 0)
            product_(std::span(points.coefficients).subspan(at * kFieldStride, count * kFieldStride), kFieldStride,
                     used);
        while (end < columns && !isStale(row, end)) end += unit;
    }
}

// Casts on kBandRows rows by blocks. The far edge of the last blocks is a row of the next band.
void SceneField::castOnBand(const CastShadow& cast, int first_row, FrameVertices& points) const {
    const HeightGrid& field = heights_.field().grid();
    const int last_row = std::min(first_row + kBandRows, field.rows - 1);
    const auto columns = std::size_t(field.columns), rows = std::size_t(last_row - first_row + 1);
    const std::size_t at = std::size_t(first_row) * columns;
    thread_local std::vector<float> mirrored;
    mirrored.resize(rows * columns * kFarCoefficients);
    const CastGrid grid{
        std::uint32_t(rows),
        std::uint32_t(columns),
        {std::span(points.positions).subspan(at, rows * columns), std::span(points.normals).subspan(at, rows * columns),
         std::span(points.tangents).subspan(at, rows * columns)},
        mirrored};
    std::vector<CastBlock> blocks = castBlocks(grid.rows, grid.columns);
    // The last column belongs to the last blocks, and so does the last row of the field.
    const auto isWanted = [&](const CastBlock& block) {
        for (const std::uint32_t r : {block.low[0], block.high[0]})
            for (const std::uint32_t c : {block.low[1], block.high[1]})
                if (isStale(first_row + int(r), int(c))) return true;
        return false;
    };
    for (CastBlock& block : blocks) block.wanted = isWanted(block);
    castOnBlocks(cast, grid, blocks, 1);
    thread_local std::vector<std::uint8_t> seen;  // of a point: it is stale and sees somebody
    seen.assign(rows * columns, 0);
    for (const CastBlock& block : blocks) {
        if (!block.wanted || !block.seen) continue;
        const std::uint32_t end_row = block.high[0] + (first_row + int(block.high[0]) + 1 == field.rows),
                            end_column = block.high[1] + (block.high[1] + 1 == columns);
        for (std::uint32_t r = block.low[0]; r < end_row; ++r)
            for (std::uint32_t c = block.low[1]; c < end_column; ++c)
                seen[r * columns + c] = isStale(first_row + int(r), int(c));
    }
    for (std::size_t first = 0, end; first < seen.size(); first = end) {
        for (end = first; end < seen.size() && seen[end];) ++end;
        product_(std::span(points.coefficients).subspan((at + first) * kFieldStride, (end - first) * kFieldStride),
                 kFieldStride, std::span(mirrored).subspan(first * kFarCoefficients, (end - first) * kFarCoefficients));
        while (end < seen.size() && !seen[end]) ++end;
    }
}

void SceneField::visibleFrom(const CastReceivers& receivers, std::span<float> mirrored) const {
    fieldVisibility(heights_.field(), above_, heights_.corner(), receivers, mirrored);
}

void SceneField::shadow(const CastReceivers& receivers, const ModelView& model, int threads,
                        std::span<float> coefficients, std::span<float> indirect) const {
    const CastProduct product(model.convention);
    const auto stride = std::size_t(model.stride);
    parallelFor(fieldPieces(receivers.positions.size()), threads, [&](std::size_t piece) {
        const CastReceivers some = fieldPiece(receivers, piece);
        std::array<float, kFieldPiece * kFarCoefficients> mirrored;
        const std::span<float> used = std::span(mirrored).first(some.positions.size() * kFarCoefficients);
        visibleFrom(some, used);
        product(coefficients.subspan(piece * kFieldPiece * stride, some.positions.size() * stride), stride, used);
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
        const std::string what = ground.heights->source.at + ": the \"material\" beside them";
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
    if (!material) return {{BrdfModel::kLambert, {}, ground.albedo}};
    return {material->lobes.begin(), material->lobes.end()};
}

void FieldLook::shade(const FrameVertices& points, Vec3 eye, int threads, std::vector<Vec3>& radiance) const {
    radiance.resize(points.positions.size());
    parallelFor(fieldPieces(radiance.size()), threads, [&](std::size_t piece) {
        const std::size_t first = piece * kFieldPiece, end = std::min(first + kFieldPiece, radiance.size());
        shader_->shade(points.range(first, end), eye, radiance);
        for (std::size_t v = first; v < end; ++v)
            for (int c = 0; c < 3; ++c) radiance[v][c] = std::max(radiance[v][c], 0.0f);
    });
}

std::vector<float> fieldAmbient(const Convention& convention, const FrameVertices& points) {
    std::vector<float> e(points.positions.size());
    ambient(convention, kFieldStride, points.coefficients, e);
    return e;
}

}  // namespace penumbra
