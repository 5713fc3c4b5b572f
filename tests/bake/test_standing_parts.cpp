// Tests which parts stand, and what the fields of a foot say of the ground below it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bake/fields/part_fields.h"
#include "bake/fields/standing_parts.h"
#include "sh/far/far_visibility.h"
#include "sh/quadrature.h"
#include "sh/visibility_convention.h"
#include "tests/bake/limb_rigs.h"
#include "tests/difference.h"

namespace penumbra::test_standing_parts {
namespace {

// --- Which parts stand ----------------------------------------------------------------------------------------------

TEST(StandingParts, OfAManAreInHisLegs) {
    BakeSource source;
    source.rig = samples::sampleRig("capsule_man.glb");
    const PartTable table = makePartTable(source.mesh(), source.rig->skin);
    const std::vector<bool> stands = standingParts(source, table);
    std::vector<std::string> names;
    for (std::size_t p = 0; p < stands.size(); ++p)
        if (stands[p]) names.push_back(source.rig->skin.joint_names[table.joint_of_part[p]]);
    // His feet are so low that the ends of the shins touch, too.
    EXPECT_THAT(names, testing::UnorderedElementsAre("foot.L", "foot.R", "shin.L", "shin.R"));
    // Without clips the rest pose tells, in which he stands as well.
    source.rig->clips.clear();
    EXPECT_EQ(standingParts(source, table), stands);
}

// --- A foot ---------------------------------------------------------------------------------------------------------

// A box stands for the foot of a man.
const Vec3 kHalf = {0.05f, 0.035f, 0.13f};  // metres
const Vec3 kMiddle = {0.02f, 0.035f, 0.01f};

PartMesh foot() {
    PartMesh mesh;
    for (int c = 0; c < 8; ++c)
        mesh.positions.push_back(kMiddle +
                                 kHalf * Vec3{c & 1 ? 1.0f : -1.0f, c & 2 ? 1.0f : -1.0f, c & 4 ? 1.0f : -1.0f});
    mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                      {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    mesh.stands = true;
    return mesh;
}

// Planes lie outside of the faces by 0.4% of the radius, and a face has at least a tenth of the radius around it.
TEST(PlaceFields, PlanesLieOnTheFacesOfWhatStands) {
    const PartMesh mesh = foot();
    const PartField part = placeFields({&mesh, 1}, 12, 1 << 30)[0];
    const FieldBox& box = part.boxes[0];
    for (int axis = 0; axis < 3; ++axis) {
        const double cell = double(box.high[axis] - box.low[axis]) / double(box.size[std::size_t(axis)] - 1);
        const double below = double(kMiddle[axis] - kHalf[axis] - 0.004f * part.radius - box.low[axis]);
        const double above = double(box.high[axis] - kMiddle[axis] - kHalf[axis] - 0.004f * part.radius);
        EXPECT_NEAR(below / cell, std::round(below / cell), 1e-3) << axis;
        EXPECT_NEAR(above, below, 1e-5) << axis;
        EXPECT_GT(below, 0.1 * double(part.radius)) << axis;
    }
}

TEST(PlaceFields, WhatStandsHasMorePoints) {
    std::vector<PartMesh> meshes = {foot(), foot()};
    meshes[1].stands = false;
    const std::vector<PartField> parts = placeFields(meshes, 12, 1 << 30);
    EXPECT_GT(parts[0].boxes[0].pointCount(), 3 * parts[1].boxes[0].pointCount());
}

// Whether a ray meets the box: it does where its stretches between the three pairs of planes overlap.
bool meetsFoot(Vec3d origin, Vec3d direction) {
    double from = 0, to = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        const double low = (double(kMiddle[axis]) - double(kHalf[axis]) - origin[axis]) / direction[axis];
        const double high = (double(kMiddle[axis]) + double(kHalf[axis]) - origin[axis]) / direction[axis];
        from = std::max(from, std::min(low, high));
        to = std::min(to, std::max(low, high));
    }
    return from < to;
}

double trueAmbient(Vec3d point) {
    static const std::vector<WeightedDirection> directions = gaussHemisphere(16, 64);  // around z
    double sum = 0;
    for (const auto& [d, weight] : directions)
        if (!meetsFoot(point, {d.x, d.z, -d.y})) sum += weight * d.z / std::numbers::pi;
    return sum;
}

class GroundUnderAFoot : public testing::Test {
protected:
    static void SetUpTestSuite() {
        FieldPlan plan;
        plan.file.fields.fade = 0.0075f;
        plan.meshes = {foot()};
        plan.file.fields.parts = placeFields(plan.meshes, 8, 1 << 30);  // as the feet of a man have
        const FieldFile file = bakeFields(plan, {}, 2, ProgressStyle::kNone);
        fields_.tables = {makeFieldTable(file.fields.parts[0], file.fields.bytesOf(0), file.fields.fade)};
        fields_.joints = {0};
    }
    static double ambient(Vec3 point) {
        std::array<PosedPart, 1> posed;
        const Affine bone;
        poseParts(fields_, {&bone, 1}, posed);
        const std::uint16_t part = 0;
        std::array<float, kFarCoefficients> visible, weights;
        farVisibility(fields_, posed, {&part, 1}, {point, {0, 1, 0}, {1, 0, 0}}, visible);
        ambientWeights(parseConvention("D6"), weights);
        double sum = 0;
        for (std::size_t i = 0; i < kFarCoefficients; ++i) sum += double(weights[i] * visible[i]);
        return sum;
    }

private:
    static inline FarFields fields_;
};

// Points of the ground `gap` below the sole, up to 15 cm beside it.
std::vector<Vec3> groundPoints(float gap) {
    std::vector<Vec3> points;
    for (int i = -10; i <= 10; ++i)
        for (int k = -14; k <= 14; ++k)
            points.push_back({kMiddle.x + 0.02f * float(i) + 0.003f, -gap, kMiddle.z + 0.02f * float(k) + 0.003f});
    return points;
}

// Right below the sole E jumps at its rim, which cells of 14 mm cannot follow. At points 1 cm apart the rms was .060
// there, the largest difference .59.
TEST_F(GroundUnderAFoot, AgreesWithCountedRays) {
    struct Case {
        float gap;
        double rms, most;
    };
    for (const auto& [gap, rms, largest] : {Case{0.001f, 0.08, 0.7}, {0.01f, 0.03, 0.2}, {0.05f, 0.03, 0.2}}) {
        Largest most;
        double square = 0;
        const std::vector<Vec3> points = groundPoints(gap);
        for (const Vec3 p : points) {
            const double off = ambient(p) - trueAmbient(toDouble(p));
            square += off * off;
            most.add(std::abs(off));
        }
        EXPECT_LT(std::sqrt(square / double(points.size())), rms) << gap;
        EXPECT_LT(most, largest) << gap;
    }
}

// From the middle of a sole outwards the ground hardly gets darker again: by .036 at most, was measured.
TEST_F(GroundUnderAFoot, HasNoBrightRim) {
    for (const float gap : {0.001f, 0.01f, 0.05f})
        for (const Vec3 way : {Vec3{1, 0, 0}, {-1, 0, 0}, {0, 0, 1}, {0, 0, -1}, {0.6f, 0, 0.8f}}) {
            double brightest = 0;
            Largest drop;
            for (float t = 0; t < 0.3f; t += 0.004f) {
                const double e = ambient(Vec3{kMiddle.x, -gap, kMiddle.z} + way * t);
                drop.add(brightest - e);
                brightest = std::max(brightest, e);
            }
            EXPECT_LT(drop, 0.05) << gap;
        }
    EXPECT_LT(ambient({kMiddle.x, -0.001f, kMiddle.z}), 0.03);
}

}  // namespace
}  // namespace penumbra::test_standing_parts
