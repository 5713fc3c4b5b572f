#include "sh/far/part_field.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "sh/sh_basis.h"

namespace penumbra {

namespace {

constexpr std::size_t kSpherePoints = kFieldSphereSide * kFieldSphereSide;
constexpr std::size_t kDistance = kFieldCoefficients;  // where a point of a table has its signed distance

// Eight points of a level and their weights, which sum to 1.
struct Corners {
    std::array<std::uint32_t, 8> point;
    std::array<float, 8> weight;
};

// Returns t clamped to [0, most]; 0 where t is not a number.
float clampedCell(float t, float most) { return t > 0 ? std::min(t, most) : 0; }

Corners boxCorners(const FieldBox& box, Vec3 p) {
    std::array<std::uint32_t, 3> cell;
    std::array<float, 3> part;
    for (int axis = 0; axis < 3; ++axis) {
        const float cells = float(box.size[std::size_t(axis)] - 1);
        const float t = (p[axis] - box.low[axis]) / (box.high[axis] - box.low[axis]) * cells;
        const float inside = clampedCell(t, cells);
        cell[std::size_t(axis)] = std::uint32_t(std::min(inside, cells - 1));
        part[std::size_t(axis)] = inside - float(cell[std::size_t(axis)]);
    }
    const auto width = std::uint32_t(box.size[0]), slice = width * std::uint32_t(box.size[1]);
    const std::uint32_t first = cell[0] + width * cell[1] + slice * cell[2];
    Corners corners;
    for (std::uint32_t c = 0; c < 8; ++c) {
        const std::uint32_t x = c & 1, y = c >> 1 & 1, z = c >> 2;
        corners.point[c] = first + x + width * y + slice * z;
        corners.weight[c] = (x ? part[0] : 1 - part[0]) * (y ? part[1] : 1 - part[1]) * (z ? part[2] : 1 - part[2]);
    }
    return corners;
}

// The octahedral map unfolds the sphere to the square [-1, 1]^2.
std::array<float, 2> unfolded(Vec3 direction) {
    const float sum = std::abs(direction.x) + std::abs(direction.y) + std::abs(direction.z);
    if (!(sum > 0)) return {0, 0};
    const float x = direction.x / sum, y = direction.y / sum;
    if (direction.z >= 0) return {x, y};
    return {(1 - std::abs(y)) * (x >= 0 ? 1.0f : -1.0f), (1 - std::abs(x)) * (y >= 0 ? 1.0f : -1.0f)};
}

// Four points on each of two spheres. The spheres are linear in u = r / d.
Corners sphereCorners(float radius, Vec3 offset) {
    const float d = length(offset);
    const float u = std::clamp(d > 0 ? radius / d : 1.0f, kFieldSphereScales.front(), kFieldSphereScales.back());
    std::uint32_t sphere = 0;
    while (sphere + 2 < kFieldSpheres && u > kFieldSphereScales[sphere + 1]) ++sphere;
    const float step = kFieldSphereScales[sphere + 1] - kFieldSphereScales[sphere];
    const float beyond = (u - kFieldSphereScales[sphere]) / step;
    const std::array<float, 2> map = unfolded(offset);
    std::array<std::uint32_t, 2> cell;
    std::array<float, 2> part;
    constexpr float cells = float(kFieldSphereSide - 1);
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const float t = clampedCell((map[axis] + 1) / 2 * cells, cells);
        cell[axis] = std::uint32_t(std::min(t, cells - 1));
        part[axis] = t - float(cell[axis]);
    }
    Corners corners;
    for (std::uint32_t c = 0; c < 8; ++c) {
        const std::uint32_t a = c & 1, b = c >> 1 & 1, s = c >> 2;
        corners.point[c] =
            std::uint32_t((sphere + s) * kSpherePoints) + (cell[0] + a) * std::uint32_t(kFieldSphereSide) + cell[1] + b;
        corners.weight[c] = (a ? part[0] : 1 - part[0]) * (b ? part[1] : 1 - part[1]) * (s ? beyond : 1 - beyond);
    }
    return corners;
}

// How far inside the box a point is, as a share of `width`, clamped to [0, 1].
float depthInBox(const FieldBox& box, Vec3 p, float width) {
    float depth = width;
    for (int axis = 0; axis < 3; ++axis) depth = std::min({depth, p[axis] - box.low[axis], box.high[axis] - p[axis]});
    return std::max(depth, 0.0f) / width;
}

// Adds `share` of the numbers that a level has between its corners.
void addLevel(const FieldTable& field, std::size_t level, std::size_t first_point, const Corners& corners, float share,
              std::array<float, FieldTable::kStride>& sum) {
    std::array<float, FieldTable::kStride> bytes{};
    for (std::size_t c = 0; c < 8; ++c) {
        const std::int8_t* point = field.points.data() + (first_point + corners.point[c]) * FieldTable::kStride;
        for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] += corners.weight[c] * float(point[i]);
    }
    for (std::size_t i = 0; i < bytes.size(); ++i) sum[i] += share * field.scale[level][i] * bytes[i];
}

}  // namespace

Vec3 sphereDirection(std::size_t a, std::size_t b) {
    constexpr float cells = float(kFieldSphereSide - 1);
    const float u = 2 * float(a) / cells - 1, v = 2 * float(b) / cells - 1, z = 1 - std::abs(u) - std::abs(v);
    if (z >= 0) return normalized(Vec3{u, v, z});
    return normalized(
        Vec3{(1 - std::abs(v)) * (u >= 0 ? 1.0f : -1.0f), (1 - std::abs(u)) * (v >= 0 ? 1.0f : -1.0f), z});
}

std::vector<Vec3> fieldPoints(const PartField& part) {
    std::vector<Vec3> points;
    points.reserve(part.pointCount());
    for (const FieldBox& box : part.boxes) {
        const Vec3 extent = box.high - box.low;
        for (std::int32_t z = 0; z < box.size[2]; ++z)
            for (std::int32_t y = 0; y < box.size[1]; ++y)
                for (std::int32_t x = 0; x < box.size[0]; ++x) {
                    const Vec3 t{float(x) / float(box.size[0] - 1), float(y) / float(box.size[1] - 1),
                                 float(z) / float(box.size[2] - 1)};
                    points.push_back(box.low + extent * t);
                }
    }
    for (float u : kFieldSphereScales)
        for (std::size_t a = 0; a < kFieldSphereSide; ++a)
            for (std::size_t b = 0; b < kFieldSphereSide; ++b)
                points.push_back(part.center + sphereDirection(a, b) * (part.radius / u));
    return points;
}

FieldTable makeFieldTable(const PartField& part, const FieldBytes& bytes, float fade) {
    assert(bytes.values.size() == part.pointCount() * kFieldCoefficients);
    FieldTable table{part.center, part.radius, part.boxes, {}, fade, {}};
    for (std::size_t level = 0; level < kFieldLevels; ++level)
        for (std::size_t i = 0; i < kFieldCoefficients; ++i)
            table.scale[level][i] = part.scale[level][std::size_t(bandOfIndex(int(i)))];
    table.scale[0][kDistance] = part.distance_scale;
    table.points.resize(part.pointCount() * FieldTable::kStride);
    for (std::size_t p = 0; p < part.pointCount(); ++p) {
        std::int8_t* point = table.points.data() + p * FieldTable::kStride;
        std::copy_n(bytes.values.data() + p * kFieldCoefficients, kFieldCoefficients, point);
        if (p < bytes.distances.size()) point[kDistance] = bytes.distances[p];
    }
    return table;
}

float sampleField(const FieldTable& field, Vec3 point, std::span<float> out) {
    assert(out.size() == kFieldCoefficients);
    const Vec3 offset = point - field.center;
    // 1. Levels blend into one another.
    const float fine = depthInBox(field.boxes[0], point, kFieldBlendWidth[0] * field.radius);
    const float coarse = (1 - fine) * depthInBox(field.boxes[1], point, kFieldBlendWidth[1] * field.radius);
    const float beyond = 1 - fine - coarse;
    const std::size_t first_coarse = field.boxes[0].pointCount();
    std::array<float, FieldTable::kStride> sum{};
    if (fine > 0) addLevel(field, 0, 0, boxCorners(field.boxes[0], point), fine, sum);
    if (coarse > 0) addLevel(field, 1, first_coarse, boxCorners(field.boxes[1], point), coarse, sum);
    if (beyond > 0)
        addLevel(field, 2, first_coarse + field.boxes[1].pointCount(), sphereCorners(field.radius, offset), beyond,
                 sum);
    // 2. What is stored varies little with the distance; V - 1 falls with its square.
    const float scale = 1 / (dot(offset, offset) + 0.25f * field.radius * field.radius);
    for (std::size_t i = 0; i < kFieldCoefficients; ++i) out[i] = scale * sum[i];
    // 3. The signed distance is that of the fine box, whose share it carries.
    return std::clamp(-sum[kDistance] / field.fade, 0.0f, fine);
}

}  // namespace penumbra
