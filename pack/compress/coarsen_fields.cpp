#include "pack/compress/coarsen_fields.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace penumbra {

namespace {

std::array<std::size_t, kFieldLevels> pointsOfLevels(const PartField& part) {
    const std::size_t fine = part.boxes[0].pointCount(), coarse = part.boxes[1].pointCount();
    return {fine, coarse, part.pointCount() - fine - coarse};
}

// Divides the numbers of a band of a point, [2 band + 1].
void divide(std::int8_t* numbers, int band, float by) {
    for (int i = 0; i <= 2 * band; ++i) numbers[i] = std::int8_t(std::lround(numbers[i] / by));
}

}  // namespace

void coarsenFields(float step, PartFields& fields) {
    assert(step > 0);
    for (std::size_t p = 0; p < fields.parts.size(); ++p) {
        PartField& part = fields.parts[p];
        const float coarsest = step * part.radius * part.radius;
        const std::array<std::size_t, kFieldLevels> points = pointsOfLevels(part);
        std::int8_t* first = fields.values[p].data();
        for (std::size_t level = 0; level < kFieldLevels; ++level) {
            for (int band = 0; band < kFieldOrder; ++band) {
                float& scale = part.scale[level][std::size_t(band)];
                if (!(scale > 0 && scale < coarsest)) continue;
                for (std::size_t i = 0; i < points[level]; ++i)
                    divide(first + i * kFieldCoefficients + band * band, band, coarsest / scale);
                scale = coarsest;
            }
            first += points[level] * kFieldCoefficients;
        }
    }
}

}  // namespace penumbra
