#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "fit/blockers/find_feet.h"
#include "fit/blockers/fit_blockers.h"
#include "fit/blockers/k_means.h"
#include "fit/blockers/silhouette.h"
#include "fit/blockers/surface_samples.h"
#include "formats/common/errors.h"
#include "tests/sh/golden.h"
#include "tests/synthetic_cloth.h"
#include "tests/synthetic_model.h"

namespace penumbra::test_blockers {
namespace {

constexpr double kPi = std::numbers::pi;

// --- Silhouettes ----------------------------------------------------------------------------------------------------

// The bounds are twice what was measured.
TEST(SilhouetteArea, OfSpheresMatchesClosedForms) {
    const std::vector<CasterSphere> one = {{{1, -2, 3}, 0.5f}};
    for (const Vec3d view : silhouetteViews(7)) EXPECT_NEAR(silhouetteArea(one, view), kPi / 4, 2e-4);
    const std::vector<CasterSphere> apart = {{{0, 0, 0}, 0.5f}, {{2, 0, 0}, 0.25f}};
    EXPECT_NEAR(silhouetteArea(apart, {0, 0, 1}), kPi * (0.25 + 0.0625), 3e-4);
    EXPECT_NEAR(silhouetteArea(apart, {1, 0, 0}), kPi * 0.25, 2e-4);  // the smaller one is behind
    // Two unit discs at the distance 1 share 2 pi / 3 - sqrt(3) / 2.
    const std::vector<CasterSphere> lens = {{{0, 0, 0}, 1}, {{0, 1, 0}, 1}};
    EXPECT_NEAR(silhouetteArea(lens, {0, 0, 1}), 2 * kPi - (2 * kPi / 3 - std::sqrt(3) / 2), 1e-3);
    EXPECT_EQ(silhouetteArea(std::vector<CasterSphere>{}, {0, 0, 1}), 0);
}

// Makes a box of 1 x 2 x 3.
Mesh box() {
    Mesh mesh;
    for (int i = 0; i < 8; ++i) mesh.rest_positions.push_back({float(i & 1), 2 * float(i >> 1 & 1), 3 * float(i >> 2)});
    for (const std::array<std::uint32_t, 4>& face : {std::array<std::uint32_t, 4>{0, 2, 3, 1},
                                                     {4, 5, 7, 6},
                                                     {0, 1, 5, 4},
                                                     {2, 6, 7, 3},
                                                     {0, 4, 6, 2},
                                                     {1, 3, 7, 5}}) {
        mesh.triangles.push_back({face[0], face[1], face[2]});
        mesh.triangles.push_back({face[0], face[2], face[3]});
    }
    return mesh;
}

TEST(SilhouetteArea, OfAConvexMeshIsAQuarterOfItsSurfaceOnAverage) {
    const Mesh mesh = box();
    const auto area = [&](Vec3d view) { return silhouetteArea(mesh.triangles, mesh.rest_positions, view); };
    EXPECT_NEAR(area({1, 0, 0}), 6, 1e-9);
    EXPECT_NEAR(area({0, 1, 0}), 3, 1e-9);
    EXPECT_NEAR(area({0, 0, 1}), 2, 1e-9);
    double mean = 0;
    const std::vector<Vec3d> views = silhouetteViews(500);
    for (const Vec3d view : views) mean += area(view) / double(views.size());
    EXPECT_NEAR(mean, 22.0 / 4, 0.02);  // Cauchy; 0.005 was measured
}

// --- k-means --------------------------------------------------------------------------------------------------------

std::vector<Vec3d> fourClouds() {
    std::mt19937 random(3);
    const auto noise = [&] { return double(random()) / 4294967296.0 - 0.5; };
    std::vector<Vec3d> points;
    for (int i = 0; i < 400; ++i) points.push_back({10.0 * (i % 4) + noise(), noise(), noise()});
    return points;
}

TEST(GroupPoints, FindsCloudsAndDependsOnTheSeedAlone) {
    const std::vector<Vec3d> points = fourClouds();
    const PointGroups groups = groupPoints(points, 4, 1);
    ASSERT_EQ(groups.centers.size(), 4u);
    for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_EQ(groups.group_of_point[i], groups.group_of_point[i % 4]) << i;
    for (const Vec3d center : groups.centers) {
        EXPECT_NEAR(center.x, 10 * std::round(center.x / 10), 0.1);
        EXPECT_NEAR(center.y, 0, 0.1);
    }
    EXPECT_EQ(groupPoints(points, 4, 1).centers, groups.centers);
}

TEST(GroupPoints, HasNoGroupWithoutAPlaceOfItsOwn) {
    const std::vector<Vec3d> points = {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {1, 0, 0}};
    const PointGroups groups = groupPoints(points, 3, 5);
    EXPECT_EQ(groups.centers.size(), 2u);
    EXPECT_EQ(groups.squares, 0);
    EXPECT_EQ(groupPoints(std::vector<Vec3d>{{1, 2, 3}}, 3, 0).centers, (std::vector<Vec3d>{{1, 2, 3}}));
    const PointGroups improved = improveGroups(points, {{0, 0, 0}, {1, 0, 0}, {9, 9, 9}});
    EXPECT_EQ(improved.centers, (std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}}));
    EXPECT_EQ(improved.group_of_point, (std::vector<std::uint32_t>{0, 1, 0, 1}));
}

// --- The golden humanoid --------------------------------------------------------------------------------------------

// The solid of tests/golden/sphere_set.json: tapered capsules, z up. Distances are those of the axis less the radius,
// which is linear along the axis.
struct Capsule {
    Vec3d head, tail;
    double head_radius, tail_radius;
};

std::vector<Capsule> capsulesOf(const nlohmann::json& golden) {
    std::vector<Capsule> capsules;
    for (const auto& bone : golden.at("bones"))
        capsules.push_back({vec3(bone.at("head")), vec3(bone.at("tail")), bone.at("r_head"), bone.at("r_tail")});
    return capsules;
}

double distanceTo(const Capsule& c, Vec3d point) {
    const Vec3d axis = c.tail - c.head;
    const double u = std::clamp(dot(point - c.head, axis) / dot(axis, axis), 0.0, 1.0);
    return length(point - (c.head + axis * u)) - (c.head_radius + (c.tail_radius - c.head_radius) * u);
}

// Fills each capsule with spheres so close to one another that their union has the silhouette of the solid.
std::vector<CasterSphere> filled(const std::vector<Capsule>& capsules) {
    std::vector<CasterSphere> spheres;
    for (const Capsule& c : capsules)
        for (int i = 0; i <= 40; ++i) {
            const double u = i / 40.0;
            spheres.push_back(
                {toFloat(c.head + (c.tail - c.head) * u), float(c.head_radius + (c.tail_radius - c.head_radius) * u)});
        }
    return spheres;
}

// Returns points spread evenly over the surface of the solid: those of each capsule that are in no other one.
std::vector<Vec3d> surfacePoints(const std::vector<Capsule>& capsules, int count) {
    std::mt19937 random(11);
    const auto next = [&] { return double(random()) / 4294967296.0; };
    std::vector<double> areas;
    double sum = 0;
    for (const Capsule& c : capsules) {
        const double radius = (c.head_radius + c.tail_radius) / 2;
        sum += 2 * kPi * radius * length(c.tail - c.head) + 4 * kPi * radius * radius;
        areas.push_back(sum);
    }
    std::vector<Vec3d> points;
    while (int(points.size()) < count) {
        const double place = next() * sum;
        const std::size_t k = std::size_t(std::lower_bound(areas.begin(), areas.end(), place) - areas.begin());
        const Capsule& c = capsules[k];
        const Vec3d axis = normalized(c.tail - c.head);
        const double z = 2 * next() - 1, turn = 2 * kPi * next(), flat = std::sqrt(1 - z * z);
        Vec3d d{flat * std::cos(turn), flat * std::sin(turn), z};
        const double reach = length(c.tail - c.head), radius = (c.head_radius + c.tail_radius) / 2;
        const double u = next() * (reach + 2 * radius) - radius;  // a cap has the area of a cylinder as high
        double along = std::clamp(u / reach, 0.0, 1.0);
        if (u < 0) d = d * (dot(d, axis) > 0 ? -1.0 : 1.0);
        if (u > reach) d = d * (dot(d, axis) < 0 ? -1.0 : 1.0);
        if (u >= 0 && u <= reach) d = normalized(d - axis * dot(d, axis));
        const double r = c.head_radius + (c.tail_radius - c.head_radius) * along;
        const Vec3d point = c.head + axis * (reach * along) + d * r;
        const bool outside = std::none_of(capsules.begin(), capsules.end(),
                                          [&](const Capsule& other) { return distanceTo(other, point) < -1e-6; });
        if (outside) points.push_back(point);
    }
    return points;
}

struct GoldenSpheres {
    std::vector<Vec3d> centers;
    std::vector<double> radii;
};

GoldenSpheres goldenSpheres(const nlohmann::json& golden, const char* count) {
    GoldenSpheres spheres;
    for (const auto& c : golden.at("proxies").at(count).at("C")) spheres.centers.push_back(vec3(c));
    spheres.radii = doubles(golden.at("proxies").at(count).at("R"));
    return spheres;
}

double meanArea(std::span<const CasterSphere> spheres) {
    double sum = 0;
    const std::vector<Vec3d> views = silhouetteViews(24);
    for (const Vec3d view : views) sum += silhouetteArea(spheres, view);
    return sum / double(views.size());
}

// The golden radii have one factor that gives the spheres the silhouettes of the solid. Ours has them too: the golden
// areas are from other views and 128 x 128 pixels, and differ by 0.6% at most.
TEST(GoldenSphereSet, HasTheSilhouettesOfTheSolid) {
    const nlohmann::json golden = readGolden("sphere_set.json");
    const double solid = meanArea(filled(capsulesOf(golden)));
    for (const char* count : {"10", "15", "20"}) {
        const GoldenSpheres spheres = goldenSpheres(golden, count);
        std::vector<CasterSphere> blockers;
        for (std::size_t i = 0; i < spheres.radii.size(); ++i)
            blockers.push_back({toFloat(spheres.centers[i]), float(spheres.radii[i])});
        EXPECT_NEAR(meanArea(blockers) / solid, 1, 0.012) << count;
    }
}

// Each golden center is the mean of the points that are nearest to it, and the golden radii are mean distances times
// one factor, which the study that the file comes from has as 0.93 to 0.97. Our points on the same solid are others.
// Measured: centers 17 mm apart at most, radii within 6%, factors 0.940, 0.942 and 0.953.
TEST(GoldenSphereSet, HasMeansAndMeanDistances) {
    const nlohmann::json golden = readGolden("sphere_set.json");
    const std::vector<Vec3d> points = surfacePoints(capsulesOf(golden), 20000);
    for (const char* count : {"10", "15", "20"}) {
        const GoldenSpheres spheres = goldenSpheres(golden, count);
        const std::size_t groups = spheres.centers.size();
        std::vector<Vec3d> mean(groups);
        std::vector<double> distance(groups), number(groups);
        for (const Vec3d& point : points) {
            const auto nearer = [&](Vec3d a, Vec3d b) { return length(a - point) < length(b - point); };
            const auto g = std::size_t(std::min_element(spheres.centers.begin(), spheres.centers.end(), nearer) -
                                       spheres.centers.begin());
            mean[g] += point;
            distance[g] += length(point - spheres.centers[g]);
            ++number[g];
        }
        double factor = 0;
        for (std::size_t g = 0; g < groups; ++g) factor += spheres.radii[g] * number[g] / distance[g] / double(groups);
        EXPECT_NEAR(factor, 0.945, 0.02) << count;
        for (std::size_t g = 0; g < groups; ++g) {
            EXPECT_LT(length(mean[g] / number[g] - spheres.centers[g]), 0.025) << count << " " << g;
            EXPECT_NEAR(spheres.radii[g] * number[g] / distance[g] / factor, 1, 0.08) << count << " " << g;
        }
    }
}

// Our k-means of other points, started at the golden centers, stays there. (With 20 groups it finds better ones.)
TEST(GoldenSphereSet, IsWhereOurGroupsAre) {
    const nlohmann::json golden = readGolden("sphere_set.json");
    const std::vector<Vec3d> points = surfacePoints(capsulesOf(golden), 20000);
    for (const char* count : {"10", "15"}) {
        const GoldenSpheres spheres = goldenSpheres(golden, count);
        const PointGroups groups = improveGroups(points, spheres.centers);
        ASSERT_EQ(groups.centers.size(), spheres.centers.size()) << count;
        for (std::size_t g = 0; g < groups.centers.size(); ++g)
            EXPECT_LT(length(groups.centers[g] - spheres.centers[g]), 0.04) << count << " " << g;
        // Starts of our own end no worse.
        EXPECT_LT(groupPoints(points, int(groups.centers.size()), 1).squares, 1.02 * groups.squares) << count;
    }
}

// --- Samples and feet -----------------------------------------------------------------------------------------------

TEST(SampleSurface, TakesPointsByArea) {
    const Mesh mesh = box();
    Skin skin;
    skin.joint_names = {"low", "high"};
    skin.parents = {-1, 0};
    skin.influences = 1;
    for (const Vec3& p : mesh.rest_positions) skin.joints.push_back(p.z > 1);
    skin.weights.assign(8, 1);
    const SurfaceSamples samples = sampleSurface(mesh, skin, 2200, 1);
    ASSERT_EQ(samples.points.size(), 2200u);
    int bottom = 0, front = 0;
    for (std::size_t i = 0; i < samples.points.size(); ++i) {
        const Vec3d p = samples.points[i];
        bottom += p.z < 1e-6;
        front += p.y < 1e-6;
        EXPECT_GE(std::min({p.x, p.y, p.z}), -1e-6);
    }
    EXPECT_NEAR(bottom, 200, 2);  // 2 of 22, exact up to the two pieces at the ends
    EXPECT_NEAR(front, 300, 2);
    EXPECT_EQ(sampleVertices(mesh, skin).points.size(), 8u);
    Mesh flat = mesh;
    flat.triangles.clear();
    EXPECT_TRUE(sampleSurface(flat, skin, 10, 1).points.empty());
}

// A trunk with two legs of shin, foot and toe, and an arm that reaches as low as a knee.
struct Legs {
    SurfaceSamples samples;
    std::vector<std::int32_t> parents{-1, 0, 1, 2, 0, 4, 5, 0};
    std::vector<Affine> bones;

    explicit Legs(int poses) {
        const auto add = [&](Vec3d at, std::uint16_t joint, int count) {
            for (int i = 0; i < count; ++i) {
                samples.points.push_back(at + Vec3d{0.001 * i, 0, 0});
                samples.joint.push_back(joint);
            }
        };
        add({0, 1.5, 0}, 0, 60);
        for (const std::uint16_t side : {1, 4}) {
            const double x = side == 1 ? -0.2 : 0.2;
            add({x, 0.5, 0}, side, 10);
            add({x, 0.03, 0}, std::uint16_t(side + 1), 5);
            add({x, 0.01, 0.1}, std::uint16_t(side + 2), 3);
        }
        add({0.5, 0.6, 0}, 7, 10);
        for (int pose = 0; pose < poses; ++pose)
            for (std::size_t j = 0; j < parents.size(); ++j) {
                Affine bone;
                // One leg is lifted in every second pose, the other one in all others; all jump in the last pose.
                const bool left = j >= 1 && j <= 3, right = j >= 4 && j <= 6;
                if ((left && pose % 2 == 0) || (right && pose % 2 == 1)) bone.m[7] = 0.4f;
                if (pose == poses - 1) bone.m[7] += 3;
                bones.push_back(bone);
            }
    }
};

TEST(FindFeet, AreTheEndsOfLimbsThatTouchTheGround) {
    const Legs legs(8);
    const std::vector<std::uint16_t> feet = findFeet(legs.samples, legs.parents, legs.bones);
    EXPECT_EQ(feet, (std::vector<std::uint16_t>{2, 5}));
    EXPECT_EQ(footOfJoint(feet, legs.parents), (std::vector<int>{-1, -1, 0, 0, -1, 1, 1, -1}));
    EXPECT_TRUE(findFeet(legs.samples, legs.parents, {}).empty());
    EXPECT_TRUE(findFeet(legs.samples, legs.parents, legs.bones, {.most_area = 0.01}).empty());
}

TEST(GroupBlockers, GiveEachFootTwoSpheres) {
    const Legs legs(8);
    const std::vector<int> foot_of_joint = footOfJoint(std::vector<std::uint16_t>{2, 5}, legs.parents);
    for (const int count : {5, 8, 12}) {
        const GroupedBlockers grouped = groupBlockers(legs.samples, foot_of_joint, count, 1);
        EXPECT_EQ(int(grouped.blockers.spheres.size()), count);
        std::array<int, 2> of_foot{};
        for (const std::uint16_t joint : grouped.blockers.joints)
            if (foot_of_joint[joint] >= 0) ++of_foot[std::size_t(foot_of_joint[joint])];
        EXPECT_THAT(of_foot, testing::Each(testing::Ge(2))) << count;
    }
    // A single sphere goes to the whole, and three to the whole and each foot.
    EXPECT_EQ(groupBlockers(legs.samples, foot_of_joint, 1, 1).blockers.joints, (std::vector<std::uint16_t>{0}));
    EXPECT_EQ(groupBlockers(legs.samples, foot_of_joint, 3, 1).blockers.joints, (std::vector<std::uint16_t>{0, 2, 5}));
}

// --- The whole fit --------------------------------------------------------------------------------------------------

Model bendingTube() { return synthetic::tubeModel({.rings = 30, .segments = 12, .joints = 4, .frames = 12}); }

TEST(FitBlockers, SilhouettesAreAsLargeAsTheMeshs) {
    const Model model = bendingTube();
    const BlockerFit fit = fitBlockers(model, {.spheres = 8}, 2);
    ASSERT_EQ(fit.blockers.spheres.size(), 8u);
    EXPECT_NEAR(fit.area / fit.mesh_area, 1, 1e-5);
    // A tube without ends, 1.8 m long, radius 0.15: the mean silhouette is about a quarter of its hull's surface.
    EXPECT_NEAR(fit.mesh_area, (2 * kPi * 0.15 * 1.8 + 2 * kPi * 0.0225) / 4, 0.05);
    EXPECT_LT(fit.silhouette_error, 0.1);
    EXPECT_EQ(fit.poses, 6u);  // poses in the training clip
    // Each sphere is on the axis, of the joint that it is nearest to.
    for (std::size_t s = 0; s < fit.blockers.spheres.size(); ++s) {
        const CasterSphere& sphere = fit.blockers.spheres[s];
        EXPECT_NEAR(std::hypot(sphere.center.x, sphere.center.z), 0, 0.1);
        const std::uint16_t joint = fit.blockers.joints[s];
        EXPECT_NEAR(model.joint_centers[joint].y, sphere.center.y, 0.35) << s;
        EXPECT_GT(sphere.radius, 0.08);
        EXPECT_LT(sphere.radius, 0.25);
    }
}

// Bands of the range add up to the area.
TEST(SilhouetteBands, AddUpToTheArea) {
    const Mesh mesh = box();
    const std::vector<CasterSphere> spheres = {{{0.5f, 1, 1.5f}, 0.6f}, {{0.2f, 0.8f, 1}, 0.5f}};
    for (const Vec3d view : silhouetteViews(5)) {
        std::array<double, kSilhouetteBands> bands;
        const SilhouetteRange range = rangeOf(mesh.rest_positions, view);
        silhouetteBands(mesh.triangles, mesh.rest_positions, view, range, bands);
        EXPECT_NEAR(std::accumulate(bands.begin(), bands.end(), 0.0),
                    silhouetteArea(mesh.triangles, mesh.rest_positions, view), 1e-9);
        silhouetteBands(spheres, view, {range.low - 1, range.high + 1}, bands);
        EXPECT_NEAR(std::accumulate(bands.begin(), bands.end(), 0.0), silhouetteArea(spheres, view), 2e-3);
    }
}

TEST(RefineRadii, SilhouettesDifferLessAndCentersStay) {
    const Model model = bendingTube();
    const BlockerFit plain = fitBlockers(model, {.spheres = 8}, 2),
                     fit = fitBlockers(model, {.spheres = 8, .refine = true}, 2);
    ASSERT_TRUE(fit.refinement);
    EXPECT_FALSE(plain.refinement);
    EXPECT_LE(fit.refinement->after, fit.refinement->before);
    EXPECT_GT(fit.refinement->steps, 0);
    ASSERT_EQ(fit.blockers.spheres.size(), plain.blockers.spheres.size());
    for (std::size_t s = 0; s < plain.blockers.spheres.size(); ++s)
        EXPECT_EQ(fit.blockers.spheres[s].center, plain.blockers.spheres[s].center);
    EXPECT_EQ(fitBlockers(model, {.spheres = 8, .refine = true}, 1).blockers.spheres, fit.blockers.spheres);
}

TEST(SilhouetteRange, IsTheExtentAcrossTheView) {
    const Mesh mesh = box();
    const SilhouetteRange range = rangeOf(mesh.rest_positions, {0, 0, 1});
    EXPECT_NEAR(range.high - range.low, 2, 1e-6);
}

TEST(FitBlockers, SameResultForAnyThreadCount) {
    const Model model = bendingTube();
    for (const BlockerMethod method : {BlockerMethod::kArea, BlockerMethod::kPaper}) {
        const BlockerFit one = fitBlockers(model, {.method = method}, 1);
        for (const int threads : {2, 5}) {
            const BlockerFit many = fitBlockers(model, {.method = method}, threads);
            EXPECT_EQ(many.blockers.spheres, one.blockers.spheres);
            EXPECT_EQ(many.blockers.joints, one.blockers.joints);
            EXPECT_EQ(many.area, one.area);
        }
    }
    EXPECT_NE(fitBlockers(model, {.seed = 2}, 1).blockers.spheres, fitBlockers(model, {}, 1).blockers.spheres);
}

TEST(FitBlockers, HeldOutFramesDoNotMatter) {
    Model model = bendingTube();
    const BlockerFit before = fitBlockers(model, {}, 1);
    for (std::size_t f = 0; f < model.frames.frameCount(); ++f)
        for (std::size_t j = 0; model.frames.clip[f] == 1 && j < model.skin.jointCount(); ++j)
            model.bones[f * model.skin.jointCount() + j].m[0] = 3;
    EXPECT_EQ(fitBlockers(model, {}, 1).blockers.spheres, before.blockers.spheres);
    // Without training frames it is the rest pose that counts.
    model.holdout_clips = {"bend", "twist"};
    EXPECT_EQ(fitBlockers(model, {}, 1).poses, 1u);
}

// A skeleton that scales by 100 what the rest positions have in other units.
TEST(FitBlockers, BonesMayScale) {
    Model model = bendingTube();
    const BlockerFit plain = fitBlockers(model, {}, 1);
    for (Affine& bone : model.bones)
        for (std::size_t i = 0; i < 12; ++i) bone.m[i] *= 100;
    const BlockerFit scaled = fitBlockers(model, {}, 1);
    EXPECT_NEAR(scaled.mesh_area / plain.mesh_area, 1e4, 1);
    EXPECT_NEAR(scaled.scale, plain.scale, 1e-4);
}

TEST(FitBlockers, PaperSpheresHoldAllVertices) {
    const Model model = bendingTube();
    const BlockerFit fit = fitBlockers(model, {.method = BlockerMethod::kPaper}, 1);
    EXPECT_EQ(fit.scale, 1);
    EXPECT_GT(fit.area, 1.05 * fit.mesh_area);  // they stick out
    for (const Vec3& p : model.mesh.rest_positions) {
        bool held = false;
        for (const CasterSphere& s : fit.blockers.spheres) held |= length(p - s.center) <= s.radius * 1.00001f;
        EXPECT_TRUE(held);
    }
}

TEST(FitBlockers, ClothMovesWithItsNearRigidParts) {
    const Model cloth = synthetic::clothModel();
    const BlockerFit fit = fitBlockers(cloth, {.spheres = 6}, 1);
    EXPECT_NEAR(fit.area / fit.mesh_area, 1, 1e-5);
    EXPECT_TRUE(fit.feet.empty());
    for (const std::uint16_t joint : fit.blockers.joints) EXPECT_LT(joint, cloth.skin.jointCount());
}

TEST(FitBlockers, RefusesWhatHasNoArea) {
    Model model = bendingTube();
    for (Vec3& p : model.mesh.rest_positions) p = {1, 2, 3};
    EXPECT_THROW(fitBlockers(model, {}, 1), InvalidInput);
}

}  // namespace
}  // namespace penumbra::test_blockers
