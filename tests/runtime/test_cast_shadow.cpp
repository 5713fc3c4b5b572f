// What characters hide from points that are not their own.
#include <gtest/gtest.h>

#include "pack/pack_asset.h"
#include "runtime/cast/cast_on_cluster.h"
#include "sh/mirrored_product.h"
#include "sh/tangent.h"
#include "tests/difference.h"
#include "tests/runtime/count_allocations.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_cast_shadow {
namespace {

const synthetic::TubeOptions kTube{
    .rings = 20, .segments = 9, .joints = 6, .clusters = 4, .components = 5, .inputs = 4};
const float kFree = 2 * std::sqrt(std::numbers::pi_v<float>);

Affine movedTo(Vec3 position, float yaw = 0) {
    const float c = std::cos(yaw), s = std::sin(yaw);
    return {{c, 0, s, position.x, 0, 1, 0, position.y, -s, 0, c, position.z}};
}

// Points all around the tube, which stands from y = 0 to 4.
struct Points {
    std::vector<Vec3> positions, normals, tangents;

    explicit Points(std::size_t count, const Affine& to_scene = movedTo({})) {
        synthetic::Noise noise(5);
        for (std::size_t i = 0; i < count; ++i) {
            const Vec3 position = Vec3{3 * noise(), 2 + 3 * noise(), 3 * noise()};
            const Vec3 normal = normalized(Vec3{noise(), noise(), noise()});
            const Vec3 tangent = normalized(cross(normal, Vec3{noise(), noise(), noise()}));
            positions.push_back(to_scene.point(position));
            normals.push_back(to_scene.linear() * normal);
            tangents.push_back(to_scene.linear() * tangent);
        }
    }
    CastReceivers all() const { return {positions, normals, tangents}; }
    CastReceivers one(std::size_t i) const {
        return {std::span(positions).subspan(i, 1), std::span(normals).subspan(i, 1),
                std::span(tangents).subspan(i, 1)};
    }
};

// The balls of the tube's fields (tests/synthetic_composition.h), as spheres.
SphereBlockers ballsOf(const Model& model) {
    SphereBlockers blockers;
    for (std::size_t j = 0; j < model.joint_centers.size(); ++j) {
        blockers.spheres.push_back({model.joint_centers[j], 0.22f});
        blockers.joints.push_back(std::uint16_t(j));
    }
    return blockers;
}

// Tubes of one asset, in a row.
struct Crowd {
    Model model;
    Packed packed = packAsset(model, {}, {}, {.precision = AssetPrecision::kF32, .blockers = ballsOf(model)}, "{}", 1);
    AssetView asset = openAsset(packed.bytes);
    std::vector<Evaluator> evaluators;
    std::optional<CastShadow> cast;

    explicit Crowd(std::span<const Affine> to_scene, CasterKind kind = CasterKind::kFields,
                   Model made = synthetic::composedTube(kTube))
        : model(std::move(made)) {
        evaluators.assign(to_scene.size(), Evaluator(asset));
        std::vector<const Evaluator*> casters;
        for (const Evaluator& evaluator : evaluators) casters.push_back(&evaluator);
        cast.emplace(casters, std::vector(casters.size(), kind));
        for (std::size_t c = 0; c < to_scene.size(); ++c) {
            evaluators[c].setFrame(1);
            cast->pose(c, evaluators[c].bones(), to_scene[c]);
        }
    }
    std::vector<float> on(const CastReceivers& receivers, CasterChoice choice = {}) const {
        std::vector<float> out(receivers.positions.size() * kFarCoefficients);
        cast->evaluate(receivers, choice, out);
        return out;
    }
};

class CastShadowOf : public testing::TestWithParam<CasterKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, CastShadowOf, testing::Values(CasterKind::kFields, CasterKind::kSpheres),
                         [](const auto& kind) { return kind.param == CasterKind::kFields ? "Fields" : "Spheres"; });

std::vector<double> ambientOf(std::span<const float> rows) {
    std::array<float, kFarCoefficients> weights;
    ambientWeights(parseConvention("D6"), weights);
    std::vector<double> e(rows.size() / kFarCoefficients);
    for (std::size_t i = 0; i < rows.size(); ++i)
        e[i / kFarCoefficients] += double(weights[i % kFarCoefficients] * rows[i]);
    return e;
}

// The largest share of its sight that any point loses.
double mostHidden(std::span<const float> rows) {
    Largest hidden;
    for (const double e : ambientOf(rows)) hidden.add(1 - e);
    return hidden;
}

// farVisibility() cuts each product off at order 6, and leaves out parts that block less than a thousandth of the
// sphere, of which there are many here. Measured: .0174.
TEST(CastShadow, IsCloseToFarVisibilityOfAllParts) {
    const Crowd crowd(std::vector{movedTo({})});
    const Points points(500);
    const std::vector<float> cast = crowd.on(points.all());
    std::vector<PosedPart> posed(crowd.evaluators[0].farTables().partCount());
    const FarFields& fields = crowd.evaluators[0].farTables().fields();
    poseParts(fields, crowd.evaluators[0].bones(), posed);
    std::vector<std::uint16_t> parts(posed.size());
    for (std::size_t p = 0; p < parts.size(); ++p) parts[p] = std::uint16_t(p);
    std::vector<float> expected(kFarCoefficients);
    Largest blocked;
    double squares = 0;
    for (std::size_t r = 0; r < points.positions.size(); ++r) {
        farVisibility(fields, posed, parts, {points.positions[r], points.normals[r], points.tangents[r]}, expected);
        for (std::size_t i = 0; i < kFarCoefficients; ++i)
            squares += std::pow(cast[r * kFarCoefficients + i] - expected[i], 2);
        blocked.add(1 - expected[0] / kFree);
    }
    EXPECT_GT(blocked, 0.15);
    EXPECT_LT(std::sqrt(squares / double(cast.size())), 0.02);
}

// Which receivers are neighbours decides only what is skipped because it counts for none of them. Lanes are filled up
// differently, which changes the last bits of numbers around 3.5. Measured: 8e-6.
TEST_P(CastShadowOf, DoesNotDependOnNeighbours) {
    const Crowd crowd(std::vector{movedTo({}), movedTo({2, 0, 0}, 1), movedTo({0, 0, 9})}, GetParam());
    const Points points(200);
    const std::vector<float> together = crowd.on(points.all());
    EXPECT_GT(mostHidden(together), 0.3);
    for (std::size_t r = 0; r < points.positions.size(); ++r) {
        const std::span row = std::span(together).subspan(r * kFarCoefficients, kFarCoefficients);
        EXPECT_LT(largestDifference(crowd.on(points.one(r)), row), 2e-5);
    }
}

TEST_P(CastShadowOf, MovesWithTheScene) {
    const Affine moved = movedTo({5, -2, 3}, 2);
    const Crowd here(std::vector{movedTo({})}, GetParam()), there(std::vector{moved}, GetParam());
    const std::vector<float> rows = here.on(Points(200).all());
    EXPECT_GT(mostHidden(rows), 0.1);
    EXPECT_LT(largestDifference(rows, there.on(Points(200, moved).all())), 2e-4);
}

// Two characters apart hide what each hides alone, where one of them hides nothing.
TEST_P(CastShadowOf, ChoosesCasters) {
    const Crowd both(std::vector{movedTo({}), movedTo({2, 0, 0})}, GetParam());
    const Crowd first(std::vector{movedTo({})}, GetParam()), second(std::vector{movedTo({2, 0, 0})}, GetParam());
    const Points points(200);
    EXPECT_EQ(both.on(points.all(), {.only = 0}), first.on(points.all()));
    EXPECT_EQ(both.on(points.all(), {.except = 0}), second.on(points.all()));
    EXPECT_GT(largestDifference(both.on(points.all()), first.on(points.all())), 0.1);
}

TEST_P(CastShadowOf, NobodyInReachLeavesFreeSight) {
    const Crowd crowd(std::vector{movedTo({1000, 0, 0})}, GetParam());
    const Points points(100);
    std::vector<float> out(100 * kFarCoefficients, -7);
    EXPECT_EQ(crowd.cast->evaluate(points.all(), {}, out), 0u);
    for (std::size_t i = 0; i < out.size(); ++i) EXPECT_EQ(out[i], i % kFarCoefficients == 0 ? kFree : 0.0f);
    EXPECT_EQ(CastShadow({}).evaluate(points.all(), {}, out), 0u);
    Crowd here(std::vector{movedTo({})}, GetParam());
    EXPECT_GT(here.cast->evaluate(points.all(), {}, out), 0u);
    here.cast->hide(0);
    EXPECT_EQ(here.cast->evaluate(points.all(), {}, out), 0u);
}

// A caster fades as it goes away: no step of E is large, and none is larger than those next to it.
TEST_P(CastShadowOf, FadesWithDistance) {
    Crowd crowd(std::vector{movedTo({})}, GetParam());
    const std::vector<Vec3> position = {{0, 0, 0}}, normal = {{0, 1, 0}}, tangent = {{0, 0, 1}};
    std::array<float, kFarCoefficients> weights;
    ambientWeights(parseConvention("D6"), weights);
    std::vector<double> e;
    for (int step = 0; step < 4000; ++step) {
        crowd.cast->pose(0, crowd.evaluators[0].bones(), movedTo({0.3f + 0.01f * float(step), 0, 0}));
        const std::vector<float> row = crowd.on({position, normal, tangent});
        e.push_back(0);
        for (std::size_t i = 0; i < kFarCoefficients; ++i) e.back() += weights[i] * row[i];
    }
    EXPECT_LT(e.front(), 0.9);
    EXPECT_NEAR(e.back(), 1, 1e-6);
    Largest largest;
    for (std::size_t i = 200; i < e.size(); ++i) largest.add(std::abs(e[i] - e[i - 1]));
    EXPECT_LT(largest, 2e-4) << "a centimetre";
}

// Points pass through the tube in steps of a fifth of a percent of its width, as one character walks through another.
// E falls to that of the inside without a jump. Measured: .0089.
TEST(CastShadow, NothingPopsOnTheWayThrough) {
    const Crowd crowd(std::vector{movedTo({})});
    std::array<float, kFarCoefficients> weights;
    ambientWeights(parseConvention("D6"), weights);
    Largest largest;
    double least = 1;
    const Vec3 center = crowd.evaluators[0].posedParts()[2].center;
    for (const Vec3 normal : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{-1, 0, 0}}) {
        const std::vector<Vec3> normals = {normal}, tangents = {{0, 0, 1}};
        double before = -1;
        for (int step = 0; step < 2000; ++step) {
            const std::vector<Vec3> positions = {center + Vec3{-1 + 0.001f * float(step), 0, 0.02f}};
            const std::vector<float> row = crowd.on({positions, normals, tangents});
            double e = 0;
            for (std::size_t i = 0; i < kFarCoefficients; ++i) e += weights[i] * row[i];
            if (before >= 0) largest.add(std::abs(e - before));
            before = e;
            least = std::min(least, e);
        }
    }
    EXPECT_LT(least, 0.1);
    EXPECT_LT(largest, 0.012);
}

TEST_P(CastShadowOf, AllocatesNothing) {
    Crowd crowd(std::vector{movedTo({}), movedTo({2, 0, 0})}, GetParam());
    const Points points(200);
    std::vector<float> out(200 * kFarCoefficients);
    crowd.cast->evaluate(points.all(), {}, out);
    const std::size_t before = allocationCount();
    crowd.cast->pose(0, crowd.evaluators[0].bones(), movedTo({0.1f, 0, 0}));
    crowd.cast->evaluate(points.all(), {}, out);
    EXPECT_EQ(allocationCount() - before, 0u);
}

// The same balls as fields and as spheres. Parts that hide little count four fifths as fields, and whole as spheres.
TEST(CastShadow, SpheresHideWhatFieldsOfSpheresHide) {
    const Crowd fields(std::vector{movedTo({})}), spheres(std::vector{movedTo({})}, CasterKind::kSpheres);
    const Points points(500);
    const std::vector<double> a = ambientOf(fields.on(points.all())), b = ambientOf(spheres.on(points.all()));
    Largest hidden;
    double squares = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (a[i] < 0.5) continue;  // points inside of a ball, which goes dark as a field and fades as a sphere
        squares += std::pow(a[i] - b[i], 2);
        hidden.add(1 - a[i]);
        ++count;
    }
    EXPECT_GT(hidden, 0.15);
    EXPECT_LT(std::sqrt(squares / double(count)), 0.012);
}

// A tube whose bake had a ball beside it that stood still.
Model tubeBesideBall() {
    Model model = synthetic::composedTube(kTube);
    synthetic::addStillBall(model, {1.5f, 1, 0});
    return model;
}

// What was baked beside a character goes where the character goes. Sums in another place round differently; measured:
// 5e-5.
TEST(CastShadow, StillPartsStandWithTheirCharacter) {
    const Affine moved = movedTo({4, 0.5f, -3}, 1.1f);
    const Crowd here(std::vector{movedTo({})}, CasterKind::kFields, tubeBesideBall()),
        there(std::vector{moved}, CasterKind::kFields, tubeBesideBall());
    const Points at_home(300), away(300, moved);
    const std::vector<double> expected = ambientOf(here.on(at_home.all())), e = ambientOf(there.on(away.all()));
    for (std::size_t i = 0; i < e.size(); ++i) EXPECT_NEAR(e[i], expected[i], 1e-3);
    const std::vector<Vec3> below = {moved.point({1.5f, 0.7f, 0})}, up = {{0, 1, 0}}, tangent = {{0, 0, 1}};
    const Crowd alone(std::vector{moved});
    EXPECT_LT(ambientOf(there.on({below, up, tangent}))[0], ambientOf(alone.on({below, up, tangent}))[0] - 0.25);
}

// A scene may have casters of both kinds. They multiply as two of a kind do.
TEST(CastShadow, KindsMultiply) {
    const std::vector places = {movedTo({}), movedTo({1.2f, 0, 0})};
    const Crowd crowd(places);
    std::vector<const Evaluator*> casters;
    for (const Evaluator& evaluator : crowd.evaluators) casters.push_back(&evaluator);
    CastShadow both(casters, std::array{CasterKind::kFields, CasterKind::kSpheres});
    for (std::size_t c = 0; c < 2; ++c) both.pose(c, casters[c]->bones(), places[c]);
    const Points points(300);
    std::vector<float> rows[3];
    const std::size_t choices[] = {kNobody, 1, 0};
    for (std::size_t k = 0; k < 3; ++k) {
        rows[k].resize(300 * kFarCoefficients);
        both.evaluate(points.all(), {.except = choices[k]}, rows[k]);
    }
    std::array<float, kFarCoefficients> expected;
    const std::vector<double> e[3] = {ambientOf(rows[0]), ambientOf(rows[1]), ambientOf(rows[2])};
    std::size_t compared = 0;
    for (std::size_t first = 0; first < rows[0].size(); first += kFarCoefficients) {
        const std::size_t r = first / kFarCoefficients;
        if (std::ranges::any_of(e, [&](const auto& one) { return one[r] < 1e-4 || one[r] > 1 - 1e-4; })) continue;
        multiplyMirrored(6, std::span(rows[1]).subspan(first, kFarCoefficients), 6,
                         std::span(rows[2]).subspan(first, kFarCoefficients), 6, expected);
        EXPECT_LT(largestDifference(expected, std::span(rows[0]).subspan(first, kFarCoefficients)), 1e-4);
        ++compared;
    }
    EXPECT_GT(compared, 50u);
}

// Many casters in one place hide what one hides, or a little more. Bands ring, and none of that may add up.
TEST_P(CastShadowOf, APileOfCastersStaysFinite) {
    const Points points(200);
    const std::vector<double> one = ambientOf(Crowd(std::vector{movedTo({})}, GetParam()).on(points.all()));
    for (const std::size_t count : {5u, 20u, 100u, 400u}) {
        const std::vector<double> e = ambientOf(Crowd(std::vector(count, movedTo({})), GetParam()).on(points.all()));
        EXPECT_GT(largestOf(e), 0.2) << count << ": some points hardly see the pile";
        for (std::size_t i = 0; i < e.size(); ++i) {
            ASSERT_TRUE(std::isfinite(e[i])) << count;
            EXPECT_GT(e[i], -1e-4) << count;
            EXPECT_LT(e[i], std::min(1.0001, one[i] + 0.25)) << count;
        }
    }
}

TEST_P(CastShadowOf, ACrowdAllocatesNothing) {
    std::vector<Affine> places;
    for (int i = 0; i < 100; ++i) places.push_back(movedTo({0.3f * float(i % 10), 0, 0.3f * float(i / 10)}));
    const Crowd crowd(places, GetParam());
    const Points points(200);
    std::vector<float> out(200 * kFarCoefficients);
    crowd.cast->evaluate(points.all(), {}, out);
    const std::size_t before = allocationCount();
    crowd.cast->evaluate(points.all(), {}, out);
    EXPECT_EQ(allocationCount() - before, 0u);
}

// A tube with many vertices, beside casters.
const synthetic::TubeOptions kFineTube{
    .rings = 90, .segments = 24, .joints = 6, .clusters = 4, .components = 5, .inputs = 4};
struct Skinned {
    Crowd one{std::vector{movedTo({})}, CasterKind::kFields, synthetic::composedTube(kFineTube)};
    Points points{0};

    Skinned() {
        const Evaluator& evaluator = one.evaluators[0];
        const std::size_t count = evaluator.vertexCount();
        for (std::vector<Vec3>* out : {&points.positions, &points.normals, &points.tangents}) out->resize(count);
        evaluator.skin(0, points.positions, points.normals, points.tangents);
    }
    // With anchors.
    std::size_t past(const CastShadow& cast, std::vector<float>& out, std::size_t from = 0, std::size_t to = kNobody) {
        const Evaluator& evaluator = one.evaluators[0];
        std::size_t seen = 0;
        out.resize(points.positions.size() * kFarCoefficients, -7);
        for (std::size_t c = 0; c < evaluator.clusterCount(); ++c) {
            const ClusterView& cluster = evaluator.asset().model.clusters[c];
            const std::size_t begin = std::max<std::size_t>(from, cluster.first_vertex),
                              end = std::min<std::size_t>(to, cluster.first_vertex + cluster.vertex_count);
            if (begin >= end) continue;
            const auto at = [&](std::size_t v) {
                return Receiver{points.positions[v], points.normals[v], points.tangents[v]};
            };
            seen += castOnCluster(cast, {}, {evaluator, c, begin, end}, at,
                                  std::span(out).subspan(begin * kFarCoefficients, (end - begin) * kFarCoefficients));
        }
        return seen;
    }
};

// Measured with fields: an rms of .0051 and .0194 at most. Balls of 0.22 m hide more than parts of a person do, for
// which docs/scene.md has the error. Spheres are not summed by approximation, so their bound is lower.
TEST_P(CastShadowOf, AnchorsComeNearEveryVertex) {
    Skinned receiver;
    for (const float distance : {0.5f, 0.8f, 1.5f, 3.0f}) {
        const Crowd casters(std::vector{movedTo({distance, 0, 0}), movedTo({0, 0, -1.2f * distance}, 1)}, GetParam());
        std::vector<float> anchored;
        EXPECT_EQ(receiver.past(*casters.cast, anchored), receiver.points.positions.size());
        const std::vector<double> e = ambientOf(anchored), expected = ambientOf(casters.on(receiver.points.all()));
        Largest largest, hidden;
        double squares = 0;
        for (std::size_t v = 0; v < e.size(); ++v) {
            squares += std::pow(e[v] - expected[v], 2);
            largest.add(std::abs(e[v] - expected[v]));
            hidden.add(1 - expected[v]);
        }
        EXPECT_GT(hidden, distance < 1 ? 0.1 : 0.01);
        const bool fields = GetParam() == CasterKind::kFields;
        EXPECT_LT(std::sqrt(squares / double(e.size())), fields ? 0.0065 : 0.002) << distance;
        EXPECT_LT(largest, fields ? 0.025 : 0.015) << distance;
    }
}

// What is nearer to anchors than 4 of their spacings is multiplied in one by one, as it is without anchors.
TEST_P(CastShadowOf, AnchorsLeaveOutWhatIsNear) {
    Skinned receiver;
    const Crowd caster(std::vector{movedTo({0.3f, 0, 0})}, GetParam());
    std::vector<float> anchored;
    receiver.past(*caster.cast, anchored);
    const std::vector<double> e = ambientOf(anchored), expected = ambientOf(caster.on(receiver.points.all()));
    const std::size_t darkest = std::size_t(std::ranges::min_element(expected) - expected.begin());
    EXPECT_LT(expected[darkest], 0.6);
    EXPECT_NEAR(e[darkest], expected[darkest], 0.02);
}

// As a caster walks past in millimetres, E of a vertex moves by hardly more than it does without anchors.
TEST_P(CastShadowOf, NothingPopsAtAnchors) {
    Skinned receiver;
    Crowd caster(std::vector{movedTo({})}, GetParam());
    std::vector<float> anchored, each;
    std::vector<double> before, before_each;
    Largest largest, anchored_largest, excess;
    for (int step = 0; step < 150; ++step) {
        caster.cast->pose(0, caster.evaluators[0].bones(), movedTo({0.35f + 0.004f * float(step), 0, 0.1f}));
        receiver.past(*caster.cast, anchored, 0, 300);
        const std::span<const float> rows = std::span(anchored).first(300 * kFarCoefficients);
        const Points& p = receiver.points;
        const std::vector<double> e = ambientOf(rows),
                                  expected = ambientOf(
                                      caster.on({std::span(p.positions).first(300), std::span(p.normals).first(300),
                                                 std::span(p.tangents).first(300)}));
        for (std::size_t v = 0; v < before.size(); ++v) {
            const double moved = std::abs(e[v] - before[v]), moved_each = std::abs(expected[v] - before_each[v]);
            largest.add(moved_each);
            anchored_largest.add(moved);
            excess.add(moved - moved_each);
        }
        before = e;
        before_each = expected;
    }
    EXPECT_GT(largest, 0.002);
    EXPECT_GT(anchored_largest, 0.8 * largest) << "it moves";
    EXPECT_LT(excess, 0.002) << "in 4 mm";
}

// Numbers of a vertex do not depend on the range that is asked for. Lanes are filled up differently.
TEST_P(CastShadowOf, RangesOfACharacterAgree) {
    Skinned receiver;
    const Crowd caster(std::vector{movedTo({0.6f, 0, 0})}, GetParam());
    std::vector<float> whole, pieces;
    receiver.past(*caster.cast, whole);
    for (std::size_t begin = 0; begin < receiver.points.positions.size(); begin += 177)
        receiver.past(*caster.cast, pieces, begin, begin + 177);
    EXPECT_GT(mostHidden(whole), 0.1);
    EXPECT_LT(largestDifference(whole, pieces), 2e-5);
}

TEST_P(CastShadowOf, NobodyInReachOfACharacterLeavesFreeSight) {
    Skinned receiver;
    const Crowd caster(std::vector{movedTo({1000, 0, 0})}, GetParam());
    std::vector<float> out;
    EXPECT_EQ(receiver.past(*caster.cast, out), 0u);
    for (std::size_t i = 0; i < out.size(); ++i) EXPECT_EQ(out[i], i % kFarCoefficients == 0 ? kFree : 0.0f);
}

// More casters around than the kernel multiplies in one by one: all are multiplied without anchors.
TEST_P(CastShadowOf, APileBesideACharacterHasNoAnchors) {
    Skinned receiver;
    const Crowd pile(std::vector(40, movedTo({0.4f, 0, 0})), GetParam());
    std::vector<float> out;
    receiver.past(*pile.cast, out);
    const std::vector<double> e = ambientOf(out), expected = ambientOf(pile.on(receiver.points.all()));
    for (std::size_t v = 0; v < e.size(); ++v) ASSERT_NEAR(e[v], expected[v], 0.03) << v;
}

TEST_P(CastShadowOf, AnchorsAllocateNothing) {
    Skinned receiver;
    Crowd casters(std::vector{movedTo({0.5f, 0, 0}), movedTo({2, 0, 0})}, GetParam());
    std::vector<float> out;
    receiver.past(*casters.cast, out);
    const std::size_t before = allocationCount();
    casters.cast->pose(0, casters.evaluators[0].bones(), movedTo({0.52f, 0, 0}));
    receiver.past(*casters.cast, out);
    EXPECT_EQ(allocationCount() - before, 0u);
}

TEST(CastShadow, RefusesTooManyParts) {
    Crowd crowd(std::vector{movedTo({})});
    const std::vector<const Evaluator*> many(70000 / kTube.joints, &crowd.evaluators[0]);
    EXPECT_THROW(CastShadow cast(many), std::length_error);
}

}  // namespace
}  // namespace penumbra::test_cast_shadow
