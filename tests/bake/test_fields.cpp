#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "bake/fields/merge_fields.h"
#include "bake/fields/part_fields.h"
#include "bake/fields/part_tracer.h"
#include "bake/fields/signed_distance.h"
#include "formats/common/errors.h"
#include "sh/bounding_box.h"
#include "sh/quaternion.h"
#include "sh/sh_rotation.h"
#include "sh/zonal.h"
#include "tests/bake/shapes.h"
#include "tests/difference.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_fields {
namespace {

using Coefficients = std::array<float, kFieldCoefficients>;

PartMesh meshOf(const shapes::Shape& shape) { return {shape.positions, shape.triangles}; }

PartField placedField(const PartMesh& mesh, double cells) { return placeFields({&mesh, 1}, cells, 1 << 30)[0]; }

FieldPlan planOf(const std::vector<PartMesh>& meshes, int cells = 12) {
    FieldPlan plan;
    plan.file.fields.fade = 0.01f;
    for (const PartMesh& mesh : meshes) {
        plan.meshes.push_back(mesh);
        plan.file.fields.parts.push_back(placedField(mesh, cells));
    }
    return plan;
}

// V - 1 of a sphere: a cap around the way to its center is blocked.
Coefficients blockedCap(Vec3d way, double radius) {
    std::array<double, kFieldOrder> zonal;
    std::array<double, kFieldCoefficients> lobe;
    capVisibilityZonal(std::asin(radius / length(way)), zonal);
    rotateZonal(zonal, normalized(way), lobe);
    lobe[0] -= std::sqrt(4 * std::numbers::pi);
    Coefficients out;
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = float(lobe[i]);
    return out;
}

TEST(BoundingSphere, IsNearlyTheSmallest) {
    // The smallest sphere of a regular tetrahedron goes through its corners.
    const std::vector<Vec3> corners = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    EXPECT_NEAR(boundingSphere(corners).radius, std::sqrt(3.0), 1e-2);
    const shapes::Shape ball = shapes::sphere({3, -2, 1}, 0.5, 24);
    const BoundingSphere found = boundingSphere(ball.positions);
    EXPECT_NEAR(found.radius, 0.5, 1e-3);
    for (Vec3 p : ball.positions) EXPECT_LE(length(toDouble(p) - found.center), found.radius * 1.000001);
}

TEST(NearestSurface, AgreesWithASphere) {
    const shapes::Shape ball = shapes::sphere({0.1, 0.2, -0.1}, 0.5, 48);
    const NearestSurface surface(ball.positions, ball.triangles);
    for (const Vec3d d : fibonacciSphere(200))
        for (double r : {0.2, 0.45, 0.55, 2.0}) {
            const NearestPoint near = surface.nearest(toFloat(Vec3d{0.1, 0.2, -0.1} + d * r));
            EXPECT_NEAR(near.distance, std::abs(r - 0.5), 1.5e-3);  // facets lie up to .0011 inside of the sphere
            EXPECT_GT(dot(near.normal, d), 0.99);
        }
}

TEST(PlaceField, CellsAreNearlyCubes) {
    shapes::Shape rod = shapes::sphere({5, 5, 5}, 1, 16);
    for (Vec3& p : rod.positions) p.y = 5 + 0.2f * (p.y - 5);
    const PartField part = placedField(meshOf(rod), 12);
    for (const FieldBox& box : part.boxes) {
        Vec3 cell;
        for (int axis = 0; axis < 3; ++axis)
            cell[axis] = (box.high[axis] - box.low[axis]) / float(box.size[std::size_t(axis)] - 1);
        const float least = std::min({cell.x, cell.y, cell.z}), most = std::max({cell.x, cell.y, cell.z});
        EXPECT_LT(most / least, 1.25f);
        EXPECT_NEAR(double(box.pointCount()), 1728, 350);  // thin boxes have more: 2023 was measured
    }
    EXPECT_NEAR(part.boxes[0].low.y, 5 - 0.2f - 0.12f * part.radius, 1e-4f);
    EXPECT_NEAR(part.boxes[1].high.x, 6 + 0.9f * part.radius, 1e-2f);
}

// 2048 rays came within .0040 of the closed form. V - 1 has a length of up to 3.
TEST(PartTracer, ASphereHasTheClosedFormOfACap) {
    const Vec3d center{2, -1, 3};
    const PartMesh mesh = meshOf(shapes::sphere(center, 0.25, 64));
    const PartField field = placedField(mesh, 12);
    const ConeDirections directions = makeConeDirections(2048, 1);
    const PartTracer tracer(mesh, field, directions);
    Largest worst;
    for (const Vec3d d : fibonacciSphere(40))
        for (double r : {1.1, 1.5, 3.0, 12.0}) {
            const PointOfField point = tracer.trace(toFloat(center + d * (0.25 * r)), Distances::kAll);
            worst.add(distanceBetween(point.blocked, blockedCap(-d * (0.25 * r), 0.25)));
            EXPECT_NEAR(point.distance, 0.25 * (r - 1), 1e-3);
        }
    EXPECT_LT(worst, 0.01f);
}

// Rays of a point inside start above the surface, by 2e-3 of the diagonal of a unit ball's box.
constexpr double kAboveUnitBall = 1 + 2e-3 * 2 * std::numbers::sqrt3;

// A point inside sees what the nearest surface point sees, about half of the sphere, and its distance is negative.
TEST(PartTracer, InsidePointsHoldWhatTheSurfaceSees) {
    const PartMesh mesh = meshOf(shapes::sphere({0, 0, 0}, 1, 48));
    const PartField field = placedField(mesh, 12);
    const ConeDirections directions = makeConeDirections(1024, 1);
    const PartTracer tracer(mesh, field, directions);
    for (const Vec3d d : fibonacciSphere(20)) {
        const PointOfField point = tracer.trace(toFloat(d * 0.8), Distances::kAll);
        EXPECT_NEAR(point.distance, -0.2, 2e-3);
        // The facets leave some sky that the ball blocks: .025 was measured.
        EXPECT_LT(distanceBetween(point.blocked, blockedCap(-d * kAboveUnitBall, 1)), 0.04f);
    }
}

// A ball within a hollow ball: neither the hollow nor the surfaces in there are outside.
TEST(PartTracer, AMouthIsInside) {
    shapes::Shape shape = shapes::sphere({0, 0, 0}, 1, 32), hollow = shapes::sphere({0, 0, 0}, 0.9, 32);
    for (Triangle& t : hollow.triangles) std::swap(t[1], t[2]);
    shapes::append(shape, hollow);
    shapes::append(shape, shapes::sphere({0, 0, 0}, 0.3, 12));
    const PartMesh mesh = meshOf(shape);
    const PartField field = placedField(mesh, 12);
    const ConeDirections directions = makeConeDirections(256, 1);
    const PartTracer tracer(mesh, field, directions);
    const PointOfField point = tracer.trace({0, 0.5f, 0}, Distances::kAll);
    EXPECT_NEAR(point.distance, -0.5, 0.01);
    // .071 was measured: there are fewer facets, and fewer rays.
    EXPECT_LT(distanceBetween(point.blocked, blockedCap({0, -kAboveUnitBall, 0}, 1)), 0.1f);
}

// A ball with a sheet that hangs behind it, as a cape does from a chest. Its front faces away from the ball.
shapes::Shape ballWithCape() {
    shapes::Shape shape = shapes::sphere({0, 0, 0}, 0.5, 24);
    append(shape, shapes::square({0, 0, -0.9}, {0, 0, -1}, 0.7));
    return shape;
}
// Places between the two: half of what they see is the back of the sheet.
constexpr std::array<Vec3, 3> kBehindTheCape = {{{0, 0, -0.75f}, {0.3f, 0.2f, -0.8f}, {-0.4f, 0.5f, -0.7f}}};

// The share of the sphere that is blocked came within .006 of what single rays say.
TEST(PartTracer, ThereIsNoInsideBehindASheet) {
    const shapes::Shape shape = ballWithCape();
    const PartMesh mesh = meshOf(shape);
    const PartField field = placedField(mesh, 12);
    const ConeDirections directions = makeConeDirections(1024, 1);
    const PartTracer tracer(mesh, field, directions);
    const std::vector<Vec3d> rays = fibonacciSphere(2000);
    for (const Vec3 point : kBehindTheCape) {
        const PointOfField traced = tracer.trace(point, Distances::kAll);
        EXPECT_GT(traced.distance, 0);
        const std::vector<shapes::SeenTriangle> seen = shapes::seenFrom(toDouble(point), shape);
        double blocked = 0;
        for (const Vec3d d : rays) blocked += shapes::blocked(seen, d);
        EXPECT_NEAR(double(traced.blocked[0]), -std::sqrt(4 * std::numbers::pi) * blocked / 2000, 0.02 * 3.5);
    }
    // The nearest surface that counts is the ball's, and the ball still has an inside. Triangles right before the sheet
    // see too little sky to count, so that the nearest one is .006 farther there.
    EXPECT_NEAR(tracer.trace({0, 0, 0.3f}, Distances::kAll).distance, -0.2, 5e-3);
    EXPECT_NEAR(tracer.trace({0, 0, -0.3f}, Distances::kAll).distance, -0.2, 1e-2);
}

// Half of what a point in the middle of the open end sees are backs, and that is a closed surface for all that.
TEST(PartTracer, AnOpenEndMakesNoSheet) {
    shapes::Shape bowl = shapes::cavity(0.5, 16);  // three quarters of a sphere
    for (Triangle& t : bowl.triangles) std::swap(t[1], t[2]);
    const PartMesh mesh = meshOf(bowl);
    const PartField field = placedField(mesh, 12);
    const ConeDirections directions = makeConeDirections(1024, 1);
    const PartTracer tracer(mesh, field, directions);
    for (const Vec3 inside : {Vec3{0, 0, 0}, {0.5f, 0, 0}, {0, 0.3f, -0.6f}, {0.2f, 0, 0.4f}})
        EXPECT_LT(tracer.trace(inside, Distances::kAll).distance, 0);
    EXPECT_GT(tracer.trace({0, 0, 0.9f}, Distances::kAll).distance, 0);
}

// Without its cap an open tube would have distances of about its radius on both sides of the opening.
TEST(CloseHoles, AnOpenEndCountsAsSurface) {
    FieldBox box{{-1, -1, -1}, {1, 1, 1}, {21, 21, 21}};
    std::vector<float> depth, distances, expected;
    for (int z = 0; z < 21; ++z)
        for (int y = 0; y < 21; ++y)
            for (int x = 0; x < 21; ++x) {
                // The inside is z < 0.03, but the surface that was found is 0.8 away.
                const float height = -1 + 0.1f * float(z) - 0.03f;
                depth.push_back(-height);
                distances.push_back(height < 0 ? -0.8f : 0.8f);
                expected.push_back(std::clamp(height, -0.8f, 0.8f));
            }
    closeHoles(box, depth, distances);
    for (std::size_t p = 0; p < distances.size(); ++p) EXPECT_NEAR(distances[p], expected[p], 2e-3f) << p;
}

TEST(CloseHoles, RightDistancesStay) {
    FieldBox box{{-1, -1, -1}, {1, 1, 1}, {15, 15, 15}};
    PartField part;
    part.boxes = {box, box};
    part.radius = 1;
    const std::vector<Vec3> points = fieldPoints(part);
    std::vector<float> depth, distances;
    for (std::size_t p = 0; p < box.pointCount(); ++p) {
        distances.push_back(length(points[p]) - 0.6f);
        depth.push_back(distances.back() < 0 ? 0.7f : -0.3f);
    }
    const std::vector<float> before = distances;
    closeHoles(box, depth, distances);
    EXPECT_EQ(distances, before);
}

// Every number is at most half a byte off, which is its band's largest number over 254.
TEST(QuantizeField, ErrorsAreAtMostHalfAByte) {
    const PartMesh mesh = meshOf(shapes::sphere({1, 1, 1}, 0.5, 12));
    PartField part = placedField(mesh, 6);
    FieldSamples samples;
    for (std::size_t i = 0; i < part.pointCount() * kFieldCoefficients; ++i)
        samples.values.push_back(std::sin(float(i) * 0.7f));
    for (std::size_t i = 0; i < part.boxes[0].pointCount(); ++i) samples.distances.push_back(std::cos(float(i)) * 0.2f);
    std::vector<std::int8_t> values, distances;
    quantizeField(samples, 0.01f, part, values, distances);
    const std::vector<Vec3> points = fieldPoints(part);
    const std::size_t fine = part.boxes[0].pointCount(), coarse = part.boxes[1].pointCount();
    std::array<std::array<int, kFieldOrder>, kFieldLevels> largest{};
    for (std::size_t i = 0; i < values.size(); ++i) {
        const std::size_t p = i / kFieldCoefficients, level = p < fine ? 0 : p < fine + coarse ? 1 : 2;
        const auto band = std::size_t(bandOfIndex(int(i % kFieldCoefficients)));
        const Vec3 offset = points[p] - part.center;
        const float stored = samples.values[i] * (dot(offset, offset) + 0.25f * part.radius * part.radius);
        EXPECT_LE(std::abs(float(values[i]) * part.scale[level][band] - stored), 0.5001f * part.scale[level][band]);
        largest[level][band] = std::max(largest[level][band], std::abs(int(values[i])));
    }
    for (const auto& bands : largest)
        for (int most : bands) EXPECT_EQ(most, 127);
    for (std::size_t p = 0; p < fine; ++p) {
        const float clamped = std::clamp(samples.distances[p], -127 * part.distance_scale, 127 * part.distance_scale);
        EXPECT_LE(std::abs(float(distances[p]) * part.distance_scale - clamped), 0.5001f * part.distance_scale);
    }
}

// The whole way: trace, round, interpolate. The rms errors over all directions, relative to V - 1 of the closed form,
// were .101, .063, .355 and .543. Those of the spheres, which are the last two, come of the interpolation
// (tests/sh/test_part_field.cpp).
TEST(BakeFields, ASphereInterpolatesTheClosedForm) {
    const Vec3d center{0.5, 2, 0};
    const FieldFile file = bakeFields(planOf({meshOf(shapes::sphere(center, 0.5, 48))}), {}, 2, ProgressStyle::kNone);
    const FieldTable table = makeFieldTable(file.fields.parts[0], file.fields.bytesOf(0), file.fields.fade);
    for (const auto& [distance, bound] : {std::pair(1.1, 0.13), {1.5, 0.08}, {3.0, 0.4}, {10.0, 0.6}}) {
        double error = 0, truth = 0;
        for (const Vec3d d : fibonacciSphere(300)) {
            Coefficients out;
            sampleField(table, toFloat(center + d * (0.5 * distance)), out);
            const Coefficients expected = blockedCap(-d * (0.5 * distance), 0.5);
            error += std::pow(double(distanceBetween(out, expected)), 2);
            truth += std::pow(double(distanceBetween(expected, Coefficients{})), 2);
        }
        EXPECT_LT(std::sqrt(error / truth), bound) << distance;
    }
}

// An ellipsoid with unequal axes, turned: what it blocks turns with it. The grids lie differently, which left .053.
TEST(BakeFields, ATurnedPartHasATurnedField) {
    shapes::Shape shape = shapes::sphere({0, 0, 0}, 1, 24);
    for (Vec3& p : shape.positions) p = {p.x, 0.5f * p.y, 0.3f * p.z};
    const Mat3d turn = matrixOf({0.5, 0.5, -0.1, std::sqrt(1 - 0.51)});
    shapes::Shape turned = shape;
    for (Vec3& p : turned.positions) p = toFloat(turn * toDouble(p));
    const FieldFile file = bakeFields(planOf({meshOf(shape), meshOf(turned)}), {}, 2, ProgressStyle::kNone);
    const FieldTable table = makeFieldTable(file.fields.parts[0], file.fields.bytesOf(0), 0.01f);
    const FieldTable turned_table = makeFieldTable(file.fields.parts[1], file.fields.bytesOf(1), 0.01f);
    Mat3 single;
    for (std::size_t i = 0; i < 9; ++i) single.m[i] = float(turn.m[i]);
    const ShRotation rotation = makeShRotation(kFieldOrder, single);
    double error = 0, size = 0;
    for (const Vec3d d : fibonacciSphere(300)) {
        Coefficients out, of_turned;
        sampleField(table, toFloat(d * 1.6), out);
        sampleField(turned_table, toFloat(turn * d * 1.6), of_turned);
        Coefficients expected;
        apply(rotation, out, expected);
        error += std::pow(double(distanceBetween(expected, of_turned)), 2);
        size += std::pow(double(distanceBetween(expected, Coefficients{})), 2);
    }
    EXPECT_LT(std::sqrt(error / size), 0.08);
}

// A lookup behind the sheet is lit, and one inside the ball is dark.
TEST(BakeFields, ASheetDarkensNothing) {
    const FieldFile file = bakeFields(planOf({meshOf(ballWithCape())}), {.rays = 256}, 2, ProgressStyle::kNone);
    const FieldTable table = makeFieldTable(file.fields.parts[0], file.fields.bytesOf(0), file.fields.fade);
    Coefficients out;
    for (const Vec3 point : kBehindTheCape) EXPECT_EQ(sampleField(table, point, out), 0);
    for (const Vec3 point : {Vec3{0, 0, 0}, {0.2f, 0.1f, 0}, {0, 0, -0.3f}})
        EXPECT_EQ(sampleField(table, point, out), 1);
}

TEST(BakeFields, SameBytesForAnyNumberOfThreads) {
    const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
    const FieldPlan plan = planOf({meshOf(ballWithCape()), meshOf(shapes::square({0, 0, 0}, {0, 1, 0}, 0.5))}, 6);
    const auto bake = [&](int threads) { return bakeFields(plan, {.rays = 64}, threads, ProgressStyle::kNone).fields; };
    const PartFields one = bake(1);
    for (int threads : {2, 8}) {
        const PartFields many = bake(threads);
        EXPECT_EQ(many.values, one.values);
        EXPECT_EQ(many.distances, one.distances);
        for (std::size_t p = 0; p < 2; ++p) EXPECT_EQ(many.parts[p].scale, one.parts[p].scale);
    }
}

// --- Shards ---------------------------------------------------------------------------------------------------------

// Writes the parts [begin, end) of the samples' two parts as a shard.
std::filesystem::path writeShard(const std::filesystem::path& folder, std::size_t begin, std::size_t end,
                                 const char* options = R"({"rays":64,"parts":[0,1]})") {
    FieldFile shard = samples::fieldFile();
    PartFields& all = shard.fields;
    const PartFields whole = all;
    all.parts.assign(whole.parts.begin() + long(begin), whole.parts.begin() + long(end));
    all.values.assign(whole.values.begin() + long(begin), whole.values.begin() + long(end));
    all.distances.assign(whole.distances.begin() + long(begin), whole.distances.begin() + long(end));
    shard.shard = FieldShard{begin, whole.parts.size()};
    shard.provenance.options_json = options;
    const auto path = folder / ("s" + std::to_string(begin) + std::to_string(end) + ".fields.h5");
    writeFields(path, shard);
    return path;
}

TEST(MergeFields, ShardsMakeTheBytesOfTheWhole) {
    const samples::Folder folder("merge_fields");
    const auto first = writeShard(folder.path, 0, 1), second = writeShard(folder.path, 1, 2);
    writeFields(folder.path / "merged.fields.h5", mergeFields({second, first}));
    writeFields(folder.path / "whole.fields.h5", samples::fieldFile());
    EXPECT_EQ(samples::bytesOf(folder.path / "merged.fields.h5"), samples::bytesOf(folder.path / "whole.fields.h5"));
}

TEST(MergeFields, GapsOverlapsAndOtherOptionsAreRefused) {
    const samples::Folder folder("gaps");
    const auto problem = [](const std::vector<std::filesystem::path>& shards) -> std::string {
        try {
            mergeFields(shards);
            return "none";
        } catch (const InvalidInput& error) {
            return error.what();
        }
    };
    const auto first = writeShard(folder.path, 0, 1), second = writeShard(folder.path, 1, 2),
               both = writeShard(folder.path, 0, 2);
    EXPECT_NE(problem({first}).find("missing parts: 1:2"), std::string::npos);
    EXPECT_NE(problem({second}).find("missing parts: 0:1"), std::string::npos);
    EXPECT_NE(problem({both, second}).find("twice: 1:2"), std::string::npos);
    const auto other = writeShard(folder.path, 1, 2, R"({"rays":32,"parts":[1,2]})");
    EXPECT_NE(problem({first, other}).find("rays 32, not 64"), std::string::npos);
}

}  // namespace
}  // namespace penumbra::test_fields
