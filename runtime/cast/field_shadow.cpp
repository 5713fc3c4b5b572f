#include "runtime/cast/field_shadow.h"

#include <algorithm>
#include <array>

namespace penumbra {

void fieldVisibility(const HeightField& field, const HeightTables& above, Vec3 corner, const CastReceivers& receivers,
                     std::span<float> mirrored) {
    constexpr std::size_t kBatch = 64, kRow = coefficientCount(kAboveFieldOrder);
    const HeightGrid& grid = field.grid();
    std::array<float, kBatch> rows, columns, heights;
    std::array<Vec3, kBatch> normals, tangents;
    std::array<float, kBatch * kRow> v;
    for (std::size_t first = 0; first < receivers.positions.size(); first += kBatch) {
        const std::size_t n = std::min(kBatch, receivers.positions.size() - first);
        for (std::size_t i = 0; i < n; ++i) {
            const Vec3 at = receivers.positions[first + i] - corner;
            rows[i] = at.z / grid.cell_x;
            columns[i] = at.x / grid.cell_y;
            heights[i] = std::max(at.y, field.at(rows[i], columns[i]));
            normals[i] = fieldFromScene(receivers.normals[first + i]);
            tangents[i] = fieldFromScene(receivers.tangents[first + i]);
        }
        above.visibility(field, {rows.data(), columns.data(), heights.data(), n}, kRow, v);
        above.mirror(std::span(v).first(n * kRow), kRow, {normals.data(), tangents.data()}, HeightReceiver::kAbove,
                     kFarCoefficients, mirrored.subspan(first * kFarCoefficients, n * kFarCoefficients));
    }
}

}  // namespace penumbra
