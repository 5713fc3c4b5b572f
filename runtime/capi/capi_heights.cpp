// The part of penumbra.h that handles height fields.
#include <algorithm>
#include <array>
#include <cmath>

#include "runtime/capi/capi_handles.h"
#include "runtime/shade/lambert_material.h"
#include "sh/height/field_in_scene.h"

namespace penumbra {

namespace {

HeightGrid gridOf(const penumbra_heights_options& options) {
    if (int(options.border) < 0 || int(options.border) > PENUMBRA_BORDER_OPEN)
        throw UsageError("border is no penumbra_height_border");
    for (const auto& [name, side] : {std::pair{"rows", options.rows}, {"columns", options.columns}})
        if (side > std::size_t(kMaxHeightSide)) throw UsageError(std::string(name) + " is more than 65536");
    constexpr HeightBorder kBorders[] = {HeightBorder::kClamped, HeightBorder::kPeriodic, HeightBorder::kOpen};
    const HeightGrid grid{int(options.rows), int(options.columns), options.cell_z, options.cell_x,
                          kBorders[options.border]};
    if (const std::string problem = findProblem(grid); !problem.empty()) throw UsageError(problem);
    return grid;
}

void requireHeights(std::span<const float> heights) {
    for (std::size_t i = 0; i < heights.size(); ++i)
        if (!(std::abs(heights[i]) <= kMaxElevation))
            throw UsageError("heights[" + std::to_string(i) + "] is not finite or beyond 1e7");
}

// One row of points, or a part of one.
void writePoints(const penumbra_heights& field, int row, int first, std::size_t count, const HeightRefined& refined,
                 const penumbra_vertices& points) {
    std::array<Vec3, HeightVisibility::kMaxPoints> n, t;
    std::array<float, HeightVisibility::kMaxPoints * PENUMBRA_HEIGHTS_STRIDE> own;
    const std::span<Vec3> some_n = std::span(n).first(count), some_t = std::span(t).first(count);
    const HeightGrid& grid = field.field.grid();
    const std::size_t at = std::size_t(row) * std::size_t(grid.columns) + std::size_t(first);
    const std::span<float> out(points.coefficients ? points.coefficients + at * PENUMBRA_HEIGHTS_STRIDE : own.data(),
                               count * PENUMBRA_HEIGHTS_STRIDE);
    field.visibility.coefficients(field.field, row, first, some_n, some_t, PENUMBRA_HEIGHTS_STRIDE, out, &refined);
    const std::size_t all = grid.size();
    for (std::size_t i = 0; i < count; ++i) {
        const float height = field.field.heights()[at + i];
        if (points.positions)
            vectors(points.positions, all)[at + i] =
                field.corner + Vec3{float(first + int(i)) * grid.cell_y, height, float(row) * grid.cell_x};
        if (points.normals) vectors(points.normals, all)[at + i] = sceneFromField(n[i]);
        if (points.tangents) vectors(points.tangents, all)[at + i] = sceneFromField(t[i]);
    }
}

// Returns points of the field for shading or casting.
VertexFrames pointsOf(const penumbra_heights& field, const penumbra_vertices* points) {
    requireCoefficients(points);
    return framesOf(points, field.field.grid().size(), PENUMBRA_HEIGHTS_STRIDE);
}

}  // namespace

}  // namespace penumbra

using namespace penumbra;

penumbra_status penumbra_heights_create(const penumbra_heights_options* options, const float* heights,
                                        penumbra_heights** field, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(options, "options", heights, "heights", field, "field");
        const HeightGrid grid = gridOf(*options);
        requireFinite("corner", {options->corner, 3});
        const int order = options->order == 0 ? kMaxHeightOrder : options->order,
                  step = options->step == 0 ? 4 : options->step;
        if (order < kMinHeightOrder || order > kMaxHeightOrder) throw UsageError("order is neither 0, 4 nor 5");
        if (step < 1 || step > 8 || (step & (step - 1))) throw UsageError("step is none of 0, 1, 2, 4 and 8");
        requireHeights({heights, grid.size()});
        const HeightField made(grid, {heights, grid.size()});
        HeightVisibility visibility(made, order, step);
        HeightTables above(made, kAboveFieldOrder, kFieldOrder);
        const Convention convention = visibility.convention();
        *field = new penumbra_heights{made,
                                      std::move(visibility),
                                      std::move(above),
                                      {options->corner[0], options->corner[1], options->corner[2]},
                                      CastProduct(convention),
                                      nullptr,
                                      std::nullopt};
    });
}

void penumbra_heights_destroy(penumbra_heights* field) { delete field; }

penumbra_status penumbra_heights_set_tolerance(penumbra_heights* field, float tolerance, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(field, "field");
        if (!(tolerance >= 0 && tolerance <= kMaxHeightTolerance)) throw UsageError("tolerance is not in 0..1");
        field->visibility.setTolerance(tolerance);
    });
}

penumbra_status penumbra_heights_set(penumbra_heights* field, size_t first_row, size_t row_count, size_t first_column,
                                     size_t column_count, const float* heights, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(field, "field");
        const HeightGrid& grid = field->field.grid();
        requireRange("rows", first_row, row_count, std::size_t(grid.rows));
        requireRange("columns", first_column, column_count, std::size_t(grid.columns));
        if (row_count == 0 || column_count == 0) return;
        requirePointer(heights, "heights");
        const std::span<const float> all(heights, row_count * column_count);
        requireHeights(all);
        const TexelBox box{int(first_row), int(first_column), int(first_row + row_count),
                           int(first_column + column_count)};
        field->visibility.wake(field->field, field->field.set(box, all));
    });
}

size_t penumbra_heights_update_rows(const penumbra_heights* field) {
    return field ? field->visibility.receiverRows() : 0;
}

penumbra_status penumbra_heights_update(penumbra_heights* field, size_t first, size_t count, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(field, "field");
        requireRange("rows", first, count, field->visibility.receiverRows());
        field->visibility.evaluate(field->field, first, first + count);
    });
}

penumbra_status penumbra_heights_get_points(const penumbra_heights* field, size_t first_row, size_t row_count,
                                            const penumbra_vertices* points, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(field, "field", points, "points");
        const HeightGrid& grid = field->field.grid();
        requireRange("rows", first_row, row_count, std::size_t(grid.rows));
        const int last = int(first_row + row_count), step = field->visibility.step();
        HeightRefined refined;
        for (int band = int(first_row) / step * step; band < last; band += step)
            for (int c = 0; c < grid.columns; c += HeightRefined::kColumns) {
                const int end = std::min(c + HeightRefined::kColumns, grid.columns);
                field->visibility.refine(field->field, band, c, end, refined);
                for (int r = std::max(band, int(first_row)); r < std::min(band + step, last); ++r)
                    writePoints(*field, r, c, std::size_t(end - c), refined, *points);
            }
    });
}

penumbra_status penumbra_heights_cast(const penumbra_heights* field, const penumbra_scene* scene,
                                      const penumbra_vertices* points, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(field, "field", scene, "scene");
        const VertexFrames all = pointsOf(*field, points);
        std::array<float, kMaxReceivers * kFarCoefficients> mirrored;
        for (std::size_t at = all.begin; at < all.end; at += kMaxReceivers) {
            const std::size_t n = std::min(kMaxReceivers, all.end - at);
            const std::span<float> used = std::span(mirrored).first(n * kFarCoefficients);
            const CastReceivers some{all.positions.subspan(at, n), all.normals.subspan(at, n),
                                     all.tangents.subspan(at, n)};
            if (scene->cast->evaluate(some, {}, used) == 0) continue;
            field->product({points->coefficients + at * PENUMBRA_HEIGHTS_STRIDE, n * PENUMBRA_HEIGHTS_STRIDE},
                           PENUMBRA_HEIGHTS_STRIDE, used);
        }
    });
}

penumbra_status penumbra_heights_shadow(const penumbra_heights* field, const penumbra_character* character,
                                        const float* to_scene, const penumbra_vertices* vertices,
                                        penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(field, "field");
        requireReceiver(character, vertices);
        const std::size_t last = vertices->first + vertices->count;
        const Affine placed = rigidOf(to_scene);
        const Mat3 turn = placed.linear();
        std::array<Vec3, kMaxReceivers> positions, normals, tangents;
        std::array<float, kMaxReceivers * kFarCoefficients> mirrored;
        for (std::size_t at = vertices->first; at < last; at += kMaxReceivers) {
            const std::size_t n = std::min(kMaxReceivers, last - at);
            character->evaluator.skin(at, {positions.data(), n}, {normals.data(), n}, {tangents.data(), n});
            for (std::size_t i = 0; i < n; ++i) {
                positions[i] = placed.point(positions[i]);
                normals[i] = turn * normals[i];
                tangents[i] = turn * tangents[i];
            }
            const std::span<float> used = std::span(mirrored).first(n * kFarCoefficients);
            fieldVisibility(field->field, field->above, field->corner,
                            {{positions.data(), n}, {normals.data(), n}, {tangents.data(), n}}, used);
            castOn(*character, *vertices, at, used);
        }
    });
}

penumbra_status penumbra_heights_query(const penumbra_heights* field, const float* places, size_t count, float* heights,
                                       penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(field, "field");
        if (count == 0) return;
        requireCount("count", count, 2 * sizeof(float));
        requirePointer(places, "places", heights, "heights");
        requireFinite("places", {places, 2 * count});
        for (std::size_t i = 0; i < count; ++i)
            heights[i] = float(
                heightOfField(field->field, toDouble(field->corner), double(places[2 * i]), double(places[2 * i + 1])));
    });
}

penumbra_status penumbra_heights_under(const penumbra_heights* field, const float* positions, size_t count,
                                       const float* to_scene, float* height, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(field, "field", height, "height");
        if (count > 0) requirePointer(positions, "positions");
        requireCount("count", count, 3 * sizeof(float));
        requireFinite("positions", {positions, 3 * count});
        *height =
            float(groundUnderPose(field->field, toDouble(field->corner), vectors(positions, count), rigidOf(to_scene)));
    });
}

penumbra_status penumbra_heights_set_look(penumbra_heights* field, const penumbra_asset* asset, size_t material,
                                          const float* albedo, size_t light, const float* rotation,
                                          penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(field, "field", asset, "asset");
        const AssetView& view = asset->data->view;
        requireIndex("light", light, view.lights.size());
        Vec3 color;
        if (material == PENUMBRA_NONE) {
            requirePointer(albedo, "albedo");
            requireFinite("albedo", {albedo, 3});
            color = {albedo[0], albedo[1], albedo[2]};
        } else {
            requireIndex("material", material, view.materials.size());
        }
        const LambertMaterial lambert(color);
        VertexShader look(field->visibility.convention(), PENUMBRA_HEIGHTS_STRIDE,
                          material == PENUMBRA_NONE ? lambert.view : view.materials[material], view.lights[light]);
        if (rotation) look.setLightRotation(rotationFrom(rotation));
        field->asset = asset->data;
        field->look.emplace(std::move(look));
    });
}

penumbra_status penumbra_heights_shade(const penumbra_heights* field, const float eye[3],
                                       const penumbra_vertices* points, float* radiance, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(field, "field");
        const Vec3 from = pointFrom("eye", eye);
        const VertexFrames frames = pointsOf(*field, points);
        requirePointer(radiance, "radiance");
        if (!field->look) throw UsageError("the field has no look yet");
        field->look->shade(frames, from, vectors(radiance, field->field.grid().size()));
    });
}
