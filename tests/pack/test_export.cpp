#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "formats/common/errors.h"
#include "pack/export/export_rows.h"
#include "pack/export/principal_weights.h"
#include "pack/export/turn_to_rest.h"
#include "pack/export/weight_tracks.h"
#include "tests/difference.h"

namespace penumbra::test_export {

namespace {

// Evaluates a track as section 3.11 and appendix C of glTF 2.0 ask.
std::vector<double> trackAt(const WeightTrack& track, float time) {
    const std::size_t m = track.count, keys = track.times.size();
    const bool cubic = track.form == TrackForm::kCubic;
    const auto at = [&](std::size_t key, std::size_t part, std::size_t i) {
        return double(track.values[(cubic ? 3 * key + part : key) * m + i]);
    };
    std::vector<double> out;
    std::size_t k = 0;
    while (k + 1 < keys && track.times[k + 1] <= time) ++k;
    for (std::size_t i = 0; i < m; ++i) {
        if (time <= track.times[0] || k + 1 == keys || track.form == TrackForm::kStep) {
            out.push_back(at(k, 1, i));
            continue;
        }
        const double d = double(track.times[k + 1]) - double(track.times[k]),
                     s = (double(time) - double(track.times[k])) / d;
        const double a = at(k, 1, i), b = at(k + 1, 1, i), s2 = s * s, s3 = s2 * s;
        out.push_back(cubic ? (2 * s3 - 3 * s2 + 1) * a + d * (s3 - 2 * s2 + s) * at(k, 2, i) + (3 * s2 - 2 * s3) * b +
                                  d * (s3 - s2) * at(k + 1, 0, i)
                            : a + (b - a) * s);
    }
    return out;
}

WeightTrack randomTrack(TrackForm form, std::size_t count, std::size_t keys, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> number(-1, 1), step(0.05f, 0.4f);
    WeightTrack track{form, count, {}, {}};
    float time = step(random);
    for (std::size_t k = 0; k < keys; ++k, time += step(random)) track.times.push_back(time);
    for (std::size_t i = 0; i < keys * count * (form == TrackForm::kCubic ? 3 : 1); ++i)
        track.values.push_back(number(random));
    return track;
}

}  // namespace

TEST(WeightTracks, JoinedOnesShowWhatBothShowed) {
    for (const TrackForm form : {TrackForm::kStep, TrackForm::kLinear, TrackForm::kCubic}) {
        const WeightTrack own = randomTrack(form, 2, 7, 1), linear = randomTrack(TrackForm::kLinear, 3, 9, 2);
        const WeightTrack both = joinTracks(own, linear);
        ASSERT_EQ(both.count, 5u);
        for (std::size_t k = 1; k < both.times.size(); ++k) ASSERT_LT(both.times[k - 1], both.times[k]);
        for (float time = -0.1f; time < 3; time += 0.013f) {
            std::vector<double> expected = trackAt(own, time);
            for (const double w : trackAt(linear, time)) expected.push_back(w);
            const std::vector<double> found = trackAt(both, time);
            // Floats of times and values: 4e-7 was measured.
            for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(found[i], expected[i], 3e-6) << int(form) << " " << time;
        }
        const WeightTrack wider = widened(own, 2);
        const std::vector<double> found = trackAt(wider, 0.7f);
        EXPECT_EQ(found, (std::vector<double>{trackAt(own, 0.7f)[0], trackAt(own, 0.7f)[1], 0, 0}));
    }
}

TEST(WeightTracks, KeepTwoKeysAtOneTime) {
    const WeightTrack own{TrackForm::kLinear, 1, {0, 1, 1, 2}, {0, 1, 5, 6}};
    const WeightTrack both = joinTracks(own, {TrackForm::kLinear, 1, {0}, {7}});
    EXPECT_NEAR(trackAt(both, 0.999f)[0], 0.999, 1e-4);
    EXPECT_NEAR(trackAt(both, 1)[0], 5, 1e-6);
    EXPECT_EQ(trackAt(both, 1.5f)[1], 7);
}

TEST(PrincipalWeights, AreExactWithAllAndAsGoodAsToldWithFewer) {
    for (const auto& [frames, vertices] : {std::pair<std::size_t, std::size_t>(6, 40), {30, 5}}) {
        std::mt19937 random(3);
        std::uniform_real_distribution<float> number(0, 1);
        std::vector<float> values(frames * vertices);
        for (float& x : values) x = number(random);
        const PrincipalWeights all = principalWeights(values, frames, {});
        EXPECT_EQ(all.count, std::min(frames - 1, vertices));
        EXPECT_LT(all.max, 1e-6);
        for (std::size_t k = 0; k < all.count; ++k) {
            Largest most;
            for (std::size_t f = 0; f < frames; ++f) most.add(std::abs(all.weights[f * all.count + k]));
            EXPECT_FLOAT_EQ(float(most), 1);
        }
        const double bound = all.rms_of_count[2] * 1.0001;
        const PrincipalWeights few = principalWeights(values, frames, {0, bound});
        EXPECT_EQ(few.count, 2u);
        EXPECT_NEAR(few.rms, all.rms_of_count[2], 1e-6);
        EXPECT_EQ(principalWeights(values, frames, {3, 0}).count, 3u);
    }
    const PrincipalWeights still = principalWeights(std::vector<float>{0.5f, 0.25f}, 1, {16, 0});
    EXPECT_EQ(still.count, 0u);
    EXPECT_EQ(still.mean, (std::vector<float>{0.5f, 0.25f}));
}

TEST(TurnedToRest, InvertsTurns) {
    Affine turn;  // a quarter turn about z: x to y
    turn.m = {0, -1, 0, 5, 1, 0, 0, 6, 0, 0, 1, 7};
    const std::vector<std::uint16_t> joints{0};
    const std::vector<float> weights{1};
    const PointMotion by_bones{joints, weights, std::span(&turn, 1), {}, {}};
    EXPECT_LT(length(turnedToRest(by_bones, {0, 1, 0}) - Vec3{1, 0, 0}), 1e-6f);
    const PointMotion by_normals{{}, {}, {}, {1, 0, 0}, {0, 1, 0}};
    EXPECT_LT(length(turnedToRest(by_normals, {0, 1, 0}) - Vec3{1, 0, 0}), 1e-6f);
    EXPECT_LT(length(turnedToRest(by_normals, {0, 0, 1}) - Vec3{0, 0, 1}), 1e-6f);
}

namespace {

// Points of a grid, each a source vertex.
class GridSource : public OcclusionSource {
public:
    explicit GridSource(std::uint32_t count) {
        for (std::uint32_t v = 0; v < count; ++v) {
            mesh_.rest_positions.push_back({float(v % 5), float(v / 5), 0});
            mesh_.source_vertex.push_back(v);
            rest_normals_.push_back({0, 0, 1});
        }
        for (std::uint32_t v = 0; v + 6 < count; ++v) mesh_.triangles.push_back({v, v + 1, v + 5});
        frames_ = {{"rest"}, {0}, {0.0}};
    }
    bool hasBounces() const override { return false; }
    OcclusionFrame read(std::size_t, FrameParts, int) const override { return {}; }
};

Rig rigOf(const OcclusionSource& source, const std::vector<std::uint32_t>& order) {
    Rig rig;
    for (const std::uint32_t v : order) {
        rig.mesh.rest_positions.push_back(source.mesh().rest_positions[v]);
        rig.mesh.source_vertex.push_back(std::uint32_t(rig.mesh.source_vertex.size()));
        rig.rest_normals.push_back({0, 0, 1});
    }
    ColoredPart& part = rig.part_colors.emplace_back();
    part.vertices = order.size();
    rig.mesh.slots = {"body/default"};
    return rig;
}

}  // namespace

TEST(MatchRows, FindsVerticesByNumberThenByPlaceAndRefusesOthers) {
    const GridSource source(25);
    std::vector<std::uint32_t> order(25);
    for (std::uint32_t v = 0; v < 25; ++v) order[v] = v;
    EXPECT_EQ(matchRows(source, rigOf(source, order), ExportMesh::kSame, 1).by_place, 0u);
    std::swap(order[3], order[20]);
    order.push_back(7);  // once more, at a seam
    const ExportRows rows = matchRows(source, rigOf(source, order), ExportMesh::kSame, 1);
    EXPECT_EQ(rows.by_place, 26u);
    for (std::size_t r = 0; r < order.size(); ++r) EXPECT_EQ(rows.points.corners[r][0], order[r]);
    Rig other = rigOf(source, order);
    other.mesh.rest_positions[4].z = 0.1f;
    EXPECT_THROW(matchRows(source, other, ExportMesh::kSame, 1), InvalidInput);
    for (Vec3& p : other.mesh.rest_positions) p.z = 1;
    EXPECT_THROW(matchRows(source, other, ExportMesh::kSame, 1), InvalidInput);
    // A second part that the source does not have stays as it is.
    Rig more = rigOf(source, order);
    more.mesh.rest_positions.push_back({0, 0, 9});
    more.rest_normals.push_back({0, 0, 1});
    more.mesh.source_vertex.push_back(26);
    more.part_colors.push_back({{}, 0, 26, 1, {}});
    const ExportRows with_more = matchRows(source, more, ExportMesh::kSame, 1);
    EXPECT_EQ(with_more.parts, (std::vector<std::size_t>{0}));
    EXPECT_EQ(with_more.left_out.size(), 1u);
}

}  // namespace penumbra::test_export
