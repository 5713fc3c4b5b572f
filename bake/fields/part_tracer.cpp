#include "bake/fields/part_tracer.h"

#include <cassert>
#include <cmath>
#include <numbers>

#include "bake/common/random_numbers.h"
#include "sh/quadrature.h"

namespace penumbra {

namespace {

// A point is inside where more than this share of all directions meets the back of a triangle first. Half of them do
// in the middle of an open end.
constexpr double kInsideShare = 0.3;
// A point is inside, too, where less than this share of all directions meets nothing.
constexpr double kEscapeShare = 0.05;
// A triangle is a sheet where backs stop less than this share of the rays that start just behind it. Those of its own
// plane stop half, those of a closed surface nearly all, and at the rim of an open end three quarters. At least the
// other share escapes there: what is shut in between other surfaces stays dark.
constexpr double kSheetShare = 0.65, kSheetEscape = 0.1;
// A triangle is exposed where at least this share escapes, and rays from it that tell. Of a convex part half do.
constexpr double kExposedShare = 0.3;
constexpr int kExposureRays = 64;
// How far a point on the surface is moved out before rays start there, in diagonals of the part.
constexpr double kSurfaceOffset = 2e-3;

std::vector<Vec3> scaled(const SceneScale& scale, std::span<const Vec3> positions) {
    std::vector<Vec3> out;
    for (const Vec3& p : positions) out.push_back(scale.apply(p));
    return out;
}

}  // namespace

ConeDirections makeConeDirections(int count, std::uint64_t seed) {
    assert(count > 0);
    const double turn = seed == 1 ? 0 : 2 * std::numbers::pi * nextUniform(seed);
    const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
    // 1. The spherical Fibonacci set over a hemisphere; along a Morton curve, neighbours share a packet.
    std::vector<Vec3d> hemisphere;
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (i + 0.5) / count, radius = std::sqrt(1 - z * z), azimuth = golden * i + turn;
        hemisphere.push_back({radius * std::cos(azimuth), radius * std::sin(azimuth), z});
    }
    hemisphere = mortonSorted(std::move(hemisphere));
    // 2. The share of a hemisphere that lies between a direction and its axis is 1 - z.
    ConeDirections out{count, std::vector<DirectionPacket>((hemisphere.size() + kLanes - 1) / kLanes)};
    for (std::size_t i = 0; i < hemisphere.size(); ++i) {
        const Vec3d d = hemisphere[i];
        const double radius = std::hypot(d.x, d.y);
        DirectionPacket& packet = out.packets[i / kLanes];
        packet.x[i % kLanes] = float(d.x / radius);
        packet.y[i % kLanes] = float(d.y / radius);
        packet.z[i % kLanes] = float(1 - d.z);
    }
    return out;
}

PartTracer::PartTracer(const PartMesh& mesh, const PartField& field, const ConeDirections& directions)
    : directions_(directions),
      scale_(sceneScale(mesh.positions, boxDiagonal(mesh.positions))),
      center_((toDouble(field.center) - scale_.center) / scale_.diagonal),
      radius_(double(field.radius) / scale_.diagonal),
      scene_(scaled(scale_, mesh.positions), mesh.triangles, Queries::kPlain, {&mesh.opacity, mesh.twins}),
      sheets_(findSheets(mesh)),
      surface_(scaled(scale_, mesh.positions), exposed(scaled(scale_, mesh.positions), mesh.triangles)) {}

namespace {

// Two unit vectors that make a right-handed frame with the unit `z`.
std::array<Vec3d, 2> frameAround(Vec3d z) {
    const Vec3d helper = std::abs(z.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
    const Vec3d x = normalized(helper - z * dot(z, helper));
    return {x, cross(z, x)};
}

}  // namespace

// From outside of the bounding sphere only the cone that holds the sphere is traced, and every ray stands for 1/N of
// that cone.
PartTracer::Seen PartTracer::see(Vec3 point, const ConeDirections& directions,
                                 std::span<const std::uint8_t> sheets) const {
    const Vec3d to_center = center_ - toDouble(point);
    const double distance = length(to_center);
    const double cosine =
        distance > radius_ ? std::sqrt(1 - radius_ * radius_ / (distance * distance)) : -1;  // of the cone's angle
    const Vec3d z = distance > 0 ? to_center / distance : Vec3d{0, 0, 1};
    const auto [x, y] = frameAround(z);
    thread_local std::vector<DirectionPacket> packets;
    thread_local std::vector<LaneSides> sides;
    packets.assign(directions.packets.size(), {});
    sides.resize(packets.size());
    for (std::size_t i = 0; i < std::size_t(directions.count); ++i) {
        const std::size_t p = i / kLanes, k = i % kLanes;
        const DirectionPacket& local = directions.packets[p];
        const double along = 1 - (1 - cosine) * double(local.z[k]);
        const double across = std::sqrt(std::max(0.0, 1 - along * along));
        const Vec3 d = toFloat(x * (across * double(local.x[k])) + y * (across * double(local.y[k])) + z * along);
        packets[p].x[k] = d.x;
        packets[p].y[k] = d.y;
        packets[p].z[k] = d.z;
    }
    scene_.firstSides(point, packets, sheets, sides);
    Seen seen;
    std::array<float, kFieldCoefficients> basis;
    int backs = 0, hits = 0;
    for (std::size_t i = 0; i < std::size_t(directions.count); ++i) {
        const std::size_t p = i / kLanes, k = i % kLanes;
        if (sides[p].lane[k] == MetSide::kNone) continue;
        ++hits;
        backs += sides[p].lane[k] == MetSide::kBack;
        evalBasis(kFieldOrder, Vec3{packets[p].x[k], packets[p].y[k], packets[p].z[k]}, basis);
        for (std::size_t b = 0; b < kFieldCoefficients; ++b) seen.blocked[b] -= double(basis[b]);
    }
    const double share = (1 - cosine) / (2.0 * directions.count);  // of the sphere that one ray stands for
    for (double& b : seen.blocked) b *= 4 * std::numbers::pi * share;
    seen.escaped = 1 - hits * share;
    seen.backs = backs * share;
    seen.depth = std::max(seen.backs - kInsideShare, kEscapeShare - seen.escaped);
    return seen;
}

namespace {

// A point on a triangle, moved from its middle along its normal by `offset` diagonals.
Vec3 besideTriangle(std::span<const Vec3> positions, const Triangle& triangle, double offset) {
    const Vec3d a = toDouble(positions[triangle[0]]), b = toDouble(positions[triangle[1]]),
                c = toDouble(positions[triangle[2]]);
    return toFloat((a + b + c) / 3.0 + normalized(cross(b - a, c - a)) * offset);
}

}  // namespace

// Marks the triangles [T] that are sheets. Each is judged by what is seen just behind it, as if there were no sheets.
// Both sides of a triangle with a twin are fronts already, so that it is none.
std::vector<std::uint8_t> PartTracer::findSheets(const PartMesh& mesh) const {
    const ConeDirections directions = makeConeDirections(kExposureRays, 1);
    const std::vector<Vec3> positions = scaled(scale_, mesh.positions);
    std::vector<std::uint8_t> sheets(mesh.triangles.size());
    for (std::size_t t = 0; t < sheets.size(); ++t) {
        if (!mesh.twins.empty() && mesh.twins[t] != t) continue;
        const Seen seen = see(besideTriangle(positions, mesh.triangles[t], -kSurfaceOffset), directions, {});
        sheets[t] = seen.backs < kSheetShare && seen.escaped >= kSheetEscape;
    }
    return sheets;
}

// Returns the triangles whose front is outside and well lit, and which are no sheets; all triangles where none is.
std::vector<Triangle> PartTracer::exposed(std::span<const Vec3> positions, std::span<const Triangle> triangles) const {
    const ConeDirections directions = makeConeDirections(kExposureRays, 1);
    std::vector<Triangle> out;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (sheets_[t]) continue;
        const Seen seen = see(besideTriangle(positions, triangles[t], kSurfaceOffset), directions, sheets_);
        if (seen.depth <= 0 && seen.escaped >= kExposedShare) out.push_back(triangles[t]);
    }
    return out.empty() ? std::vector<Triangle>(triangles.begin(), triangles.end()) : out;
}

PointOfField PartTracer::trace(Vec3 point, Distances wanted) const {
    const Vec3 scaled_point = scale_.apply(point);
    Seen seen = see(scaled_point, directions_, sheets_);
    const bool inside = seen.depth > 0;
    PointOfField out;
    out.depth = float(seen.depth);
    if (inside || wanted == Distances::kAll) {
        const NearestPoint nearest = surface_.nearest(scaled_point);
        out.distance = float((inside ? -1 : 1) * nearest.distance * scale_.diagonal);
        if (inside) seen = see(toFloat(nearest.point + nearest.normal * kSurfaceOffset), directions_, sheets_);
    }
    for (std::size_t b = 0; b < kFieldCoefficients; ++b) out.blocked[b] = float(seen.blocked[b]);
    return out;
}

}  // namespace penumbra
