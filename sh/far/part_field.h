#pragma once
// How much of the sky a rigid part blocks, at any point around it and inside it: the visibility V - 1 of the part alone
// as SH of order 6 over the whole sphere, sampled on nested grids in the part's rest frame (docs/formulas.md, section
// 7). A part moves rigidly, so one field is right for every pose.
//
// Three levels hold a part: a fine box close around it, a coarse box, and spheres beyond. What they store is (V - 1)
// (d^2 + r^2/4), d the distance from the part's center and r its radius: far away that hardly changes. Points inside
// the part hold what its nearest surface point sees, and a signed distance from the surface tells where they are: a
// point that sinks into a part, as skin does into skin, goes dark there.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

constexpr int kFieldOrder = 6;
constexpr std::size_t kFieldCoefficients = 36;  // SH coefficients of a point
constexpr std::size_t kFieldLevels = 3;         // fine box, coarse box, spheres
constexpr std::size_t kFieldSpheres = 4;        // radii r / u for u of kFieldSphereScales
constexpr std::size_t kFieldSphereSide = 13;    // points along a side of the octahedral map of a sphere
constexpr std::array<float, kFieldSpheres> kFieldSphereScales = {0.08f, 0.3f, 0.5f, 0.7f};
// Over these shares of the radius a box fades into the next level, so that no border shows.
constexpr std::array<float, 2> kFieldBlendWidth = {0.1f, 0.3f};

// A grid of points at the corners of cells. x runs fastest, then y, then z.
struct FieldBox {
    Vec3 low, high;
    std::array<std::int32_t, 3> size{2, 2, 2};  // points along each axis, >= 2

    std::size_t pointCount() const { return std::size_t(size[0]) * std::size_t(size[1]) * std::size_t(size[2]); }
};

// Where the field of one part has its points, and what its bytes stand for. Points are those of the fine box, of the
// coarse box, then of the spheres, the largest one first. All lengths are in the space of the rest positions.
constexpr std::uint32_t kStillJoint = 65535;  // of a part that stands still in the model frame
struct PartField {
    std::uint32_t joint = 0;  // the part moves with its bone
    Vec3 center;              // of the part's bounding sphere
    float radius = 0;         // of that sphere, > 0
    std::array<FieldBox, 2> boxes;
    // [level][band] what a byte 1 stands for; and of the signed distances
    std::array<std::array<float, kFieldOrder>, kFieldLevels> scale{};
    float distance_scale = 0;

    std::size_t pointCount() const {
        return boxes[0].pointCount() + boxes[1].pointCount() + kFieldSpheres * kFieldSphereSide * kFieldSphereSide;
    }
};
// The bytes of one part.
struct FieldBytes {
    std::span<const std::int8_t> values;     // [points, kFieldCoefficients]
    std::span<const std::int8_t> distances;  // [points of the fine box] signed distance, < 0 inside, clamped
};

// Returns the direction of a point of the octahedral map, a and b in [0, kFieldSphereSide).
Vec3 sphereDirection(std::size_t a, std::size_t b);
// Returns where each point of the field lies, in the order of the stored values.
std::vector<Vec3> fieldPoints(const PartField& part);

// A field laid out for lookups: 40 bytes a point, the coefficients, then the signed distance, then zeros.
struct FieldTable {
    static constexpr std::size_t kStride = 40;
    Vec3 center;
    float radius = 0;
    std::array<FieldBox, 2> boxes;
    std::array<std::array<float, kStride>, kFieldLevels> scale{};  // of each number of a point
    float fade = 0;                                                // depth below the surface at which it is dark
    std::vector<std::int8_t> points;
};
// `fade` is the depth below the surface of the part over which a point goes dark.
FieldTable makeFieldTable(const PartField& part, const FieldBytes& bytes, float fade);

// Writes V - 1 of the part as `point` of its rest frame sees it, or as the surface near a point inside does; out.size()
// == kFieldCoefficients. Returns how dark it is there besides: 0 outside, 1 from the depth `fade` on. Both are
// continuous in the point everywhere. Works for any point; what it writes for one that is not finite means nothing.
float sampleField(const FieldTable& field, Vec3 point, std::span<float> out);

}  // namespace penumbra
