#include "bake/fields/signed_distance.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <vector>

namespace penumbra {

namespace {

struct Neighbour {
    std::array<std::int32_t, 3> step;
    float length;
};

// The 26 points around a point, and how far away they are.
std::vector<Neighbour> neighboursIn(const FieldBox& box) {
    Vec3 cell;
    for (int axis = 0; axis < 3; ++axis)
        cell[axis] = (box.high[axis] - box.low[axis]) / float(box.size[std::size_t(axis)] - 1);
    std::vector<Neighbour> out;
    for (std::int32_t z = -1; z <= 1; ++z)
        for (std::int32_t y = -1; y <= 1; ++y)
            for (std::int32_t x = -1; x <= 1; ++x)
                if (x || y || z) out.push_back({{x, y, z}, length(cell * Vec3{float(x), float(y), float(z)})});
    return out;
}

// Calls visit(index of the neighbour, distance to it) for the neighbours of a point in the box.
template <class Visit>
void visitNeighbours(const FieldBox& box, std::span<const Neighbour> neighbours, std::size_t index,
                     const Visit& visit) {
    const auto width = std::size_t(box.size[0]), height = std::size_t(box.size[1]);
    const std::array<std::int32_t, 3> at{std::int32_t(index % width), std::int32_t(index / width % height),
                                         std::int32_t(index / (width * height))};
    for (const Neighbour& neighbour : neighbours) {
        std::array<std::int32_t, 3> to{};
        bool in_box = true;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            to[axis] = at[axis] + neighbour.step[axis];
            in_box = in_box && to[axis] >= 0 && to[axis] < box.size[axis];
        }
        if (in_box)
            visit(std::size_t(to[0]) + width * (std::size_t(to[1]) + height * std::size_t(to[2])), neighbour.length);
    }
}

}  // namespace

void closeHoles(const FieldBox& box, std::span<const float> depth, std::span<float> distances) {
    const std::size_t count = box.pointCount();
    assert(depth.size() == count && distances.size() == count);
    const std::vector<Neighbour> neighbours = neighboursIn(box);
    const auto isInside = [&](std::size_t p) { return depth[p] > 0; };
    std::vector<float> size(count);
    for (std::size_t p = 0; p < count; ++p) size[p] = std::abs(distances[p]);
    // 1. Two neighbours on different sides of a surface are no farther from it than from one another. Where they are,
    // the border between them is in a hole.
    for (std::size_t p = 0; p < count; ++p)
        visitNeighbours(box, neighbours, p, [&](std::size_t q, float apart) {
            if (isInside(p) == isInside(q)) return;
            if (std::abs(distances[p]) + std::abs(distances[q]) <= apart * 1.001f) return;
            size[p] = std::min(size[p], apart * std::clamp(depth[p] / (depth[p] - depth[q]), 0.05f, 0.95f));
        });
    // 2. The distance grows by no more than the way from a neighbour on the same side. Two sweeps forth and back carry
    // that through the box.
    for (int sweep = 0; sweep < 4; ++sweep)
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t p = sweep % 2 == 0 ? i : count - 1 - i;
            visitNeighbours(box, neighbours, p, [&](std::size_t q, float apart) {
                if (isInside(p) == isInside(q)) size[p] = std::min(size[p], size[q] + apart * 1.001f);
            });
        }
    for (std::size_t p = 0; p < count; ++p) distances[p] = isInside(p) ? -size[p] : size[p];
}

}  // namespace penumbra
